#include "gyrator/studies/spice_deck.hpp"

#include "gyrator/circuits/operating_point.hpp"
#include "gyrator/circuits/reduction.hpp"
#include "gyrator/circuits/spice_writer.hpp"
#include "gyrator/core/error.hpp"
#include "gyrator/core/text.hpp"
#include "gyrator/cosim/sampled_plant.hpp"
#include "gyrator/studies/model_format.hpp"
#include "gyrator/studies/results.hpp"
#include "gyrator/version.hpp"

#include <algorithm>
#include <cmath>

#include <fmt/core.h>

namespace gyrator {
namespace {

// The trapezoidal rule's error falls with the square of its step. ngspice shortens steps by its
// estimate of it (reltol below), which it does not add up over the turns of an oscillation: those
// of the plant get steps of their own, 2 % of a radian, as far as that stays affordable.
constexpr double steps_per_period = 50, most_steps_per_period = 1000;
constexpr double radians_per_step = 0.02;

constexpr std::size_t points_per_line = 4;

// Initial voltages and velocities, currents and efforts of the network's elements, as the model's
// run has them before its first command.
std::vector<double> find_initial_values(const DeviceNetwork& device, const Plant& plant,
                                        const Model& model) {
  const bool linear = device.network.is_linear();
  const NetworkEquations equations =
      linear ? NetworkEquations(device.network) : NetworkEquations::with_ports(device.network);
  const Reduction reduction = reduce(equations.descriptor());
  // The plant's state begins with the network's; positions are appended to it.
  const Eigen::VectorXd state =
      plant.initial_state(model.initial_position, model.initial_velocity).head(reduction.A.rows());
  Eigen::VectorXd inputs = Eigen::VectorXd::Zero(reduction.B.cols());
  inputs(device.external_effort) = model.external_effort;
  if (!linear) {  // the ports' and that of the constant sources come last
    const Eigen::VectorXd at_rest = find_operating_point(device.network).port_inputs;
    inputs.tail(at_rest.size() + 1) << at_rest, 1;
  }
  const Eigen::VectorXd unknowns =
      reduction.recover_state * state + reduction.recover_input * inputs;
  std::vector<double> initial;
  for (int e = 0; e < static_cast<int>(device.network.elements().size()); ++e) {
    const ElementLaw& law = device.network.element({e}).law;
    const bool is_inductor = std::holds_alternative<Inductor>(law);
    const bool has_state = is_inductor || std::holds_alternative<Capacitor>(law);
    const LinearForm form = is_inductor ? equations.through({e}) : equations.across(ElementId{e});
    initial.push_back(has_state ? form.x.dot(unknowns) : 0);
  }
  return initial;
}

// A held input as ngspice's points. Every sample instant has a point too, since ngspice steps
// exactly onto points: there the motion can be compared without interpolation.
// In row k stands what holds before the instant, or with `ahead` 1 what holds from it on.
std::string write_held(const TimeRun& run, const char* column, const Sampling& sampling,
                       std::size_t ahead) {
  const auto& time = run.trace.column("time_s");
  const auto& held = run.trace.column(column);
  const SplitDelay delay = split_delay(sampling);
  const double edge = std::min(spice_edge_periods * delay.period, (delay.period - delay.rest) / 2);
  std::string text = "PWL(";
  std::size_t points = 0;
  const auto add = [&](double t, double value) {
    if (points++ % points_per_line == 0) text += "\n+";
    text += " " + format_number(t) + " " + format_number(value);
  };
  for (std::size_t k = 0; k + 1 < time.size(); ++k) {
    const Rational tick = sampling.period * Rational(static_cast<std::int64_t>(k));
    const double before = held[k > 0 ? k - ahead : 0];
    add(time[k], before);
    const double begin =
        (tick + sampling.delay - Rational(delay.whole) * sampling.period).to_double();
    if (delay.rest > 0) add(begin, before);
    add(begin + edge, held[k + 1 - ahead]);
  }
  add(time.back(), held.back());
  return text + ")";
}

// Our operating point has the mechanics at rest, and a position goes nowhere then.
std::vector<NodeId> find_resting_nodes(const Network& network, NodeId position) {
  std::vector<NodeId> nodes{position};
  for (int i = 1; i < static_cast<int>(network.nodes().size()); ++i) {
    if (network.nodes()[static_cast<std::size_t>(i)].domain == Domain::mechanical)
      nodes.push_back({i});
  }
  return nodes;
}

double choose_step(const Plant& plant, double period, const std::optional<Rational>& wanted) {
  if (wanted) return wanted->to_double();
  double fastest = 0;  // [rad/s]
  if (plant.states() > 0) fastest = compute_poles(plant.A).imag().cwiseAbs().maxCoeff();
  const double steps = fastest * period / radians_per_step;
  return period / std::clamp(steps, steps_per_period, most_steps_per_period);
}

// What ngspice may neglect of currents and efforts, voltages and velocities. Without it, whatever
// starts from zero would be followed through every power of ten with ever shorter steps.
double choose_absolute_tolerance(const Trace& trace) {
  double smallest = 1;
  for (const char* name : {"velocity", "effort", "held_command", "current", "voltage"}) {
    if (std::find(trace.names.begin(), trace.names.end(), name) == trace.names.end()) continue;
    double largest = 0;
    for (const double value : trace.column(name)) largest = std::max(largest, std::abs(value));
    if (largest > 0) smallest = std::min(smallest, largest);
  }
  return 1e-6 * smallest;
}

std::string write_title(const Model& model) {
  const MotionUnits& units = units_of(model.device.motion);
  // The first line is the title; a model's name is free of control characters.
  return fmt::format(
      "{}\n"
      "* Continuous plant of a haptic display, mechanics included; gyrator {}.\n"
      "* Velocity [{}] is voltage and effort [{}] is current: an inertia is a capacitor, a damper\n"
      "* a resistor of its inverse, a spring an inductor of its inverse, a motor a transformer.\n"
      "* Run: ngspice -b THIS_FILE\n\n",
      model.name, version, units.velocity.symbol, units.effort.symbol);
}

// Whether there were any.
bool remove_contacts(Mechanics& mechanics) {
  const bool any = find_dry_friction(mechanics).has_value() || mechanics.stops.has_value();
  mechanics.coulomb_friction = 0;
  mechanics.stiction.reset();
  mechanics.stops.reset();
  return any;
}

}  // namespace

SpiceDeck make_spice_deck(const Model& given, const SpiceRequest& request) {
  if (given.sampling.jitter > Rational(0)) {
    throw Error(ErrorCode::bad_input, given.file + ": /sampling/jitter",
                "in a netlist the command is written at even samples: set it to 0");
  }
  // The deck's command is that of a run without what the deck cannot hold.
  Model model = given;
  const bool leaves_out = remove_contacts(model.device.mechanics);
  SpiceDeck deck;
  SimulationRequest simulation;
  simulation.duration = request.duration;
  simulation.quiet = request.quiet;
  deck.run = run_simulation(model, simulation);
  deck.impedance_file = request.data_name + "_impedance.data";
  deck.motion_file = request.data_name + "_motion.data";
  const auto& columns = deck.run.trace.names;
  deck.has_current = std::find(columns.begin(), columns.end(), "current") != columns.end();

  DeviceNetwork device = build_device_network(model.device, model.held_by);
  const Plant plant = build_moving_plant(device);
  const bool linear = device.network.is_linear();
  SpiceOptions options;
  options.inputs.resize(2);
  options.inputs[static_cast<std::size_t>(device.command)] =
      write_held(deck.run, "held_command", model.sampling, 0);
  options.inputs[static_cast<std::size_t>(device.external_effort)] =
      model.gesture ? write_held(deck.run, "external_effort", {model.sampling.period, 0}, 1)
                    : "DC " + format_number(model.external_effort);
  options.initial = find_initial_values(device, plant, model);
  const MotionUnits& units = units_of(model.device.motion);
  options.mechanical = {std::string(units.inertia.symbol), std::string(units.damping.symbol),
                        std::string(units.stiffness.symbol), std::string(units.velocity.symbol)};
  // The position, as the voltage of an integrator.
  Network& network = device.network;
  const NodeId position = network.add_node("position", Domain::electrical);
  network.add("position.rate", ground, position,
              VoltageControlledCurrentSource{1, device.port, ground}, Role::signal);
  network.add("position.integral", position, ground, Capacitor{1}, Role::signal);
  options.initial.resize(network.elements().size());
  options.initial.back() = deck.run.trace.column("position").front();
  if (!linear) options.held_at_rest = find_resting_nodes(network, position);
  const SpiceNetlist netlist = write_spice_netlist(network, options);

  const auto device_of = [&](const char* name) {
    return netlist.devices[static_cast<std::size_t>(network.find_element(name)->index)];
  };
  const auto node = [&](NodeId id) { return netlist.nodes[static_cast<std::size_t>(id.index)]; };
  const auto current = [&](ElementId id) {
    return netlist.ammeters[static_cast<std::size_t>(id.index)];
  };
  const bool clamped = std::holds_alternative<ClampedOperator>(model.held_by);
  const std::string drive = device_of(clamped ? "operator.clamp" : "operator.external_effort");
  const std::string command = device_of("command");
  const double period = model.sampling.period.to_double();

  std::string& text = deck.text;
  text = write_title(model);
  if (leaves_out)
    text += "* Left out, run and deck alike: dry friction and hard stops of the mechanics.\n\n";
  text += netlist.lines;
  text += fmt::format("* Position: 1 V is 1 {}, the integral of the port's velocity.\n",
                      units.position.symbol);
  text += fmt::format(
      "\n* {2}. Breakpoints as close as an edge.\n"
      ".options{3} method=trap reltol=1e-7 vntol={0} abstol={0} chgtol=1e-20 trtol=1"
      " minbreak={1}\n",
      format_number(choose_absolute_tolerance(deck.run.trace)),
      format_number(spice_edge_periods * period / 100),
      linear ? "No operating point before .ac: a free device has none"
             : "The operating point before .ac has the mechanics at rest",
      linear ? " noopac" : "");
  text += fmt::format(
      "\n.control\nset numdgt=16\nset wr_singlescale\nset wr_vecnames\n"
      "* The port driven, then the command: Z = f/v, and A = Z v - f.\n"
      "alter @{0}[acmag] = 1\nac dec {2} {3} {4}\n"
      "alter @{0}[acmag] = 0\nalter @{1}[acmag] = 1\nac dec {2} {3} {4}\n"
      "let impedance = ac1.i({5})/ac1.v({6})\n"
      "let actuation = impedance*ac2.v({6}) - ac2.i({5})\n"
      "wrdata {7} impedance actuation\n",
      drive, command, request.points_per_decade, format_number(request.from_hz),
      format_number(request.to_hz), current(device.operator_ammeter), node(device.port),
      deck.impedance_file);
  text += netlist.release;
  text += fmt::format(
      "* The motion under the command as it was held, from the model's initial state.\n"
      "tran {0} {1} 0 {0} uic\n"
      "let position = v({2})\nlet velocity = v({3})\nlet command = v({4})\n",
      format_number(choose_step(plant, period, request.largest_step)),
      format_number(deck.run.final_time_s), node(position), node(device.port),
      node(*network.find_node("command")));
  if (deck.has_current)
    text += fmt::format("let current = i({})\n", current(*device.drive.motor_ammeter));
  text += fmt::format(
      "wrdata {0} position velocity command{1}\n"
      "echo Z and A over frequency are in {2}, the motion over time is in "
      "{0}.\nquit\n.endc\n.end\n",
      deck.motion_file, deck.has_current ? " current" : "", deck.impedance_file);
  return deck;
}

}  // namespace gyrator
