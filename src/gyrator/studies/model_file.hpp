#pragma once

#include "gyrator/cosim/simulation.hpp"
#include "gyrator/mechanics/device.hpp"
#include "gyrator/passivity/verdict.hpp"
#include "gyrator/studies/tolerance.hpp"

#include <cstdint>
#include <optional>
#include <string>

#include <nlohmann/json.hpp>

namespace gyrator {

/// Everything a model file says, validated, in SI units.
struct Model {
  std::string name;  ///< free of control characters
  std::string file;  ///< for messages
  Device device;
  Sensor sensor;
  Controller controller;
  Sampling sampling;
  Dac dac;
  Operator held_by = FreeOperator{};
  Rational duration{1, 2};
  double initial_position = 0;
  double initial_velocity = 0;
  double external_effort = 0;
  std::optional<HandGesture> gesture;
  std::uint64_t seed = 1;
  DeviceParts parts;      ///< of the device, with their tolerances
  nlohmann::json source;  ///< the file as the user wrote it, for results and reports

  /// The law that is left to the sampled loop: none where an analog loop does the wall.
  Controller sampled_controller() const;

  /// All devices that the tolerances allow.
  DeviceBox device_box() const { return {device, parts}; }

  PassivityModel passivity_model() const {
    return {device, sampled_controller(), sampling, sensor.quantum};
  }
};

/// Reads and validates a model file. Throws bad_input with file and JSON path.
Model load_model(const std::string& path);

/// The same from JSON; `file` is only for messages.
Model parse_model(const nlohmann::json& document, const std::string& file);

/// Unit texts of a motion for results: keys damping, stiffness, position, velocity, effort,
/// inertia.
nlohmann::json unit_names(Motion motion);

}  // namespace gyrator
