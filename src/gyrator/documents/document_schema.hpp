#pragma once

#include "gyrator/documents/document_spec.hpp"

#include <string>

namespace gyrator {

/// JSON Schema (draft-07) that accepts what read_document accepts, up to what a schema cannot say:
/// the dimension of a unit, and bounds of a value that is given with one. `id` becomes "$id".
/// Indented text that ends in a line end; the keys are in the order of the spec, and what occurs
/// more than once is in "$defs" (shared_schema.hpp).
std::string write_json_schema(const ObjectSpec& spec, const std::string& id);

/// The same for a document that is one of several (a variant).
std::string write_json_schema(const Member& root, const std::string& id);

/// The same as JSON, with everything in its place and nothing shared.
nlohmann::ordered_json build_json_schema(const Member& root, const std::string& id);

}  // namespace gyrator
