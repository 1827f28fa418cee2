#pragma once

#include "gyrator/core/tolerance.hpp"
#include "gyrator/documents/document_spec.hpp"

#include <string>
#include <vector>

#include <nlohmann/json.hpp>

namespace gyrator {

/// The document in normal form: every member of the spec present, defaults filled in, null for
/// what is optional and absent; quantities are numbers in SI units, exact times texts "num/den"
/// (Rational::from_text), the discriminator of a variant always there. Reading the normal form
/// again gives the same.
///
/// "$schema" at the top, which editors use, is allowed and dropped.
/// Throws bad_input for the first thing wrong, at "FILE: /json/pointer" (only the pointer for an
/// empty file name): an unknown key, a missing member, a wrong type, dimension, kind or choice, a
/// value out of bounds, members that exclude one another.
nlohmann::json read_document(const nlohmann::json& document, const ObjectSpec& spec,
                             const std::string& file);

/// The same for a document that is one of several, told apart by a key at its top (a variant).
nlohmann::json read_document(const nlohmann::json& document, const Member& root,
                             const std::string& file);

/// A quantity that was written with a tolerance; the normal form has its nominal value.
struct GivenTolerance {
  std::string pointer;  ///< "/damping/0/resistance"
  Unit unit;
  TolerancedValue value;
  std::string text;  ///< as written
};

struct ReadDocument {
  nlohmann::json normal;
  std::vector<GivenTolerance> tolerances;  ///< in the order of the keys' table; none of zero width
};

/// read_document, and the tolerances beside the normal form. Both ends must be allowed values.
ReadDocument read_document_with_tolerances(const nlohmann::json& document, const Member& root,
                                           const std::string& file);

}  // namespace gyrator
