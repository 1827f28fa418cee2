#pragma once

#include "gyrator/documents/document_spec.hpp"
#include "gyrator/studies/motion_terms.hpp"

namespace gyrator {

/// The model file as a table: keys, units, defaults, bounds and one sentence each. From it follow
/// the reader, the JSON Schema (schemas/model.schema.json) and the manual's reference.
/// The document is one of two, rotary or linear, told apart by its key "motion".
const Member& model_format();

/// The version text that a model file begins with.
inline constexpr const char* model_schema_name = "gyrator/model/1";

}  // namespace gyrator
