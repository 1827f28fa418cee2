#pragma once

#include "gyrator/documents/document_spec.hpp"

#include <string>

namespace gyrator {

/// JSON Schema (draft-07) that accepts what read_document accepts, up to what a schema cannot say:
/// the dimension of a unit, and bounds of a value that is given with one. `id` becomes "$id".
/// Indented text that ends in a line end; the keys are in the order of the spec.
std::string write_json_schema(const ObjectSpec& spec, const std::string& id);

/// The same for a document that is one of several (a variant).
std::string write_json_schema(const Member& root, const std::string& id);

}  // namespace gyrator
