#include "gyrator/twin/twin_device.hpp"

#include "gyrator/core/error.hpp"

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include <fmt/core.h>

namespace gyrator {
namespace {

constexpr double lowest_rail = 0.01;  // [V], where the limit is zero

[[noreturn]] void refuse(const std::string& place, const std::string& message) {
  throw Error(ErrorCode::bad_input, place, message);
}

double output_resistance_of(const Amplifier& amplifier) {
  const auto* voltage = std::get_if<VoltageAmplifier>(&amplifier);
  return voltage ? voltage->output_resistance : 0;
}

// What a setting replaces.
bool is_setting(const Damping& damping) {
  return std::holds_alternative<RcDamping>(damping) ||
         std::holds_alternative<ResistanceCancellation>(damping) ||
         std::holds_alternative<BackEmfDamping>(damping);
}

template <class Kind>
const Kind* find_damping(const TwinDevice& twin) {
  for (const Damping& damping : twin.device.drive.damping)
    if (const auto* found = std::get_if<Kind>(&damping)) return found;
  return nullptr;
}

void check_damping(const std::vector<Damping>& damping) {
  int branches = 0;
  for (std::size_t i = 0; i < damping.size(); ++i) {
    const std::string place = fmt::format("damping/{}", i);
    if (std::holds_alternative<WaveDamping>(damping[i]))
      refuse(place, "wave: the twin's commands are currents and voltages, not waves; leave it out");
    if (std::holds_alternative<HeldImpedance>(damping[i]))
      refuse(place, "held_impedance: a wall beside the amplifier; leave it out for the twin");
    if (std::holds_alternative<RcDamping>(damping[i]) && ++branches > 1)
      refuse(place, "a second rc: the twin's amplifier has one branch to set; use a netlist");
  }
}

// Under a current amplifier with nothing across the motor the current is imposed, and a voltage in
// series with it does nothing.
bool takes_cancellation(Drive drive) {
  drive.amplifier = CurrentAmplifier{};
  try {
    check_drive(drive);
  } catch (const Error&) {
    return false;
  }
  return true;
}

void check_numbers(const TwinDevice& twin) {
  const auto require = [](double value, bool holds, const char* name, const char* rule) {
    if (std::isfinite(value) && holds) return;
    refuse("twin", fmt::format("{} of {:g}: must be {}", name, value, rule));
  };
  const auto at_least_zero = [&](double value, const char* name) {
    require(value, value >= 0, name, "at least 0");
  };
  at_least_zero(twin.noise.command, "command noise [A, V]");
  at_least_zero(twin.noise.current, "current noise [A]");
  at_least_zero(twin.noise.voltage, "voltage noise [V]");
  at_least_zero(twin.noise.velocity, "velocity noise");
  at_least_zero(twin.noise.position, "position noise");
  at_least_zero(twin.position_quantum, "position quantum");
  at_least_zero(twin.current_step, "current step [A]");
  at_least_zero(twin.voltage_step, "voltage step [V]");
  at_least_zero(twin.velocity_step, "velocity step");
  require(twin.delay, twin.delay >= 0 && twin.delay <= 0.1, "delay [s]", "between 0 and 0.1 s");
  require(twin.thermal.resistance, twin.thermal.resistance > 0, "thermal resistance [K/W]",
          "above 0");
  require(twin.thermal.capacity, twin.thermal.capacity > 0, "thermal capacity [J/K]", "above 0");
  require(twin.ambient, twin.ambient > 0, "ambient [K]", "above 0 K");
  require(twin.velocity_limit, twin.velocity_limit > 0, "velocity limit", "above 0");
  const Motor& motor = *twin.device.drive.motor;
  const double rise = twin.ambient + twin.winding_rise - twin.reference_temperature;
  require(twin.winding_rise, 1 + motor.temperature_coefficient * rise > 0, "winding rise [K]",
          "such that the winding keeps a positive resistance");
}

}  // namespace

void check_twin_device(const TwinDevice& twin) {
  const Drive& drive = twin.device.drive;
  if (std::holds_alternative<IdealDrive>(drive.amplifier)) {
    refuse("amplifier",
           "ideal: a source of effort has neither current nor voltage to measure; the twin needs "
           "\"amplifier\": {\"kind\": \"current\"} or {\"kind\": \"voltage\"}, and a motor");
  }
  if (!drive.motor) refuse("motor", "missing: the twin's amplifier needs a motor to drive");
  check_damping(drive.damping);
  check_drive(drive);
  check_numbers(twin);
}

TwinSettings find_initial_settings(const TwinDevice& twin) {
  TwinSettings settings;
  std::optional<double> current_limit;
  std::optional<double> voltage_limit;
  if (const auto* current = std::get_if<CurrentAmplifier>(&twin.device.drive.amplifier)) {
    current_limit = current->current_limit;
    voltage_limit = current->voltage_limit;
  }
  if (const auto* voltage = std::get_if<VoltageAmplifier>(&twin.device.drive.amplifier)) {
    settings.drive_mode = DriveMode::voltage;
    current_limit = voltage->current_limit;
    voltage_limit = voltage->voltage_limit;
  }
  settings.current_limit = current_limit.value_or(TwinDevice::default_current_limit);
  settings.voltage_limit = voltage_limit.value_or(TwinDevice::default_voltage_limit);
  settings.velocity_limit = twin.velocity_limit;
  if (const auto* rc = find_damping<RcDamping>(twin)) {
    settings.damping_resistance = rc->resistance;
    settings.damping_capacitance = rc->capacitance;
    settings.damping_connected = true;
  }
  if (const auto* cancellation = find_damping<ResistanceCancellation>(twin))
    settings.cancellation_resistance = cancellation->resistance;
  if (const auto* back_emf = find_damping<BackEmfDamping>(twin)) {
    settings.back_emf_damping = back_emf->damping;
    settings.back_emf_resistance = back_emf->resistance_estimate;
  }
  return settings;
}

Device make_plant_device(const TwinDevice& twin, const TwinSettings& settings, double resistance) {
  Device device = twin.device;
  Motor& motor = *device.drive.motor;
  motor.resistance = resistance;
  motor.temperature_rise = 0;
  motor.thermal = std::nullopt;
  if (device.sensor == SensorLocation::outgoing_wave) device.sensor = SensorLocation::port;
  device.sensor_filter = std::nullopt;

  auto& damping = device.drive.damping;
  // Names of network elements count the parts: what is always there comes first.
  std::erase_if(damping, is_setting);
  if (settings.damping_connected) {
    const double R_1 = settings.damping_resistance;
    if (settings.damping_capacitance > 0) {
      damping.emplace_back(RcDamping{R_1, settings.damping_capacitance});
    } else if (R_1 > 0) {
      damping.emplace_back(ResistorDamping{R_1});
    } else {
      refuse("damping_connected",
             "with damping_resistance and damping_capacitance of 0: would short the motor");
    }
  }

  const bool by_voltage = settings.enable && settings.drive_mode == DriveMode::voltage;
  const double bandwidth =
      find_bandwidth(twin.device.drive.amplifier).value_or(TwinDevice::default_bandwidth_hz);
  const double output_resistance = output_resistance_of(twin.device.drive.amplifier);
  bool cancels = false;
  if (settings.enable && settings.cancellation_resistance > 0) {
    ResistanceCancellation cancellation;
    if (const auto* given = find_damping<ResistanceCancellation>(twin)) cancellation = *given;
    cancellation.resistance = settings.cancellation_resistance;
    Drive with = device.drive;
    with.damping.emplace_back(cancellation);
    cancels = by_voltage || takes_cancellation(with);
    if (cancels) damping = std::move(with.damping);
  }
  if (settings.enable && settings.back_emf_damping > 0) {
    BackEmfDamping back_emf;
    if (const auto* given = find_damping<BackEmfDamping>(twin)) back_emf = *given;
    const double K_t = motor.torque_constant;
    // The feedback adds to a command in A or V instead of an effort.
    const double per_effort =
        by_voltage ? (twin.device.drive.motor->resistance + output_resistance) / K_t : 1 / K_t;
    back_emf.damping = settings.back_emf_damping * per_effort;
    back_emf.resistance_estimate = settings.back_emf_resistance;
    damping.emplace_back(back_emf);
  }

  if (by_voltage) {
    device.drive.amplifier = VoltageAmplifier{bandwidth, output_resistance, {}, {}};
  } else {
    CurrentAmplifier amplifier{bandwidth, CurrentSense::total, {}, {}};
    if (const auto* given = std::get_if<CurrentAmplifier>(&twin.device.drive.amplifier))
      amplifier.sense = given->sense;
    if (!settings.enable) amplifier.sense = CurrentSense::total;
    if (!cancels) amplifier.voltage_limit = std::max(settings.voltage_limit, lowest_rail);
    device.drive.amplifier = amplifier;
  }
  return device;
}

}  // namespace gyrator
