#include "linear_range_text.hpp"

#include "gyrator/core/quantity.hpp"
#include "gyrator/studies/model_format.hpp"

#include <fmt/core.h>

namespace gyrator::app {
namespace {

Unit unit_of(const std::string& quantity, const MotionUnits& units) {
  if (quantity == "voltage") return dimension::voltage;
  if (quantity == "current") return dimension::current;
  if (quantity == "velocity") return units.velocity;
  if (quantity == "temperature_rise") return dimension::temperature;
  return units.effort;
}

std::string describe_range(const nlohmann::json& range, const MotionUnits& units) {
  std::string quantity = range["quantity"];
  const Unit unit = unit_of(quantity, units);
  if (quantity == "temperature_rise") quantity = "temperature rise";
  const auto& from = range["from"];
  const auto& to = range["to"];
  const auto text = [&](const nlohmann::json& value) { return format_quantity(value, unit); };
  if (from.is_null() && to.is_null()) return "always";
  if (from.is_null()) return fmt::format("{} < {}", quantity, text(to));
  if (to.is_null()) return fmt::format("{} > {}", quantity, text(from));
  if (from.get<double>() == -to.get<double>()) return fmt::format("|{}| < {}", quantity, text(to));
  return fmt::format("{} from {} to {}", quantity, text(from), text(to));
}

}  // namespace

std::string describe_linear_range(const Model& model, const nlohmann::json& result) {
  const auto& point = result["operating_point"];
  if (point.is_null()) return "";
  std::string text =
      "\nThe model is not linear. This answer is for small motion around command 0 and a port at "
      "rest;\nit holds (slopes within 1 %) for\n";
  for (const auto& range : point["linear_range"]) {
    text += fmt::format("  {:<28}{}\n", range["element"].get<std::string>(),
                        describe_range(range, units_of(model.device.motion)));
  }
  return text;
}

}  // namespace gyrator::app
