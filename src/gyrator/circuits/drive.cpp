#include "gyrator/circuits/drive.hpp"

#include "gyrator/core/error.hpp"

#include <numbers>

#include <fmt/core.h>

namespace gyrator {
namespace {

// The winding from `terminal` through R_m, L_m and the back-EMF to ground; returns its ammeter.
ElementId add_motor(Network& network, const Motor& motor, NodeId terminal, NodeId shaft) {
  const NodeId winding = network.add_node("motor.winding", Domain::electrical);
  const ElementId ammeter = network.add("motor.ammeter", terminal, winding, VoltageSource{});
  NodeId emf = network.add_node("motor.emf", Domain::electrical);
  NodeId inner = emf;
  if (motor.inductance > 0) {
    inner = network.add_node("motor.inner", Domain::electrical);
    network.add("motor.inductance", inner, emf, Inductor{motor.inductance});
  }
  network.add("motor.resistance", winding, inner, Resistor{motor.resistance});
  network.add("motor.torque_constant", emf, ground,
              Transformer{motor.torque_constant, shaft, ground});
  return ammeter;
}

// A first-order lag 1/(1 + s/w_b) of the signal node `from`; carries no physical power.
NodeId add_lag(Network& network, const std::string& name, NodeId from, double bandwidth_hz) {
  const NodeId lagged = network.add_node(name, Domain::electrical);
  network.add(name + ".resistance", from, lagged, Resistor{1.0}, Role::signal);
  network.add(name + ".capacitance", lagged, ground,
              Capacitor{1 / (2 * std::numbers::pi * bandwidth_hz)}, Role::signal);
  return lagged;
}

void add_damping(Network& network, const Damping& damping, const std::string& name,
                 NodeId terminal) {
  if (const auto* resistor = std::get_if<ResistorDamping>(&damping)) {
    network.add(name + ".resistance", terminal, ground, Resistor{resistor->resistance});
  } else if (const auto* rc = std::get_if<RcDamping>(&damping)) {
    NodeId capacitor = terminal;
    if (rc->resistance > 0) {
      capacitor = network.add_node(name + ".node", Domain::electrical);
      network.add(name + ".resistance", terminal, capacitor, Resistor{rc->resistance});
    }
    network.add(name + ".capacitance", capacitor, ground, Capacitor{rc->capacitance});
  }
}

void add_current_amplifier(Network& network, const CurrentAmplifier& amplifier, NodeId command,
                           NodeId terminal, ElementId motor_ammeter, double gain) {
  if (amplifier.bandwidth_hz) {
    // di/dt = w_b (i_command - i_sensed): an integrator, 1/w_b as its capacitor.
    if (amplifier.sense == CurrentSense::total) {
      const NodeId current = add_lag(network, "amplifier.loop", command, *amplifier.bandwidth_hz);
      network.add("amplifier", ground, terminal,
                  VoltageControlledCurrentSource{gain, current, ground});
      return;
    }
    const NodeId current = network.add_node("amplifier.loop", Domain::electrical);
    network.add("amplifier.loop.integrator", current, ground,
                Capacitor{1 / (2 * std::numbers::pi * *amplifier.bandwidth_hz)}, Role::signal);
    network.add("amplifier.loop.command", ground, current,
                VoltageControlledCurrentSource{gain, command, ground}, Role::signal);
    network.add("amplifier.loop.sense", current, ground,
                CurrentControlledCurrentSource{1.0, motor_ammeter}, Role::signal);
    network.add("amplifier", ground, terminal,
                VoltageControlledCurrentSource{1.0, current, ground});
    return;
  }
  network.add("amplifier", ground, terminal, VoltageControlledCurrentSource{gain, command, ground});
}

// An ideal loop around the winding's current delivers on top whatever a branch across the motor
// draws: the branches have no part in current, effort or motion, and are left out.
bool ignores_damping(const Amplifier& amplifier) {
  const auto* current = std::get_if<CurrentAmplifier>(&amplifier);
  return current && !current->bandwidth_hz && current->sense == CurrentSense::motor;
}

}  // namespace

DriveTaps add_drive(Network& network, const Drive& drive, NodeId command, NodeId shaft,
                    double gain) {
  if (std::holds_alternative<IdealDrive>(drive.amplifier) && !drive.motor) {
    if (!drive.damping.empty()) {
      throw Error(ErrorCode::bad_input, "damping",
                  "a damping circuit needs a motor: add the key \"motor\"");
    }
    network.add("amplifier", ground, shaft, VoltageControlledCurrentSource{gain, command, ground});
    return {};
  }
  if (!drive.motor) {
    throw Error(ErrorCode::bad_input, "amplifier",
                "an amplifier needs a motor to drive: add the key \"motor\"");
  }
  const NodeId terminal = network.add_node("motor.terminal", Domain::electrical);
  const ElementId ammeter = add_motor(network, *drive.motor, terminal, shaft);
  if (const auto* current = std::get_if<CurrentAmplifier>(&drive.amplifier)) {
    add_current_amplifier(network, *current, command, terminal, ammeter, gain);
  } else if (const auto* voltage = std::get_if<VoltageAmplifier>(&drive.amplifier)) {
    const NodeId wanted = voltage->bandwidth_hz
                              ? add_lag(network, "amplifier.loop", command, *voltage->bandwidth_hz)
                              : command;
    NodeId output = terminal;
    if (voltage->output_resistance > 0) {
      output = network.add_node("amplifier.output", Domain::electrical);
      network.add("amplifier.output_resistance", output, terminal,
                  Resistor{voltage->output_resistance});
    }
    network.add("amplifier", output, ground, VoltageControlledVoltageSource{gain, wanted, ground});
  } else {
    // An ideal effort source beside a motor whose terminals carry only the damping circuits.
    network.add("amplifier", ground, shaft, VoltageControlledCurrentSource{gain, command, ground});
  }
  for (std::size_t i = 0; i < drive.damping.size() && !ignores_damping(drive.amplifier); ++i) {
    add_damping(network, drive.damping[i], fmt::format("damping.{}", i), terminal);
  }
  return {ammeter, terminal};
}

}  // namespace gyrator
