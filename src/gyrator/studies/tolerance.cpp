#include "gyrator/studies/tolerance.hpp"

#include "gyrator/core/error.hpp"
#include "gyrator/studies/device_document.hpp"

#include <algorithm>
#include <utility>

#include <fmt/core.h>

namespace gyrator {
namespace {

using nlohmann::json;
using Pointer = json::json_pointer;

// "rc" for the first of its kind in the list, "rc_2" for the second.
std::string name_of_damping(const json& list, std::size_t index) {
  const std::string kind = list[index]["kind"];
  const auto last = list.begin() + static_cast<std::ptrdiff_t>(index);
  const auto before =
      std::count_if(list.begin(), last, [&](const json& d) { return d["kind"] == kind; });
  return before == 0 ? kind : fmt::format("{}_{}", kind, before + 1);
}

std::string name_of(const json& model, const std::string& pointer) {
  std::string name = pointer.substr(1);
  std::replace(name.begin(), name.end(), '/', '.');
  constexpr std::string_view list = "damping.";
  if (!name.starts_with(list)) return name;
  const std::size_t dot = name.find('.', list.size());
  const std::size_t index = std::stoul(name.substr(list.size(), dot - list.size()));
  return name_of_damping(model["damping"], index) + name.substr(dot);
}

void check_build(const Device& device, const Tolerance& tolerance, const char* end, double value) {
  try {
    build_device_network(device, FreeOperator{});
  } catch (const Error& error) {
    throw Error(
        error.code(), tolerance.pointer.substr(1),
        fmt::format("'{}', at its {} end {}: {} (at /{})", tolerance.text, end,
                    format_quantity(value, tolerance.unit), error.message(), error.place()));
  }
}

// R_m (1 + alpha rise) is least with the smallest rise and, where that is negative, the largest
// coefficient.
void check_coldest_winding(const DeviceBox& box) {
  std::vector<double> values = box.nominal_values();
  const Tolerance* rise = nullptr;
  const Tolerance* coefficient = nullptr;
  for (std::size_t i = 0; i < values.size(); ++i) {
    const Tolerance& tolerance = box.tolerances()[i];
    if (tolerance.pointer == "/motor/temperature_rise") {
      rise = &tolerance;
      values[i] = tolerance.low;
    } else if (tolerance.pointer == "/motor/temperature_coefficient") {
      coefficient = &tolerance;
      values[i] = tolerance.high;
    }
  }
  const Tolerance* named = rise ? rise : coefficient;
  if (!named || box.at(values).drive.motor->warm_resistance() > 0) return;
  throw Error(
      ErrorCode::bad_input, named->pointer.substr(1),
      fmt::format("'{}': at its coldest the winding would have no resistance left; with its "
                  "largest temperature_coefficient it must stay above {}",
                  named->text,
                  format_quantity(-1 / box.at(values).drive.motor->temperature_coefficient,
                                  dimension::temperature)));
}

}  // namespace

DeviceParts find_device_parts(const json& model, const std::vector<GivenTolerance>& given) {
  DeviceParts parts;
  for (const char* key : {"motor", "mechanics", "amplifier", "damping"})
    parts.normal[key] = model[key];
  // A held impedance has its gains from there; a copy of other controllers is only slow.
  const bool is_held = std::any_of(model["damping"].begin(), model["damping"].end(),
                                   [](const json& d) { return d["kind"] == "held_impedance"; });
  parts.normal["controller"] = is_held ? model["controller"] : json();
  for (const GivenTolerance& g : given) {
    parts.tolerances.push_back({name_of(model, g.pointer), g.pointer, g.unit, g.value.nominal,
                                g.value.low, g.value.high, g.text});
  }
  return parts;
}

DeviceBox::DeviceBox(Device nominal, DeviceParts parts)
    : nominal_(std::move(nominal)), parts_(std::move(parts)) {
  nominal_.gain = find_amplifier_gain(nominal_);
  for (const Tolerance& tolerance : parts_.tolerances) pointers_.emplace_back(tolerance.pointer);
}

Device DeviceBox::at(std::span<const double> values) const {
  json model = parts_.normal;
  for (std::size_t i = 0; i < pointers_.size(); ++i) model[pointers_[i]] = values[i];
  Device device = nominal_;
  device.drive = make_drive(model, nominal_.drive);
  device.mechanics = make_mechanics(model["mechanics"]);
  return device;
}

std::vector<double> DeviceBox::nominal_values() const {
  std::vector<double> values;
  for (const Tolerance& tolerance : parts_.tolerances) values.push_back(tolerance.nominal);
  return values;
}

void require_tolerances(const DeviceBox& box) {
  if (!box.tolerances().empty()) return;
  throw Error(ErrorCode::bad_input, "",
              "no quantity has a tolerance: write one in motor, mechanics, amplifier or damping, "
              "such as \"resistance\": \"5 ohm ± 5 %\"");
}

void check_device_box(const DeviceBox& box) {
  check_coldest_winding(box);
  std::vector<double> values = box.nominal_values();
  for (std::size_t i = 0; i < values.size(); ++i) {
    const Tolerance& tolerance = box.tolerances()[i];
    for (const bool low : {true, false}) {
      values[i] = low ? tolerance.low : tolerance.high;
      check_build(box.at(values), tolerance, low ? "low" : "high", values[i]);
    }
    values[i] = tolerance.nominal;
  }
}

}  // namespace gyrator
