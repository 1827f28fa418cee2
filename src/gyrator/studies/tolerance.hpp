#pragma once

#include "gyrator/core/quantity.hpp"
#include "gyrator/core/tolerance.hpp"
#include "gyrator/documents/document_reader.hpp"
#include "gyrator/mechanics/device.hpp"

#include <span>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

namespace gyrator {

/// A quantity of the model that was written with a tolerance.
struct Tolerance {
  std::string name;     ///< "motor.resistance", "rc.capacitance"; "rc_2.resistance" of a second rc
  std::string pointer;  ///< "/motor/resistance"
  Unit unit;
  double nominal = 0, low = 0, high = 0;  ///< in the unit; low < high
  std::string text;                       ///< as written
};

/// What of a model in normal form says its device, and which of it has a tolerance.
struct DeviceParts {
  nlohmann::json normal;
  std::vector<Tolerance> tolerances;
};

/// `model` in normal form, with the tolerances that its reader found.
DeviceParts find_device_parts(const nlohmann::json& model,
                              const std::vector<GivenTolerance>& given);

/// All devices that a model stands for, one for each choice of its toleranced quantities.
///
/// What a part is varies; what somebody sets does not: the amplifier's gain is that of the nominal
/// device, so that K_t 5 % high gives 5 % more effort per command; a cancelled `fraction`, the
/// estimates that back_emf is given by default, its gain and the resistor of a wave drive are those
/// for the nominal motor (device_document.hpp). So is all of the controller. A setting that has a
/// tolerance of its own (resistance_estimate, fraction, …) varies with that.
class DeviceBox {
 public:
  DeviceBox(Device nominal, DeviceParts parts);

  const std::vector<Tolerance>& tolerances() const { return parts_.tolerances; }
  const Device& nominal() const { return nominal_; }

  /// The device with these values, one for each tolerance, in its order and unit, not checked; a
  /// few microseconds. From many threads at once.
  Device at(std::span<const double> values) const;

  std::vector<double> nominal_values() const;

 private:
  Device nominal_;  // with its gain
  DeviceParts parts_;
  std::vector<nlohmann::json::json_pointer> pointers_;
};

/// Throws bad_input where nothing has a tolerance.
void require_tolerances(const DeviceBox& box);

/// Throws bad_input, at the quantity, where with one of them at an end of its range and the others
/// nominal (or the winding at its coldest with the largest coefficient) no device can be built.
void check_device_box(const DeviceBox& box);

}  // namespace gyrator
