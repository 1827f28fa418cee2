#pragma once

#include <string>
#include <vector>

#include <nlohmann/json.hpp>

namespace gyrator {

// Reading what the commands' JSON results hold. A null where a number belongs means "no number"
// (JSON has none for NaN and infinity) and reads as NaN. Each throws bad_input, whose place names
// the command and the key, where the key is missing or of the wrong kind.

/// The "command" of a result.
std::string command_of(const nlohmann::json& result);

/// The member `key` of `object`, which is a result or a part of it called `place`.
const nlohmann::json& required(const nlohmann::json& object, const std::string& key,
                               const std::string& place);
const nlohmann::json& required_array(const nlohmann::json& object, const std::string& key,
                                     const std::string& place);
double required_number(const nlohmann::json& object, const std::string& key,
                       const std::string& place);
std::vector<double> required_numbers(const nlohmann::json& object, const std::string& key,
                                     const std::string& place);

/// NaN where the key is missing or null.
double optional_number(const nlohmann::json& object, const std::string& key);
/// `otherwise` where the key is missing or no boolean.
bool optional_flag(const nlohmann::json& object, const std::string& key, bool otherwise);
/// Empty where the key is missing or no string.
std::string optional_text(const nlohmann::json& object, const std::string& key);
/// Whether the key is there and neither null nor empty.
bool has(const nlohmann::json& object, const std::string& key);

/// The unit of a quantity from the result's "units"; "inertia", "current", "energy" and
/// "response" (position per effort) follow from the others where they are not named.
std::string unit_of(const nlohmann::json& result, const std::string& quantity);

/// "subject: name of the model".
std::string figure_title(const nlohmann::json& result, const std::string& subject);

/// The entry of passivity's "criteria" with that name; null where there is none.
nlohmann::json find_criterion(const nlohmann::json& passivity, const std::string& name);

/// A criterion in a few plain words: "textbook, Re Z + bᵥ > 0" for "frequency_dependent".
/// An unknown name comes back as it is.
std::string criterion_title(const std::string& name);

/// The counterexample's operator in plain words: "a plain inertia of 3.6×10⁻³ kg·m² held in the
/// hand".
std::string operator_in_words(const nlohmann::json& passivity);

/// How the textbook's limit and the exact disk's compare on one model.
struct Finding {
  bool textbook_holds = false;
  bool exact_holds = false;
  double textbook_limit = 0;  ///< largest stiffness; NaN where not known
  double true_limit = 0;      ///< largest stiffness; NaN where not known

  /// The textbook calls passive what some operator drives unstable: this wall, or one between the
  /// two limits. Limits within 5 % count as the same.
  bool unsafe() const {
    return (textbook_holds && !exact_holds) || textbook_limit > 1.05 * true_limit;
  }
  /// The verdicts or the limits differ, one way or the other.
  bool disagree() const {
    return unsafe() || textbook_holds != exact_holds || true_limit > 1.05 * textbook_limit;
  }
};

/// The finding in a passivity result: holds false, limits NaN where it has not both criteria, so
/// that it does not disagree.
Finding finding_of(const nlohmann::json& passivity);

}  // namespace gyrator
