#pragma once

#include "gyrator/circuits/spice_subcircuit.hpp"

#include "support/device_list.hpp"

namespace gyrator::testing {

/// Every way in which a drive is not linear, around the RC-damped display.
inline std::vector<NamedDevice> make_nonlinear_devices() {
  std::vector<NamedDevice> list;
  const auto add = [&](const char* name, const auto& change) {
    Device device = make_rc_display();
    change(device);
    list.push_back({name, device});
  };
  add("friction brake", [](Device& d) {
    d.drive.damping.emplace_back(FrictionBrake{.damping = 1e-3, .effort = 2e-4});
  });
  add("clamp", [](Device& d) {
    d.drive.damping.emplace_back(ClampDamping{.voltage = 0.02, .resistance = 0.1});
  });
  add("current limit", [](Device& d) {
    d.drive.amplifier = CurrentAmplifier{.bandwidth_hz = {}, .current_limit = 0.01};
  });
  add("current limit, 400 Hz", [](Device& d) {
    d.drive.amplifier = CurrentAmplifier{.bandwidth_hz = 400, .current_limit = 0.01};
  });
  add("voltage limit", [](Device& d) {
    d.drive.amplifier = CurrentAmplifier{.bandwidth_hz = {}, .voltage_limit = 0.02};
  });
  add("voltage limit without damping", [](Device& d) {
    d.drive.amplifier = CurrentAmplifier{.bandwidth_hz = {}, .voltage_limit = 0.02};
    d.drive.damping.clear();
  });
  add("motor sensed, both limits", [](Device& d) {
    d.drive.amplifier = CurrentAmplifier{.bandwidth_hz = 200,
                                         .sense = CurrentSense::motor,
                                         .current_limit = 0.02,
                                         .voltage_limit = 0.03};
  });
  add("voltage amplifier, both limits", [](Device& d) {
    d.drive.amplifier = VoltageAmplifier{.bandwidth_hz = 800,
                                         .output_resistance = 0.7,
                                         .current_limit = 0.01,
                                         .voltage_limit = 0.05};
  });
  add("warming winding", [](Device& d) {
    d.drive.motor->temperature_rise = 20;
    d.drive.motor->thermal = WindingThermal{.resistance = 8, .capacity = 1e-4};
  });
  const auto netlist = [](const char* lines) {
    return NetlistDamping{
        parse_subcircuit(std::string(".subckt s a b\n") + lines + "\n.ends\n", "test.cir", "s")};
  };
  add("antiparallel diodes", [&](Device& d) {
    d.drive.damping.emplace_back(netlist("D1 a b X\nD2 b a X\n.model X D(Is=10m Rs=50m)"));
  });
  add("op-amp at its limits", [&](Device& d) {
    // A resistance of 0.25 ohm, as long as the output can follow.
    d.drive.damping.emplace_back(
        netlist("X1 m b o opamp Aol=1k GBW=100k Vmax=30m\nR1 a m 1k\nR2 m o 3k\nR3 a o 1"));
  });
  add("all at once", [](Device& d) {
    d.drive.motor->thermal = WindingThermal{.resistance = 8, .capacity = 1e-4};
    d.drive.amplifier =
        CurrentAmplifier{.bandwidth_hz = 400, .current_limit = 0.03, .voltage_limit = 0.04};
    d.drive.damping.emplace_back(ClampDamping{.voltage = 0.02, .resistance = 0.1});
    d.drive.damping.emplace_back(FrictionBrake{.damping = 1e-3, .effort = 2e-4});
  });
  return list;
}

}  // namespace gyrator::testing
