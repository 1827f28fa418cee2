#pragma once

#include "support/device_list.hpp"

namespace gyrator::testing {

/// Devices with dry friction and hard stops, alone and beside amplifiers with limits: every mode
/// that a plant can be in. Their own units are those of make_rc_display().
inline std::vector<NamedDevice> make_contact_devices() {
  std::vector<NamedDevice> list;
  const auto add = [&](const char* name, const auto& change) {
    Device device = make_rc_display();
    change(device);
    list.push_back({name, device});
  };
  const auto rub = [](Device& d) {
    d.mechanics.coulomb_friction = 4e-4;
    d.mechanics.stiction = 7e-4;
  };
  const HardStops stops{.lower = -0.006, .upper = 0.007, .stiffness = 6, .damping = 2e-3};
  add("friction", [&](Device& d) { d.mechanics.coulomb_friction = 5e-4; });
  add("stiction", rub);
  add("stiction with Stribeck's fall", [&](Device& d) {
    rub(d);
    d.mechanics.stribeck_velocity = 0.1;
  });
  add("stops", [&](Device& d) { d.mechanics.stops = stops; });
  add("all contacts, compliant, sensed at the motor", [&](Device& d) {
    rub(d);
    d.mechanics.stops = stops;
    d.mechanics.transmission = Transmission{.stiffness = 20, .damping = 1e-3, .load_inertia = 1e-5};
    d.sensor = SensorLocation::motor;
  });
  add("stiction, current limit", [&](Device& d) {
    rub(d);
    d.drive.amplifier = CurrentAmplifier{.bandwidth_hz = 400, .current_limit = 0.03};
  });
  add("all contacts, voltage amplifier with limits", [&](Device& d) {
    rub(d);
    d.mechanics.stribeck_velocity = 0.05;
    d.mechanics.stops = stops;
    d.drive.amplifier = VoltageAmplifier{
        .bandwidth_hz = 800, .output_resistance = 0.7, .current_limit = 0.05, .voltage_limit = 0.1};
  });
  return list;
}

}  // namespace gyrator::testing
