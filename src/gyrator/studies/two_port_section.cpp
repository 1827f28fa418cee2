#include "gyrator/studies/two_port_section.hpp"

#include "gyrator/plots/html.hpp"
#include "gyrator/plots/pretty_text.hpp"
#include "gyrator/studies/result_fields.hpp"

#include <algorithm>
#include <string>
#include <vector>

namespace gyrator {
namespace {

using nlohmann::json;

HtmlCell answer(const json& condition) {
  const std::string word = optional_flag(condition, "holds", true) ? "yes" : "no";
  return {word, word};
}

std::string bands_in_words(const json& condition) {
  if (optional_flag(condition, "holds", true)) return "–";
  std::string text;
  for (const auto& band : required_array(condition, "violated_hz", "twoport result: /conditions")) {
    if (!band.is_array() || band.size() != 2 || !band[0].is_number() || !band[1].is_number())
      continue;
    if (!text.empty()) text += ", ";
    text += pretty_frequency(band[0].get<double>(), 3) + " to " +
            pretty_frequency(band[1].get<double>(), 3);
  }
  return text;
}

// The third condition's margin is a pure number.
std::string unit_in_words(const json& condition) {
  const auto unit = optional_text(condition, "unit");
  return unit == "1" ? "" : unit;
}

std::string name_in_words(const json& part) {
  auto name = optional_text(part, "rendering");
  std::replace(name.begin(), name.end(), '_', ' ');
  return name == "remote" ? "two devices" : name;
}

}  // namespace

ReportSection two_port_section(const json& result) {
  std::vector<std::vector<HtmlCell>> rows;
  for (const auto& part : required_array(result, "renderings", "twoport result")) {
    for (const auto& condition : required_array(part, "conditions", "twoport result: /renderings"))
      rows.push_back(
          {{name_in_words(part)},
           {optional_text(condition, "condition")},
           answer(condition),
           {pretty_quantity(optional_number(condition, "margin"), unit_in_words(condition)),
            "number"},
           {pretty_frequency(optional_number(condition, "worst_frequency_hz")), "number"},
           {bands_in_words(condition)}});
  }
  return {"Two-port between operator and environment",
          html_table({"Two-port", "Condition", "Holds", "Lowest margin", "At", "Violated"}, rows),
          "Where all three conditions hold at every frequency, no passive operator and no passive "
          "environment can make the two-port between them unstable; where the last ratio is 1 the "
          "operator feels the environment itself."};
}

std::string two_port_sentence(const json& result) {
  const bool remote = has(result, "remote");
  const auto what = remote ? std::string("the coupling of the two devices")
                           : "rendering by " + name_in_words(result);
  if (optional_flag(result, "absolutely_stable", false))
    return "Absolutely stable: " + what +
           " stays stable between every passive operator and environment.";
  std::string text = "Not absolutely stable: " + what +
                     " breaks a condition of stability between passive operators and environments";
  if (!has(result, "least_felt_damping")) return text + ".";
  const double felt = optional_number(result["least_felt_damping"], "value");
  if (!(felt < 0)) return text + ".";
  return text + "; " + pretty_quantity(-felt, unit_of(result, "damping"), 3) +
         " of damping are missing at the operator's port.";
}

}  // namespace gyrator
