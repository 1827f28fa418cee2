#include "gyrator/circuits/drive.hpp"

#include "gyrator/circuits/drive_parts.hpp"
#include "gyrator/core/error.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <string>

#include <fmt/core.h>

namespace gyrator {
namespace {

std::string name_of_damping(std::size_t i) {
  return fmt::format("damping.{}", i);
}

// What lies behind the ammeter: the series parts, the winding and the back-EMF to ground.
void add_motor(DriveParts& parts, const Drive& drive) {
  Network& network = parts.network;
  const Motor& motor = *drive.motor;
  const NodeId terminal = network.add_node("motor.terminal", Domain::electrical);
  parts.taps.terminal = terminal;
  parts.winding = network.add_node("motor.winding", Domain::electrical);
  parts.taps.motor_ammeter = network.add("motor.ammeter", terminal, parts.winding, VoltageSource{});
  for (std::size_t i = 0; i < drive.damping.size(); ++i)
    add_in_series(parts, drive.damping[i], name_of_damping(i));
  const NodeId emf = network.add_node("motor.emf", Domain::electrical);
  NodeId inner = emf;
  if (motor.inductance > 0) {
    inner = network.add_node("motor.inner", Domain::electrical);
    network.add("motor.inductance", inner, emf, Inductor{motor.inductance});
  }
  if (motor.thermal) {
    network.add(
        "motor.resistance", parts.winding, inner,
        ThermalResistor{motor.resistance, motor.temperature_coefficient, motor.thermal->resistance,
                        motor.thermal->capacity, motor.temperature_rise});
  } else {
    network.add("motor.resistance", parts.winding, inner, Resistor{motor.warm_resistance()});
  }
  network.add("motor.torque_constant", emf, ground,
              Transformer{motor.torque_constant, parts.nodes.shaft, ground});
}

// What the amplifier is asked for, in its output's unit and bounded. Returns the gain that is left.
double add_limit(DriveParts& parts, const std::string& name, double gain,
                 const std::optional<double>& limit) {
  if (!limit) return gain;
  const NodeId bounded = parts.network.add_node(name, Domain::electrical);
  parts.network.add(name, bounded, ground,
                    LimitedVoltageControlledVoltageSource{gain, *limit, parts.command, ground},
                    Role::signal);
  parts.command = bounded;
  return 1;
}

// Returns the ammeter of what flows into the rails.
ElementId add_rails(DriveParts& parts, double voltage) {
  Network& network = parts.network;
  const NodeId rail = network.add_node("amplifier.rail", Domain::electrical);
  const ElementId ammeter = network.add("amplifier.rail.ammeter", *parts.taps.terminal, rail,
                                        VoltageSource{}, Role::supply);
  network.add("amplifier.voltage_limit", rail, ground, VoltageClamp{voltage, rail_resistance},
              Role::supply);
  return ammeter;
}

void add_current_amplifier(DriveParts& parts, const CurrentAmplifier& amplifier, double gain) {
  Network& network = parts.network;
  const NodeId terminal = *parts.taps.terminal;
  gain = add_limit(parts, "amplifier.current_limit", gain, amplifier.current_limit);
  std::optional<ElementId> rails;
  if (amplifier.voltage_limit) rails = add_rails(parts, *amplifier.voltage_limit);
  if (!amplifier.bandwidth_hz) {
    network.add("amplifier", ground, terminal,
                VoltageControlledCurrentSource{gain, parts.command, ground});
    return;
  }
  // di/dt = w_b (i_command - i_sensed): an integrator, 1/w_b as its capacitor.
  if (amplifier.sense == CurrentSense::total) {
    const NodeId current =
        add_lag(network, "amplifier.loop", parts.command, *amplifier.bandwidth_hz);
    network.add("amplifier", ground, terminal,
                VoltageControlledCurrentSource{gain, current, ground});
    return;
  }
  const NodeId current = network.add_node("amplifier.loop", Domain::electrical);
  network.add("amplifier.loop.integrator", current, ground,
              Capacitor{1 / (2 * std::numbers::pi * *amplifier.bandwidth_hz)}, Role::signal);
  network.add("amplifier.loop.command", ground, current,
              VoltageControlledCurrentSource{gain, parts.command, ground}, Role::signal);
  network.add("amplifier.loop.sense", current, ground,
              CurrentControlledCurrentSource{1.0, *parts.taps.motor_ammeter}, Role::signal);
  if (rails) {  // what the rails take must not make the loop ask for more
    network.add("amplifier.loop.back_calculation", current, ground,
                CurrentControlledCurrentSource{1.0, *rails}, Role::signal);
  }
  network.add("amplifier", ground, terminal, VoltageControlledCurrentSource{1.0, current, ground});
}

// Resistance that makes the source's that of the drive's waves, and the damping's number.
struct WaveResistor {
  std::size_t damping = 0;
  double resistance = 0;
};

std::optional<WaveResistor> find_wave_resistor(const Drive& drive,
                                               const VoltageAmplifier& amplifier) {
  for (std::size_t i = 0; i < drive.damping.size(); ++i) {
    const auto* wave = std::get_if<WaveDamping>(&drive.damping[i]);
    if (!wave) continue;
    const double K_t = drive.motor->torque_constant;
    const double missing = K_t * K_t / wave->impedance - amplifier.output_resistance;
    // The amplifier's own resistance may be all of it, but for rounding.
    return WaveResistor{i, std::abs(missing) < 1e-12 * amplifier.output_resistance ? 0 : missing};
  }
  return std::nullopt;
}

void add_voltage_amplifier(DriveParts& parts, const Drive& drive, const VoltageAmplifier& amplifier,
                           double gain) {
  Network& network = parts.network;
  const double volts_per_command = gain;
  gain = add_limit(parts, "amplifier.voltage_limit", gain, amplifier.voltage_limit);
  const NodeId wanted = amplifier.bandwidth_hz ? add_lag(network, "amplifier.loop", parts.command,
                                                         *amplifier.bandwidth_hz)
                                               : parts.command;
  NodeId output = *parts.taps.terminal;
  if (amplifier.current_limit) {
    const NodeId limited = network.add_node("amplifier.limiter", Domain::electrical);
    network.add("amplifier.current_limit", limited, output,
                CurrentLimiter{*amplifier.current_limit, limiter_resistance}, Role::supply);
    output = limited;
  }
  const auto add_behind = [&](const char* node, const std::string& name, double resistance) {
    if (!(resistance > 0)) return;
    const NodeId behind = network.add_node(node, Domain::electrical);
    network.add(name, behind, output, Resistor{resistance});
    output = behind;
  };
  const auto wave = find_wave_resistor(drive, amplifier);
  if (wave)
    add_behind("amplifier.terminal", name_of_damping(wave->damping) + ".resistance",
               wave->resistance);
  add_behind("amplifier.output", "amplifier.output_resistance", amplifier.output_resistance);
  network.add("amplifier", output, ground, VoltageControlledVoltageSource{gain, wanted, ground});
  if (!wave) return;
  parts.taps.source = output;
  parts.taps.volts_per_command = volts_per_command;
}

// An ideal loop around the winding's current delivers on top whatever a branch across the motor
// draws: the branches have no part in current, effort or motion, and are left out.
bool ignores_damping(const Amplifier& amplifier) {
  const auto* current = std::get_if<CurrentAmplifier>(&amplifier);
  return current && !current->bandwidth_hz && current->sense == CurrentSense::motor;
}

bool is_across(const Damping& damping) {
  return std::holds_alternative<ResistorDamping>(damping) ||
         std::holds_alternative<RcDamping>(damping) ||
         std::holds_alternative<NetlistDamping>(damping);
}

bool needs_motor(const Damping& damping) {
  return is_across(damping) || std::holds_alternative<ClampDamping>(damping) ||
         std::holds_alternative<ResistanceCancellation>(damping) ||
         std::holds_alternative<BackEmfDamping>(damping) ||
         std::holds_alternative<WaveDamping>(damping);
}

[[noreturn]] void refuse(std::size_t damping, const std::string& reason) {
  throw Error(ErrorCode::bad_input, fmt::format("damping/{}", damping), reason);
}

// A kind that acts on the whole drive: given twice it means nothing but a slip.
template <class Kind>
void check_at_most_one(const Drive& drive, const char* kind) {
  bool seen = false;
  for (std::size_t i = 0; i < drive.damping.size(); ++i) {
    if (!std::holds_alternative<Kind>(drive.damping[i])) continue;
    if (seen) refuse(i, fmt::format("a second {}: a drive has one at most", kind));
    seen = true;
  }
}

bool has_voltage_limit(const Amplifier& amplifier) {
  if (const auto* current = std::get_if<CurrentAmplifier>(&amplifier))
    return current->voltage_limit.has_value();
  const auto* voltage = std::get_if<VoltageAmplifier>(&amplifier);
  return voltage && voltage->voltage_limit;
}

void check_cancellation(const Drive& drive, std::size_t i) {
  if (has_voltage_limit(drive.amplifier)) {
    refuse(i,
           "resistance_cancellation with the amplifier's voltage_limit: the limit would bound the "
           "command alone, not the voltage that the cancellation adds; leave out one of them");
  }
  const bool branch = std::any_of(drive.damping.begin(), drive.damping.end(), is_across);
  if (branch || std::holds_alternative<VoltageAmplifier>(drive.amplifier)) return;
  refuse(i, std::holds_alternative<CurrentAmplifier>(drive.amplifier)
                ? "resistance_cancellation under a current amplifier with nothing across the "
                  "motor: the amplifier imposes the current, and a voltage in series changes "
                  "nothing; use \"amplifier\": {\"kind\": \"voltage\"}, or put a circuit across "
                  "the motor"
                : "resistance_cancellation with the motor's terminals open: no current flows; use "
                  "\"amplifier\": {\"kind\": \"voltage\"}, or put a circuit across the motor");
}

void check_wave(const Drive& drive, std::size_t i) {
  const auto* amplifier = std::get_if<VoltageAmplifier>(&drive.amplifier);
  if (!amplifier) {
    refuse(i,
           "a wave drive is a voltage behind a resistance; a source of current or effort has none, "
           "and no wave leaves the motor: use \"amplifier\": {\"kind\": \"voltage\"}");
  }
  const double impedance = std::get<WaveDamping>(drive.damping[i]).impedance;
  const double K_t = drive.motor->torque_constant;
  const double most = amplifier->output_resistance > 0 ? K_t * K_t / amplifier->output_resistance
                                                       : std::numeric_limits<double>::infinity();
  if (impedance > 0 && impedance <= most * (1 + 1e-12)) return;
  throw Error(ErrorCode::bad_input, fmt::format("damping/{}/impedance", i),
              fmt::format("{:g}: must be above 0{}", impedance,
                          std::isinf(most)
                              ? ""
                              : fmt::format(" and at most {:g}, K_t^2 over the amplifier's output "
                                            "resistance of {:g} ohm",
                                            most, amplifier->output_resistance)));
}

}  // namespace

std::optional<double> find_bandwidth(const Amplifier& amplifier) {
  if (const auto* current = std::get_if<CurrentAmplifier>(&amplifier)) return current->bandwidth_hz;
  if (const auto* voltage = std::get_if<VoltageAmplifier>(&amplifier)) return voltage->bandwidth_hz;
  return {};
}

void check_drive(const Drive& drive) {
  if (!drive.motor && !std::holds_alternative<IdealDrive>(drive.amplifier)) {
    throw Error(ErrorCode::bad_input, "amplifier",
                "an amplifier needs a motor to drive: add the key \"motor\"");
  }
  const auto* current = std::get_if<CurrentAmplifier>(&drive.amplifier);
  if (current && current->voltage_limit && ignores_damping(drive.amplifier)) {
    throw Error(ErrorCode::bad_input, "amplifier",
                "voltage_limit with an ideal loop around the motor's current: an ideal loop has no "
                "voltage of its own; give the amplifier a bandwidth");
  }
  check_at_most_one<ResistanceCancellation>(drive, "resistance_cancellation");
  check_at_most_one<BackEmfDamping>(drive, "back_emf");
  check_at_most_one<HeldImpedance>(drive, "held_impedance");
  check_at_most_one<WaveDamping>(drive, "wave");
  for (std::size_t i = 0; i < drive.damping.size(); ++i) {
    if (!drive.motor && needs_motor(drive.damping[i]))
      refuse(i, "a damping circuit needs a motor to act on: add the key \"motor\"");
    if (std::holds_alternative<ResistanceCancellation>(drive.damping[i]))
      check_cancellation(drive, i);
    if (std::holds_alternative<WaveDamping>(drive.damping[i])) check_wave(drive, i);
  }
}

DriveTaps add_drive(Network& network, const Drive& drive, const DriveNodes& nodes, double gain) {
  check_drive(drive);
  DriveParts parts{network, nodes, nodes.command, {}, ground};
  const auto for_each = [&](const auto& stage) {
    for (std::size_t i = 0; i < drive.damping.size(); ++i)
      stage(drive.damping[i], name_of_damping(i));
  };
  for_each([&](const Damping& d, const std::string& name) { add_mechanical(parts, d, name); });
  if (drive.motor) {
    add_motor(parts, drive);
    for_each([&](const Damping& d, const std::string& name) {
      if (!ignores_damping(drive.amplifier)) add_across(parts, d, name);
      add_electrical_feedback(parts, d, name, drive.motor->torque_constant);
    });
  }
  if (const auto* current = std::get_if<CurrentAmplifier>(&drive.amplifier)) {
    add_current_amplifier(parts, *current, gain);
  } else if (const auto* voltage = std::get_if<VoltageAmplifier>(&drive.amplifier)) {
    add_voltage_amplifier(parts, drive, *voltage, gain);
  } else {
    // An effort source at the shaft, beside a motor whose terminals carry only the circuits.
    network.add("amplifier", ground, nodes.shaft,
                VoltageControlledCurrentSource{gain, parts.command, ground});
  }
  return parts.taps;
}

}  // namespace gyrator
