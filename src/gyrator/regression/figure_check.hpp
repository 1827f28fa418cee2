#pragma once

#include "gyrator/regression/regression_study.hpp"

#include <cstddef>
#include <optional>
#include <string>

#include <nlohmann/json.hpp>

namespace gyrator {

/// Why a value is not what it is compared with:
/// "15.2 N/m, baseline 15.84 N/m ± 0.0001 %: 4.04 % lower", in front of it "[3]: " of a list's
/// item.
struct Difference {
  std::string reason;
  std::optional<std::size_t> item;  ///< of the outermost list, where the reason is an item's
};

/// Compares an answer's figure with a reference of the same shape:
///   |v - r| <= absolute + relative |r|     on the side(s) that count                   (study-1)
/// Texts, booleans and nulls must be equal. Of a list every item, the worst of them is told; a
/// difference of length, of type, and a number that is none any more are differences too.
/// `what` names the reference, "baseline".
std::optional<Difference> find_difference(const nlohmann::json& value,
                                          const nlohmann::json& reference,
                                          const FigureTolerance& tolerance, const std::string& unit,
                                          const std::string& what);

/// Whether a figure, or each item of a list, keeps the bounds and the exact value; a single
/// `equals` is that of every item. A list without items keeps none of them.
std::optional<Difference> find_violation(const nlohmann::json& value,
                                         const Expectation& expectation);

/// "15.84 N/m", "[15.84, 7.96] N/m", "passive", "none"; long lists shortened.
std::string describe_figure(const nlohmann::json& value, const std::string& unit);

/// "± 0.0001 %", "± 0.1 N/m ± 0.1 %", "- 1 %" (only below counts), "exactly".
std::string describe_tolerance(const FigureTolerance& tolerance, const std::string& unit);

}  // namespace gyrator
