#include "gyrator/studies/operating_point_fields.hpp"

#include "gyrator/circuits/operating_point.hpp"
#include "gyrator/studies/model_format.hpp"

#include <cmath>
#include <map>
#include <string_view>

namespace gyrator {
namespace {

using nlohmann::json;

json bound(double value) {
  return std::isfinite(value) ? json(value) : json(nullptr);
}

const char* name_of(LinearRange::Quantity quantity) {
  using enum LinearRange::Quantity;
  switch (quantity) {
    case voltage:
      return "voltage";
    case current:
      return "current";
    case velocity:
      return "velocity";
    case effort:
      return "effort";
    case command:
      return "command";
    case temperature_rise:
      break;
  }
  return "temperature_rise";
}

}  // namespace

nlohmann::json make_operating_point_fields(const Model& model) {
  const Network network = build_device_network(model.device, FreeOperator{}).network;
  if (network.is_linear()) return nullptr;
  const MotionUnits& motion = units_of(model.device.motion);
  const std::map<std::string, std::string_view> units{{"voltage", "V"},
                                                      {"current", "A"},
                                                      {"velocity", motion.velocity.symbol},
                                                      {"effort", motion.effort.symbol},
                                                      {"command", motion.effort.symbol},
                                                      {"temperature_rise", "K"}};
  json ranges = json::array();
  for (const LinearRange& range : find_linear_ranges(network)) {
    const std::string quantity = name_of(range.quantity);
    ranges.push_back({{"element", network.element(range.element).name},
                      {"quantity", quantity},
                      {"unit", units.at(quantity)},
                      {"at", range.at},
                      {"from", bound(range.from)},
                      {"to", bound(range.to)}});
  }
  return {{"command", 0}, {"linear_range", ranges}};
}

std::optional<std::string> find_nonlinear_element(const Model& model) {
  const DeviceNetwork device = build_device_network(model.device, model.held_by);
  if (const auto element = device.network.find_nonlinear())
    return device.network.element(*element).name;
  if (device.friction) return "mechanics.friction";
  if (device.stops) return "mechanics.stops";
  return std::nullopt;
}

}  // namespace gyrator
