#pragma once

#include <string>
#include <string_view>

#include <nlohmann/json.hpp>

namespace gyrator {

/// Throws bad_input where a document says by its key "schema" that it is a file of this program of
/// another kind than `expected` ("gyrator/model/1"), naming both kinds and the command that reads
/// it. A document without that key, or with another text in it, is left to its reader.
void check_document_kind(const nlohmann::json& document, std::string_view expected,
                         const std::string& file);

}  // namespace gyrator
