#include "gyrator/synthesis/rated_model.hpp"

#include <utility>

#include <fmt/core.h>

namespace gyrator {
namespace {

using nlohmann::json;

// "470 uF" where that reads as the very same number, else all its digits.
std::string write_value(double value, const Unit& unit) {
  const std::string text = format_quantity(value, unit);
  const auto reads_back = [&] { return parse_value(text, unit) == value; };
  if (unit == dimension::none) return fmt::format("{:.17g}", value);
  return reads_back() ? text : fmt::format("{:.17g} {}", value, unit.symbol);
}

}  // namespace

json make_rated_model(const DesignSpec& spec, const Candidate& candidate, double stiffness) {
  std::vector<json> values;
  for (std::size_t i = 0; i < candidate.values.size(); ++i) {
    const SoughtValue& variable = candidate.option->values[i];
    const double tolerance = spec.tolerances.at(variable.part);
    std::string text = write_value(candidate.values[i], variable.unit);
    if (tolerance > 0) text += fmt::format(" ± {:g} %", 100 * tolerance);
    if (variable.unit == dimension::none) {
      values.emplace_back(candidate.values[i]);
    } else {
      values.emplace_back(std::move(text));
    }
  }
  json model = make_designed_model(spec, *candidate.option, values);
  model["name"] = fmt::format("{}, {}", spec.model.name, candidate.option->topology->name);
  if (!model.contains("controller")) model["controller"] = {{"kind", "virtual_wall"}};
  model["controller"]["stiffness"] = stiffness;
  model["controller"]["damping"] = spec.damping.front();
  if (spec.winding_rise && spec.winding_rise->low < spec.winding_rise->high) {
    model["motor"]["temperature_rise"] = fmt::format(
        "{:.17g} K ({:.17g} K to {:.17g} K)", spec.model.device.drive.motor->temperature_rise,
        spec.winding_rise->low, spec.winding_rise->high);
  }
  return model;
}

}  // namespace gyrator
