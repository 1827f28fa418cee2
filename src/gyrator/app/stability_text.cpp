#include "stability_text.hpp"

#include "gyrator/core/quantity.hpp"

#include <fmt/core.h>

namespace gyrator::app {
namespace {

std::string describe_rises(const nlohmann::json& edge) {
  const auto text = [&](const char* key) {
    return format_quantity(edge[key].get<double>(), dimension::temperature);
  };
  const bool cold = !edge["coldest_rise"].is_null();
  const bool hot = !edge["hottest_rise"].is_null();
  if (cold && hot)
    return fmt::format("winding between {} and {}", text("coldest_rise"), text("hottest_rise"));
  if (cold) return fmt::format("winding above {}", text("coldest_rise"));
  if (hot) return fmt::format("winding below {}", text("hottest_rise"));
  return "winding at any temperature";
}

}  // namespace

std::string describe_stability_edges(const Model& model, const nlohmann::json& result) {
  const auto& edges = result["stability_edges"];
  if (edges.is_null()) return "";
  std::string text = fmt::format(
      "\nThe drive alone is stable with (temperature rises; now {}):\n",
      format_quantity(model.device.drive.motor->temperature_rise, dimension::temperature));
  for (const char* held : {"clamped", "free"}) {
    const auto& edge = edges[held];
    text += fmt::format("  port {:<8}", held);
    if (!edge["cancellation"].is_null()) {
      text += fmt::format("cancellation below {}, ",
                          format_quantity(edge["cancellation"], dimension::resistance));
    }
    text += describe_rises(edge) + "\n";
  }
  return text;
}

}  // namespace gyrator::app
