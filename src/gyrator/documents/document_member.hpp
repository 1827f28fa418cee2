#pragma once

#include "gyrator/documents/document_spec.hpp"

#include <string_view>

#include <nlohmann/json.hpp>

namespace gyrator {

/// One value of a document, with what its table says of it.
struct FoundMember {
  nlohmann::json::json_pointer pointer;
  Member member;  ///< of a list's item: the list's, no list itself
};

/// The member that a dotted path names, "damping.0.capacitance", in a document in normal form
/// (read_document); items of lists by their number from 0.
/// Throws bad_input, without a place, for an unknown key (with the nearest), a number beyond the
/// list, an object that the document does not have, a path that ends at an object or a list, and
/// for the key that decides which others there are ("kind").
FoundMember find_member(const nlohmann::json& normal, const Member& root, std::string_view path);

}  // namespace gyrator
