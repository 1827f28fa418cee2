#include "gyrator/circuits/drive_parts.hpp"

#include <numbers>

namespace gyrator {
namespace {

template <class... Ts>
struct Overloaded : Ts... {
  using Ts::operator()...;
};

// The sensed position as a signal: the integral of the sensed velocity.
NodeId add_position(DriveParts& parts, const std::string& name) {
  const NodeId position = parts.network.add_node(name, Domain::electrical);
  parts.network.add(name + ".integrator", position, ground, Capacitor{1}, Role::signal);
  parts.network.add(name + ".velocity", ground, position,
                    VoltageControlledCurrentSource{1, parts.nodes.sensed, ground}, Role::signal);
  parts.taps.positions.push_back(position);
  return position;
}

// A new signal, from + gain * added.
NodeId add_sum(Network& network, const std::string& name, NodeId from, double gain, NodeId added) {
  const NodeId sum = network.add_node(name, Domain::electrical);
  network.add(name, sum, from, VoltageControlledVoltageSource{gain, added, ground}, Role::signal);
  return sum;
}

// transresistance * (the motor's current), as a signal.
NodeId sense_current(DriveParts& parts, const std::string& name, double transresistance) {
  const NodeId sensed = parts.network.add_node(name, Domain::electrical);
  parts.network.add(name, sensed, ground,
                    CurrentControlledVoltageSource{transresistance, *parts.taps.motor_ammeter},
                    Role::signal);
  return sensed;
}

void add(DriveParts& parts, const HeldImpedance& held, const std::string& name) {
  Network& network = parts.network;
  const NodeId position = add_position(parts, name + ".position");
  const NodeId spring = add_sum(network, name + ".stiffness", ground, held.stiffness, position);
  NodeId effort = add_sum(network, name + ".damping", spring, held.damping, parts.nodes.sensed);
  if (held.bandwidth_hz) effort = add_lag(network, name + ".loop", effort, *held.bandwidth_hz);
  add_feedback(parts, name + ".feedback", -1, effort);
}

void add(DriveParts& parts, const TorqueSensedDamper& damper, const std::string& name) {
  Network& network = parts.network;
  const NodeId body = network.add_node(name, Domain::mechanical);
  const ElementId ammeter = network.add(name + ".sensor", parts.nodes.port, body, VoltageSource{});
  network.add(name + ".damping", body, ground, Conductance{damper.damping});
  const NodeId effort = network.add_node(name + ".effort", Domain::electrical);
  network.add(name + ".effort", effort, ground, CurrentControlledVoltageSource{1, ammeter},
              Role::signal);
  const NodeId slow = add_lag(network, name + ".cancellation", effort, damper.cutoff_hz);
  add_feedback(parts, name + ".feedback", 1, slow);
}

void add(DriveParts& parts, const HighPassDamper& damper, const std::string& name) {
  const NodeId floating = parts.network.add_node(name, Domain::mechanical);
  parts.network.add(name + ".damping", parts.nodes.port, floating, Conductance{damper.damping});
  parts.network.add(name + ".inertia", floating, ground, Capacitor{damper.inertia});
}

void add(DriveParts& parts, const ResistanceCancellation& cancellation, const std::string& name) {
  Network& network = parts.network;
  const NodeId next = network.add_node(name, Domain::electrical);
  if (!cancellation.bandwidth_hz) {
    network.add(
        name + ".source", parts.winding, next,
        CurrentControlledVoltageSource{-cancellation.resistance, *parts.taps.motor_ammeter});
  } else {
    const NodeId wanted = sense_current(parts, name + ".sense", cancellation.resistance);
    const NodeId late = add_lag(network, name + ".feedback", wanted, *cancellation.bandwidth_hz);
    network.add(name + ".source", parts.winding, next,
                VoltageControlledVoltageSource{-1, late, ground});
  }
  parts.winding = next;
}

// e = V - R i - L di/dt: the voltage across a model inductor that carries a copy of the current
// is the last term.
NodeId add_back_emf_estimate(DriveParts& parts, const BackEmfDamping& damping,
                             const std::string& name) {
  Network& network = parts.network;
  NodeId estimate = add_sum(network, name + ".voltage", ground, 1, parts.winding);
  if (damping.resistance_estimate > 0) {
    const NodeId drop = sense_current(parts, name + ".drop", damping.resistance_estimate);
    estimate = add_sum(network, name + ".resistance_estimate", estimate, -1, drop);
  }
  if (damping.inductance_estimate > 0) {
    const NodeId model = network.add_node(name + ".inductance", Domain::electrical);
    network.add(name + ".inductance", model, ground, Inductor{damping.inductance_estimate},
                Role::signal);
    network.add(name + ".inductance.current", ground, model,
                CurrentControlledCurrentSource{1, *parts.taps.motor_ammeter}, Role::signal);
    estimate = add_sum(network, name + ".inductance_estimate", estimate, -1, model);
  }
  return estimate;
}

}  // namespace

NodeId add_lag(Network& network, const std::string& name, NodeId from, double bandwidth_hz) {
  const NodeId lagged = network.add_node(name, Domain::electrical);
  network.add(name + ".input", ground, lagged, VoltageControlledCurrentSource{1, from, ground},
              Role::signal);
  network.add(name + ".conductance", lagged, ground, Conductance{1}, Role::signal);
  network.add(name + ".capacitance", lagged, ground,
              Capacitor{1 / (2 * std::numbers::pi * bandwidth_hz)}, Role::signal);
  return lagged;
}

void add_feedback(DriveParts& parts, const std::string& name, double gain, NodeId signal,
                  NodeId minus) {
  const NodeId sum = parts.network.add_node(name, Domain::electrical);
  parts.network.add(name, sum, parts.command, VoltageControlledVoltageSource{gain, signal, minus},
                    Role::signal);
  parts.command = sum;
}

void add_mechanical(DriveParts& parts, const Damping& damping, const std::string& name) {
  std::visit(Overloaded{
                 [&](const HeldImpedance& d) { add(parts, d, name); },
                 [&](const TorqueSensedDamper& d) { add(parts, d, name); },
                 [&](const HighPassDamper& d) { add(parts, d, name); },
                 [&](const EddyCurrentBrake& d) {
                   if (!d.on) return;
                   parts.network.add(name + ".damping", parts.nodes.port, ground,
                                     Conductance{d.damping});
                 },
                 [&](const FrictionBrake& d) {
                   parts.network.add(name + ".brake", parts.nodes.port, ground,
                                     SaturatingConductance{d.damping, d.effort});
                 },
                 [](const auto&) {},
             },
             damping);
}

void add_in_series(DriveParts& parts, const Damping& damping, const std::string& name) {
  if (const auto* d = std::get_if<ResistanceCancellation>(&damping)) add(parts, *d, name);
}

void add_across(DriveParts& parts, const Damping& damping, const std::string& name) {
  Network& network = parts.network;
  const NodeId terminal = *parts.taps.terminal;
  if (const auto* resistor = std::get_if<ResistorDamping>(&damping)) {
    network.add(name + ".resistance", terminal, ground, Resistor{resistor->resistance});
  } else if (const auto* rc = std::get_if<RcDamping>(&damping)) {
    NodeId capacitor = terminal;
    if (rc->resistance > 0) {
      capacitor = network.add_node(name + ".node", Domain::electrical);
      network.add(name + ".resistance", terminal, capacitor, Resistor{rc->resistance});
    }
    network.add(name + ".capacitance", capacitor, ground, Capacitor{rc->capacitance});
  } else if (const auto* netlist = std::get_if<NetlistDamping>(&damping)) {
    check_two_terminals(netlist->circuit);
    add_subcircuit(network, netlist->circuit, name, {terminal, ground});
  } else if (const auto* clamp = std::get_if<ClampDamping>(&damping)) {
    network.add(name + ".clamp", terminal, ground, VoltageClamp{clamp->voltage, clamp->resistance});
    network.add(name + ".leakage", terminal, ground, Conductance{ClampDamping::leakage});
  }
}

void add_electrical_feedback(DriveParts& parts, const Damping& damping, const std::string& name,
                             double torque_constant) {
  const auto* active = std::get_if<BackEmfDamping>(&damping);
  if (!active) return;
  NodeId estimate = add_back_emf_estimate(parts, *active, name);
  if (active->low_pass_hz)
    estimate = add_lag(parts.network, name + ".low_pass", estimate, *active->low_pass_hz);
  NodeId slow = ground;  // what a high-pass takes away
  if (active->high_pass_hz)
    slow = add_lag(parts.network, name + ".high_pass", estimate, *active->high_pass_hz);
  add_feedback(parts, name + ".feedback", -active->damping / torque_constant, estimate, slow);
}

}  // namespace gyrator
