#include "gyrator/mechanics/device.hpp"

#include "gyrator/circuits/drive_parts.hpp"
#include "gyrator/core/error.hpp"

#include <cmath>
#include <numbers>

#include <fmt/core.h>

namespace gyrator {
namespace {

void add_operator(DeviceNetwork& d, const Operator& held_by) {
  Network& network = d.network;
  const NodeId hand = network.add_node("operator.hand", Domain::mechanical);
  d.operator_ammeter =
      network.add("operator.ammeter", hand, d.port, VoltageSource{}, Role::operator_side);
  network.add("operator.external_effort", ground, hand, CurrentSource{d.external_effort},
              Role::operator_side);
  if (std::holds_alternative<ClampedOperator>(held_by)) {
    network.add("operator.clamp", hand, ground, VoltageSource{}, Role::operator_side);
  } else if (const auto* arm = std::get_if<MassSpringDamper>(&held_by)) {
    const auto role = Role::operator_side;
    if (arm->inertia > 0)
      network.add("operator.inertia", hand, ground, Capacitor{arm->inertia}, role);
    if (arm->damping > 0)
      network.add("operator.damping", hand, ground, Conductance{arm->damping}, role);
    if (arm->stiffness > 0)
      network.add("operator.stiffness", hand, ground, Inductor{1 / arm->stiffness}, role);
    for (std::size_t i = 0; i < arm->resonators.size(); ++i) {
      const std::string name = fmt::format("operator.resonator.{}", i);
      const NodeId mass = network.add_node(name, Domain::mechanical);
      network.add(name + ".stiffness", hand, mass, Inductor{1 / arm->resonators[i].stiffness},
                  role);
      network.add(name + ".inertia", mass, ground, Capacitor{arm->resonators[i].inertia}, role);
    }
  } else if (const auto* other = std::get_if<NetworkOperator>(&held_by)) {
    check_passive_operator(*other);
    add_subcircuit(network, other->circuit, "operator.network", {hand, ground},
                   {Domain::mechanical, Role::operator_side});
  }
}

void check_stops(const HardStops& stops) {
  const auto refuse = [](const char* key, const std::string& message) {
    throw Error(ErrorCode::bad_input, std::string("mechanics/stops") + key, message);
  };
  if (!stops.lower && !stops.upper)
    refuse("", "neither \"lower\" nor \"upper\": give at least one of them");
  if (stops.lower && stops.upper && !(*stops.lower < *stops.upper)) {
    refuse("/upper",
           fmt::format("{:g}: must be above \"lower\", which is {:g}", *stops.upper, *stops.lower));
  }
  if (!(stops.stiffness > 0) || !std::isfinite(stops.stiffness))
    refuse("/stiffness", fmt::format("{:g}: must be above 0", stops.stiffness));
  if (!(stops.damping >= 0) || !std::isfinite(stops.damping))
    refuse("/damping", fmt::format("{:g}: must be at least 0", stops.damping));
}

void check_filter(const Device& device) {
  const SensorFilter& filter = *device.sensor_filter;
  const auto refuse = [](const char* key, const std::string& message) {
    throw Error(ErrorCode::bad_input, std::string("sensor/filter") + key, message);
  };
  if (device.sensor == SensorLocation::outgoing_wave)
    refuse("", "a controller of kind \"wave\" reads no position: leave it out");
  if (!(filter.cutoff_hz > 0) || !std::isfinite(filter.cutoff_hz))
    refuse("/cutoff", fmt::format("{:g} Hz: must be above 0 Hz", filter.cutoff_hz));
  if (filter.order != 1 && filter.order != 2)
    refuse("/order", fmt::format("{}: must be 1 or 2", filter.order));
}

// The low-pass (filter-1) of the velocity at `from`: a lag, or a source behind sqrt(2) [ohm]
// feeding an inductor and a capacitor of 1/w_c, whose poles are Butterworth's.
void add_filter(DeviceNetwork& d, const SensorFilter& filter, NodeId from) {
  const std::string name = "sensor.filter";
  Network& network = d.network;
  if (filter.order == 1) {
    d.filter = {add_lag(network, name, from, filter.cutoff_hz)};
  } else {
    const double part = 1 / (2 * std::numbers::pi * filter.cutoff_hz);
    const double source = 1 / std::numbers::sqrt2;
    const NodeId first = network.add_node(name + ".source", Domain::electrical);
    const NodeId output = network.add_node(name, Domain::electrical);
    network.add(name + ".input", ground, first,
                VoltageControlledCurrentSource{source, from, ground}, Role::signal);
    network.add(name + ".conductance", first, ground, Conductance{source}, Role::signal);
    network.add(name + ".inductance", first, output, Inductor{part}, Role::signal);
    network.add(name + ".capacitance", output, ground, Capacitor{part}, Role::signal);
    d.filter = {first, output};
  }
  d.sensed = d.filter.back();
}

// A rigid link, as a resistor of 0 ohm becomes, is passive as well.
bool is_passive(const ElementLaw& law) {
  if (const auto* link = std::get_if<VoltageSource>(&law)) return !link->input;
  return std::holds_alternative<Resistor>(law) || std::holds_alternative<Conductance>(law) ||
         std::holds_alternative<Inductor>(law) || std::holds_alternative<Capacitor>(law) ||
         std::holds_alternative<MutualInductance>(law);
}

}  // namespace

double find_lag(const SensorFilter& filter) {
  const double corner = 2 * std::numbers::pi * filter.cutoff_hz;
  return (filter.order == 1 ? 1 : std::numbers::sqrt2) / corner;
}

std::optional<DryFriction> find_dry_friction(const Mechanics& mechanics) {
  const DryFriction friction{mechanics.coulomb_friction,
                             mechanics.stiction.value_or(mechanics.coulomb_friction),
                             mechanics.stribeck_velocity};
  if (!(friction.sliding >= 0)) {
    throw Error(ErrorCode::bad_input, "mechanics/coulomb_friction",
                fmt::format("{:g}: must be at least 0", friction.sliding));
  }
  if (!(friction.breakaway >= friction.sliding) || !std::isfinite(friction.breakaway)) {
    throw Error(ErrorCode::bad_input, "mechanics/stiction",
                fmt::format("{:g}: must be at least coulomb_friction, {:g}, which it starts from; "
                            "left out, it equals that",
                            friction.breakaway, friction.sliding));
  }
  if (!(friction.stribeck_velocity >= 0)) {
    throw Error(ErrorCode::bad_input, "mechanics/stribeck_velocity",
                fmt::format("{:g}: must be at least 0", friction.stribeck_velocity));
  }
  if (friction.stribeck_velocity > 0 && !(friction.breakaway > friction.sliding)) {
    throw Error(ErrorCode::bad_input, "mechanics/stribeck_velocity",
                fmt::format("{:g}: has no effect, since friction falls up to it from stiction to "
                            "coulomb_friction: give a stiction above {:g}, or leave it out",
                            friction.stribeck_velocity, friction.sliding));
  }
  if (friction.breakaway == 0) return std::nullopt;
  return friction;
}

void check_passive_operator(const NetworkOperator& held_by) {
  for (const SpiceElement& element : held_by.circuit.elements) {
    if (is_passive(element.law)) continue;
    throw Error(ErrorCode::bad_input, element.place,
                fmt::format("'{}' in an operator: a hand is made of resistors, inductors, "
                            "capacitors and coupled inductors only, which are passive by "
                            "themselves",
                            element.name));
  }
  check_two_terminals(held_by.circuit);
}

DeviceNetwork build_device_network(const Device& device, const Operator& held_by, double gain) {
  DeviceNetwork d;
  d.gain = gain;
  Network& network = d.network;
  d.command = network.add_input("command");
  d.external_effort = network.add_input("external_effort");
  const NodeId command = network.add_node("command", Domain::electrical);
  network.add("command", command, ground, VoltageSource{d.command}, Role::signal);

  const Mechanics& mechanics = device.mechanics;
  d.friction = find_dry_friction(mechanics);
  if (mechanics.stops) check_stops(*mechanics.stops);
  d.stops = mechanics.stops;
  d.motor_shaft = network.add_node("motor.shaft", Domain::mechanical);
  network.add("mechanics.inertia", d.motor_shaft, ground, Capacitor{mechanics.inertia});
  if (mechanics.damping > 0) {
    network.add("mechanics.damping", d.motor_shaft, ground, Conductance{mechanics.damping});
  }
  d.port = d.motor_shaft;
  if (mechanics.transmission) {
    const Transmission& t = *mechanics.transmission;
    d.port = network.add_node("port", Domain::mechanical);
    network.add("mechanics.transmission.stiffness", d.motor_shaft, d.port,
                Inductor{1 / t.stiffness});
    if (t.damping > 0) {
      network.add("mechanics.transmission.damping", d.motor_shaft, d.port, Conductance{t.damping});
    }
    network.add("mechanics.transmission.load_inertia", d.port, ground, Capacitor{t.load_inertia});
  }
  d.sensor = device.sensor;
  d.sensed = d.sensor == SensorLocation::motor ? d.motor_shaft : d.port;
  // An analog loop of the drive has the sensor's own signal.
  d.drive = add_drive(network, device.drive, {command, d.motor_shaft, d.port, d.sensed}, gain);
  d.port_sensed = d.sensor != SensorLocation::outgoing_wave && d.sensed == d.port;
  if (device.sensor_filter) {
    check_filter(device);
    add_filter(d, *device.sensor_filter, d.sensed);
  }
  d.collocated = d.port_sensed && !device.sensor_filter;
  if (d.sensor == SensorLocation::outgoing_wave && !d.drive.source) {
    throw Error(ErrorCode::bad_input, "damping",
                "no wave leaves this drive: add {\"kind\": \"wave\", \"impedance\": …}, a voltage "
                "amplifier behind a known resistance");
  }
  add_operator(d, held_by);
  return d;
}

namespace {

// Blocked effort at the port per unit of command, at DC.
double compute_blocked_effort(const Device& device, double gain) {
  const DeviceNetwork blocked = build_device_network(device, ClampedOperator{}, gain);
  const NetworkEquations equations(blocked.network);
  const Eigen::MatrixXd steady = solve_steady_state(equations.descriptor());
  const LinearForm effort = equations.through(blocked.operator_ammeter);
  return -(effort.x * steady.col(blocked.command))(0);
}

// The gain at which the blocked effort equals the command. Feedback that acts at DC makes the
// effort a broken linear function of the gain g, 1/effort = alpha/g + beta: two points tell all.
double find_gain(const Device& device) {
  const double once = compute_blocked_effort(device, 1);
  const double twice = compute_blocked_effort(device, 2);
  if (!std::isfinite(once) || std::abs(once) < 1e-12) return 0;
  const double alpha = 2 * (1 / once - 1 / twice);
  const double beta = 1 / once - alpha;
  if (beta >= 1 - 1e-9) {
    throw Error(ErrorCode::bad_input, "damping",
                fmt::format("the feedback takes {:.4g} of every steady effort, whatever the "
                            "amplifier's gain: it must be below 1 for the command to reach the "
                            "shaft; back_emf takes d (R_m - resistance_estimate)/K_t^2: bring the "
                            "estimate closer to the winding, or lower the damping",
                            beta));
  }
  if (std::abs(beta) < 1e-12 * std::abs(alpha)) return 1 / once;
  return alpha / (1 - beta);
}

}  // namespace

double find_amplifier_gain(const Device& device) {
  if (device.gain) return *device.gain;
  // The amplifier's scale was set once, at the reference temperature; it does not follow the
  // winding.
  Device as_calibrated = device;
  if (as_calibrated.drive.motor) as_calibrated.drive.motor->temperature_rise = 0;
  // An analog position loop does nothing at its centre, where the effort was measured.
  std::erase_if(as_calibrated.drive.damping,
                [](const Damping& d) { return std::holds_alternative<HeldImpedance>(d); });
  double gain = find_gain(as_calibrated);
  if (gain < 0 && as_calibrated.drive.motor) {
    // Over-cancelled there: whoever tuned it so did it with the winding as warm as it is now.
    as_calibrated.drive.motor->temperature_rise = device.drive.motor->temperature_rise;
    gain = find_gain(as_calibrated);
  }
  if (std::isfinite(gain) && gain != 0) return gain;
  throw Error(ErrorCode::bad_input, "amplifier",
              "no steady effort reaches the shaft: the command cannot be scaled to the blocked "
              "effort at DC; a damping circuit shorts the motor or a capacitor blocks it");
}

LinearForm find_sensed_rate(const DeviceNetwork& device, const NetworkEquations& equations) {
  if (device.sensor != SensorLocation::outgoing_wave) return equations.across(device.sensed);
  LinearForm wave = equations.across(*device.drive.terminal);
  const LinearForm source = equations.across(*device.drive.source);
  wave.x = 2 * wave.x - source.x;
  wave.u = 2 * wave.u - source.u;
  return wave;
}

DeviceNetwork build_device_network(const Device& device, const Operator& held_by) {
  return build_device_network(device, held_by, find_amplifier_gain(device));
}

}  // namespace gyrator
