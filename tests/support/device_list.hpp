#pragma once

#include "gyrator/mechanics/device.hpp"

#include <string>
#include <vector>

namespace gyrator::testing {

/// Teaching plant P3 of the reference cases: 0.04 kg, 0.8 N.s/m, ideal drive.
inline Device make_p3() {
  Device device;
  device.motion = Motion::linear;
  device.mechanics.inertia = 0.04;
  device.mechanics.damping = 0.8;
  return device;
}

/// maxon RE25 10 W 118743, as in the reference cases.
inline Motor make_re25_motor() {
  return {.torque_constant = 23.5e-3, .resistance = 2.06, .inductance = 0.238e-3};
}
inline Device make_re25() {
  Device device;
  device.drive.motor = make_re25_motor();
  device.drive.amplifier = CurrentAmplifier{};
  device.mechanics.inertia = 1.07e-6;
  device.mechanics.damping = 1.2e-6;
  return device;
}

/// The RC-damped rotary display that the interface shows as its example model.
inline Device make_rc_display() {
  Device device;
  device.drive.motor = Motor{.torque_constant = 0.05, .resistance = 1.5, .inductance = 0.5e-3};
  device.drive.amplifier = CurrentAmplifier{};
  device.drive.damping = {RcDamping{.resistance = 5, .capacitance = 2200e-6}};
  device.mechanics.inertia = 2e-5;
  device.mechanics.damping = 1e-4;
  return device;
}

struct NamedDevice {
  std::string name;
  Device device;
};

/// Kinds of damping that need not meet every amplifier, warm windings, and mixtures.
inline std::vector<NamedDevice> make_fed_back_devices() {
  Device device = make_rc_display();
  std::vector<NamedDevice> list;
  const auto add = [&](const std::string& name, const Amplifier& amplifier,
                       std::vector<Damping> damping, double rise = 0) {
    Device varied = device;
    varied.drive.amplifier = amplifier;
    varied.drive.damping = std::move(damping);
    varied.drive.motor->temperature_rise = rise;
    list.push_back({name, varied});
  };
  const CurrentAmplifier current{.bandwidth_hz = 400};
  const VoltageAmplifier voltage{.bandwidth_hz = 800, .output_resistance = 0.7};
  const ResistanceCancellation cancellation{.resistance = 1, .bandwidth_hz = {}};
  const TorqueSensedDamper sensed{.damping = 2e-4, .cutoff_hz = 20};
  BackEmfDamping back_emf{.damping = 3e-4,
                          .resistance_estimate = 1.5,
                          .inductance_estimate = 0.5e-3,
                          .low_pass_hz = {},
                          .high_pass_hz = {}};
  add("1 ohm cancelled", VoltageAmplifier{}, {cancellation});
  add("1 ohm cancelled, warm", voltage, {cancellation}, 30);
  add("back-EMF, unfiltered", CurrentAmplifier{}, {back_emf});
  back_emf.high_pass_hz = 2;
  add("back-EMF, high-pass, warm", current, {back_emf}, 40);
  back_emf.low_pass_hz = 200;
  add("back-EMF, band-pass", voltage, {back_emf});
  add("torque-sensed damper", current, {sensed});
  add("eddy-current brake", current, {EddyCurrentBrake{.damping = 2e-4, .on = true}});
  add("all feedback and an RC branch", voltage,
      {RcDamping{.resistance = 5, .capacitance = 2200e-6}, cancellation, back_emf, sensed,
       HighPassDamper{.inertia = 5e-6, .damping = 1e-3}});
  device.mechanics.transmission =
      Transmission{.stiffness = 20, .damping = 1e-3, .load_inertia = 1e-5};
  device.sensor = SensorLocation::motor;
  add("torque-sensed damper, compliant, sensor at the motor", current, {sensed});
  return list;
}

/// Devices whose wall is an analog loop: without a command they are not at rest anywhere but at
/// the centre.
inline std::vector<NamedDevice> make_held_devices() {
  const HeldImpedance loop{.stiffness = 0.05, .damping = 1e-4, .bandwidth_hz = {}};
  Device device = make_rc_display();
  device.drive = {};
  std::vector<NamedDevice> list;
  const auto add = [&](const std::string& name, const HeldImpedance& held) {
    list.push_back({name, device});
    list.back().device.drive.damping.emplace_back(held);
  };
  add("held impedance", loop);
  device = make_rc_display();
  device.drive.amplifier = CurrentAmplifier{.bandwidth_hz = 400};
  add("held impedance, rc", {.stiffness = 0.05, .damping = 1e-4, .bandwidth_hz = 2e3});
  device.mechanics.transmission =
      Transmission{.stiffness = 20, .damping = 1e-3, .load_inertia = 1e-5};
  add("held impedance, rc, compliant", loop);
  device.sensor = SensorLocation::motor;
  add("held impedance, rc, compliant, sensor at the motor", loop);
  return list;
}

/// Every kind of amplifier with every kind of damping, then every kind of mechanics and sensor
/// place: the list over which physical identities are tested.
///
/// Left out: damping under an ideal amplifier that senses the motor current. A step of the command
/// is an impulse of voltage there, and the heat in the branch infinite. drive_test and
/// energy_ledger_test look at it on their own.
inline std::vector<NamedDevice> make_device_list() {
  const std::vector<std::pair<std::string, Amplifier>> amplifiers{
      {"ideal", IdealDrive{}},
      {"current", CurrentAmplifier{}},
      {"current 400 Hz", CurrentAmplifier{.bandwidth_hz = 400}},
      {"current, motor sensed", CurrentAmplifier{.bandwidth_hz = {}, .sense = CurrentSense::motor}},
      {"current 100 Hz, motor sensed",
       CurrentAmplifier{.bandwidth_hz = 100, .sense = CurrentSense::motor}},
      {"voltage", VoltageAmplifier{}},
      {"voltage 800 Hz, 0.7 ohm", VoltageAmplifier{.bandwidth_hz = 800, .output_resistance = 0.7}},
  };
  const std::vector<std::pair<std::string, std::vector<Damping>>> dampings{
      {"no damping", {}},
      {"10 ohm", {ResistorDamping{10}}},
      {"5 ohm 2200 uF", {RcDamping{.resistance = 5, .capacitance = 2200e-6}}},
      {"47 uF", {RcDamping{.capacitance = 47e-6}}},
      {"30 ohm and 8 ohm 100 uF",
       {ResistorDamping{30}, RcDamping{.resistance = 8, .capacitance = 100e-6}}},
      {"5 ohm 2200 uF, 1 ohm cancelled",
       {RcDamping{.resistance = 5, .capacitance = 2200e-6},
        ResistanceCancellation{.resistance = 1, .bandwidth_hz = 5e3}}},
      {"back-EMF, wrong estimates",
       {BackEmfDamping{.damping = 3e-4,
                       .resistance_estimate = 1.3,
                       .inductance_estimate = 0.4e-3,
                       .low_pass_hz = 300,
                       .high_pass_hz = {}}}},
  };
  std::vector<NamedDevice> list{{"P3", make_p3()}};
  for (const auto& [amplifier_name, amplifier] : amplifiers) {
    for (const auto& [damping_name, damping] : dampings) {
      const bool impulse = amplifier_name == "current, motor sensed" && !damping.empty() &&
                           !std::holds_alternative<BackEmfDamping>(damping.front());
      if (impulse) continue;  // see above
      Device device = make_rc_display();
      device.drive.amplifier = amplifier;
      device.drive.damping = damping;
      list.push_back({amplifier_name + ", " + damping_name, device});
    }
  }
  Device resistive = make_rc_display();
  resistive.drive.motor->inductance = 0;
  list.push_back({"motor without inductance", resistive});

  Device wave = make_rc_display();
  wave.drive.amplifier = VoltageAmplifier{.bandwidth_hz = {}, .output_resistance = 0.7};
  wave.drive.damping = {WaveDamping{.impedance = 5e-4}};
  list.push_back({"wave drive, position sensed", wave});

  Device high_pass = make_p3();
  high_pass.drive.damping.push_back(HighPassDamper{.inertia = 0.02, .damping = 2});
  list.push_back({"high-pass damper", high_pass});
  for (NamedDevice& named : make_fed_back_devices()) list.push_back(std::move(named));

  Device filtered = make_rc_display();
  filtered.sensor_filter = SensorFilter{.cutoff_hz = 300, .order = 1};
  list.push_back({"filtered sensor", filtered});
  for (const SensorLocation sensor : {SensorLocation::port, SensorLocation::motor}) {
    Device compliant = make_rc_display();
    compliant.mechanics.transmission =
        Transmission{.stiffness = 20, .damping = 1e-3, .load_inertia = 1e-5};
    compliant.sensor = sensor;
    const std::string place = sensor == SensorLocation::port ? "port" : "motor";
    list.push_back({"compliant transmission, sensor at the " + place, compliant});
    compliant.drive.amplifier = VoltageAmplifier{.bandwidth_hz = 2000};
    compliant.drive.damping.push_back(HighPassDamper{.inertia = 5e-6, .damping = 1e-3});
    list.push_back({"all mechanics, sensor at the " + place, compliant});
    compliant.sensor_filter = SensorFilter{.cutoff_hz = 200, .order = 2};
    list.push_back({"all mechanics, filtered sensor at the " + place, compliant});
  }
  return list;
}

}  // namespace gyrator::testing
