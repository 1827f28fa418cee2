#include "gyrator/mechanics/plant.hpp"

#include "gyrator/circuits/operating_point.hpp"
#include "gyrator/core/error.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include <fmt/core.h>

namespace gyrator {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::RowVectorXd;
using Eigen::VectorXd;

MatrixXd grow(const MatrixXd& form, Index at) {
  // One more row and column of zeros at index `at`, for a state that takes no part in the energy.
  MatrixXd grown = MatrixXd::Zero(form.rows() + 1, form.cols() + 1);
  const Index tail = form.rows() - at;
  grown.topLeftCorner(at, at) = form.topLeftCorner(at, at);
  grown.bottomRightCorner(tail, tail) = form.bottomRightCorner(tail, tail);
  grown.topRightCorner(at, tail) = form.topRightCorner(at, tail);
  grown.bottomLeftCorner(tail, at) = form.bottomLeftCorner(tail, at);
  return grown;
}

RowVectorXd grow(const RowVectorXd& row) {
  RowVectorXd grown = RowVectorXd::Zero(row.size() + 1);
  grown.head(row.size()) = row;
  return grown;
}

// A row g with g A = velocity and g B = velocity_input, where the state holds the position already.
std::optional<RowVectorXd> find_held_position(const MatrixXd& A, const MatrixXd& B,
                                              const Signal& velocity) {
  const Index n = A.rows();
  if (n == 0) return std::nullopt;
  MatrixXd equations(A.cols() + B.cols(), n);
  equations << A.transpose(), B.transpose();
  VectorXd wanted(A.cols() + B.cols());
  wanted << velocity.state.transpose(), velocity.input.transpose();
  // Rows differ by their units: scale each to one before asking whether they can all be met.
  for (Index i = 0; i < equations.rows(); ++i) {
    const double size = std::max(equations.row(i).cwiseAbs().maxCoeff(), std::abs(wanted(i)));
    if (size > 0) {
      equations.row(i) /= size;
      wanted(i) /= size;
    }
  }
  const VectorXd columns = equations.colwise().norm().transpose().cwiseMax(1e-300);
  const MatrixXd scaled = equations * columns.cwiseInverse().asDiagonal();
  const Eigen::CompleteOrthogonalDecomposition<MatrixXd> decomposition(scaled);
  VectorXd g = decomposition.solve(wanted);
  if ((scaled * g - wanted).norm() > 1e-10 * wanted.norm()) return std::nullopt;
  // States that take no part have been left with rounding: a run from rest would start with it.
  g = (g.array().abs() < 1e-12 * g.cwiseAbs().maxCoeff()).select(0, g).eval();
  return RowVectorXd((g.array() / columns.array()).transpose());
}

// Position as the integral of a velocity: held by the state, or appended as a state of its own.
Signal append_position(Plant& plant, std::string name, const Signal& velocity,
                       std::vector<Signal*> signals) {
  if (const auto held = find_held_position(plant.A, plant.B, velocity)) {
    return {std::move(name), *held, RowVectorXd::Zero(plant.B.cols())};
  }
  const Index n = plant.A.rows();
  MatrixXd A = MatrixXd::Zero(n + 1, n + 1);
  A.topLeftCorner(n, n) = plant.A;
  A.row(n).head(n) = velocity.state;
  MatrixXd B(n + 1, plant.B.cols());
  B << plant.B, velocity.input;
  plant.A = A;
  plant.B = B;
  for (Signal* signal : signals) signal->state = grow(signal->state);
  for (auto& signal : plant.others) signal.state = grow(signal.state);
  auto& e = plant.energy;
  for (MatrixXd* form : {&e.stored, &e.dissipated, &e.source, &e.operator_work, &e.source_jump}) {
    *form = grow(*form, n);
  }
  RowVectorXd row = RowVectorXd::Zero(n + 1);
  row(n) = 1;
  return {std::move(name), row, RowVectorXd::Zero(plant.B.cols())};
}

Signal as_signal(std::string name, const ReducedForm& form) {
  return {std::move(name), form.state, form.input};
}

// The unknowns after a slow rigid displacement by one: what integrates the velocities `moving`.
VectorXd displace(const DeviceNetwork& device, const NetworkEquations& equations,
                  const VectorXd& moving) {
  VectorXd displaced = VectorXd::Zero(moving.size());
  const auto& elements = device.network.elements();
  for (int e = 0; e < static_cast<int>(elements.size()); ++e) {
    const Element& element = elements[static_cast<std::size_t>(e)];
    const auto* spring = std::get_if<Inductor>(&element.law);
    if (!spring) continue;
    const double rate = equations.across(ElementId{e}).x.dot(moving);
    displaced += equations.through(ElementId{e}).x.transpose() * (rate / spring->inductance);
  }
  for (const NodeId position : device.drive.positions)
    displaced += equations.across(position).x.transpose();
  return displaced;
}

}  // namespace

namespace {

Plant assemble(const DeviceNetwork& device, const NetworkEquations& equations,
               const Reduction& reduction) {
  Plant plant;
  plant.A = reduction.A;
  plant.B = reduction.B;
  plant.energy = build_energy_forms(equations, reduction, device.operator_ammeter);

  const auto read = [&](std::string name, const LinearForm& form) {
    const ReducedForm reduced = reduction.reduce(form);
    if (!reduced.state.allFinite() || reduced.input_rate.cwiseAbs().maxCoeff() >
                                          1e-9 * (1 + reduced.input.cwiseAbs().maxCoeff())) {
      throw Error(
          ErrorCode::numerical, name,
          "would need the derivative of the command: a step of it gives an impulse here; add the "
          "amplifier's bandwidth, a resistance or a compliance that the real device has");
    }
    return as_signal(std::move(name), reduced);
  };
  plant.port_velocity = read("velocity", equations.across(device.port));
  Signal sensor_velocity = read("sensor_velocity", find_sensed_rate(device, equations));
  plant.port_effort = read("effort", equations.through(device.operator_ammeter));
  const auto read_if_finite = [&](std::string name, const LinearForm& form) {
    const ReducedForm reduced = reduction.reduce(form);
    if (reduced.input_rate.isZero(1e-12))
      plant.others.push_back(as_signal(std::move(name), reduced));
  };
  if (device.drive.motor_ammeter)
    read_if_finite("current", equations.through(*device.drive.motor_ammeter));
  if (device.drive.terminal) read_if_finite("voltage", equations.across(*device.drive.terminal));

  // At rest electrically, every inertia at the given velocity: of all unknowns only the
  // mechanical node velocities are set.
  VectorXd moving = VectorXd::Zero(equations.descriptor().size());
  const auto& nodes = device.network.nodes();
  for (std::size_t node = 1; node < nodes.size(); ++node) {
    if (nodes[node].domain == Domain::mechanical) moving(static_cast<Index>(node) - 1) = 1;
  }
  const VectorXd at_velocity = reduction.initialize * moving;

  // The network may hold the second of the two in terms of the first. A position is at its best as
  // a state or a spring of its own, so that the wave's integral comes after it.
  const bool wave = device.sensor == SensorLocation::outgoing_wave;
  if (!wave) {
    plant.sensor_position =
        append_position(plant, "sensor_position", sensor_velocity,
                        {&plant.port_velocity, &plant.port_effort, &sensor_velocity});
  }
  if (device.collocated) {
    plant.port_position = plant.sensor_position;
    plant.port_position.name = "position";
  } else {
    std::vector<Signal*> others{&plant.port_velocity, &plant.port_effort, &sensor_velocity};
    if (!wave) others.push_back(&plant.sensor_position);
    plant.port_position = append_position(plant, "position", plant.port_velocity, others);
  }
  const Index before_wave = plant.A.rows();
  if (wave) {
    plant.sensor_position = append_position(
        plant, wave_integral_name, sensor_velocity,
        {&plant.port_velocity, &plant.port_effort, &plant.port_position, &sensor_velocity});
  }

  // A rigid displacement deflects the springs to ground and moves every position, those appended
  // above included; that of the sensor exactly so.
  plant.rest = MatrixXd::Zero(plant.A.rows(), 2);
  plant.rest.col(1).head(at_velocity.size()) = at_velocity;
  plant.rest.col(0).setOnes();
  plant.rest.col(0).head(at_velocity.size()) =
      reduction.initialize * displace(device, equations, moving);
  const double moved = plant.port_position.state.dot(plant.rest.col(0));
  if (moved != 0) {
    plant.rest.col(0) /= moved;
  } else {
    plant.rest.col(0).setZero();  // a clamped port stays at zero
  }
  if (wave && plant.A.rows() > before_wave) plant.rest(before_wave, 0) = 0;
  return plant;
}

// One more state at the end that takes no part in motion and energy: a temperature.
void append_thermal_state(Plant& plant, const std::string& name) {
  const Index n = plant.A.rows();
  plant.A.conservativeResizeLike(MatrixXd::Zero(n + 1, n + 1));
  plant.B.conservativeResizeLike(MatrixXd::Zero(n + 1, plant.B.cols()));
  plant.rest.conservativeResizeLike(MatrixXd::Zero(n + 1, 2));
  for (Signal* signal :
       {&plant.port_position, &plant.port_velocity, &plant.sensor_position, &plant.port_effort})
    signal->state = grow(signal->state);
  for (auto& signal : plant.others) signal.state = grow(signal.state);
  auto& e = plant.energy;
  for (MatrixXd* form : {&e.stored, &e.dissipated, &e.source, &e.operator_work, &e.source_jump})
    *form = grow(*form, n);
  RowVectorXd row = RowVectorXd::Zero(n + 1);
  row(n) = 1;
  plant.others.push_back({name, row, RowVectorXd::Zero(plant.B.cols())});
}

// Ports whose arguments follow from the held inputs alone: their w is constant between jumps.
std::vector<bool> find_held_ports(const MatrixXd& C, const MatrixXd& F) {
  const auto p = static_cast<std::size_t>(C.rows());
  std::vector<bool> held(p);
  for (std::size_t k = 0; k < p; ++k) held[k] = C.row(static_cast<Index>(k)).isZero(0);
  for (std::size_t round = 0; round < p; ++round) {
    for (std::size_t k = 0; k < p; ++k) {
      for (std::size_t j = 0; j < p; ++j) {
        if (F(static_cast<Index>(k), static_cast<Index>(j)) != 0 && !held[j]) held[k] = false;
      }
    }
  }
  return held;
}

// Motion and energy must not need dw/dt of a port that varies between jumps: it is not known.
void require_no_rates(const NetworkEquations& equations, const Reduction& reduction) {
  const Network& network = equations.network();
  const auto ports = static_cast<Index>(equations.ports().size());
  const auto given = static_cast<Index>(network.inputs().size());
  MatrixXd C(ports, reduction.A.rows());
  MatrixXd F(ports, ports);
  const auto rate_of = [&](const LinearForm& form) { return reduction.reduce(form).input_rate; };
  const auto refuse = [](const std::string& name) {
    throw Error(ErrorCode::numerical, name,
                "would need the derivative of a quantity that is limited or nonlinear: add the "
                "amplifier's bandwidth or the resistance that the real circuit has here");
  };
  Index k = 0;
  for (int e = 0; e < static_cast<int>(network.elements().size()); ++e) {
    if (!is_nonlinear(network.element({e}).law)) continue;
    const LinearForm form = equations.argument({e});
    const ReducedForm argument = reduction.reduce(form);
    C.row(k) = argument.state;
    F.row(k++) = argument.input.segment(given, ports);
    if (!rate_of(form).head(given + ports).isZero(1e-12)) refuse(network.element({e}).name);
  }
  const std::vector<bool> held = find_held_ports(C, F);
  for (int e = 0; e < static_cast<int>(network.elements().size()); ++e) {
    const Element& element = network.element({e});
    if (std::holds_alternative<Capacitor>(element.law)) continue;
    for (const LinearForm& form : {equations.through({e}), equations.across(ElementId{e})}) {
      const RowVectorXd rate = rate_of(form);
      if (element.role != Role::contact && !rate.segment(2, given - 2).isZero(1e-12))
        refuse(element.name);
      for (Index port = 0; port < ports; ++port) {
        if (!held[static_cast<std::size_t>(port)] && std::abs(rate(given + port)) > 1e-12)
          refuse(element.name);
      }
    }
  }
}

// ξ from the unknowns x = recover_state ξ + recover_input U. Those that store something tell all;
// of the others, what holds the mechanics at rest at an operating point is not among them.
VectorXd find_state(const Descriptor& descriptor, const Reduction& reduction, const VectorXd& x,
                    const VectorXd& inputs) {
  std::vector<Index> storing;
  for (Index j = 0; j < descriptor.size(); ++j) {
    if (!descriptor.E.col(j).isZero(0)) storing.push_back(j);
  }
  if (reduction.A.rows() == 0) return VectorXd(0);
  const VectorXd rest = x - reduction.recover_input * inputs;
  return reduction.recover_state(storing, Eigen::all).colPivHouseholderQr().solve(rest(storing));
}

// A, B of small deviations from the point where the ports' slopes are `slopes` (dw/dy).
void set_tangent(Plant& plant, const VectorXd& slopes) {
  const NonlinearPart& nl = *plant.nonlinear;
  const Index p = slopes.size();
  const MatrixXd G = nl.port_columns(nl.B) * slopes.asDiagonal();
  const MatrixXd loop = MatrixXd::Identity(p, p) - nl.port_columns(nl.D) * slopes.asDiagonal();
  const Eigen::PartialPivLU<MatrixXd> lu(loop);
  plant.A = nl.A;
  plant.B = nl.B.leftCols(2);
  if (p > 0) {
    plant.A += G * lu.solve(nl.C);
    plant.B += G * lu.solve(nl.D.leftCols(2));
  }
  for (const auto& t : nl.thermal)
    plant.A(t.state, t.state) = -1 / (t.law.thermal_resistance * t.law.thermal_capacity);
}

// The network with an input for the effort of each contact.
DeviceNetwork add_contact_inputs(const DeviceNetwork& device) {
  DeviceNetwork with = device;
  Network& network = with.network;
  const int friction = network.add_input("friction");
  const int stop = network.add_input("stop_effort");
  network.add_input("stop_deflection");
  network.add("mechanics.friction", ground, with.motor_shaft, CurrentSource{friction},
              Role::contact);
  network.add("mechanics.stops", ground, with.port, CurrentSource{stop}, Role::contact);
  return with;
}

// Friction and stops as signals and in the ledger: both are quadratic in [ξ; U] in every mode.
void add_contacts(Plant& plant, const DeviceNetwork& device, const ReducedForm& shaft_velocity) {
  NonlinearPart& nl = *plant.nonlinear;
  const Index n = plant.states();
  const Index m = nl.B.cols();
  Signal shaft{"shaft_velocity", RowVectorXd::Zero(n), shaft_velocity.input};
  shaft.state.head(shaft_velocity.state.size()) = shaft_velocity.state;
  for (const Signal* s : {&shaft, &plant.port_velocity, &plant.port_position}) {
    if (!s->input.isZero(1e-12)) {
      throw Error(ErrorCode::numerical, "mechanics",
                  "the " + s->name +
                      " would jump with the command: friction and stops need an "
                      "inertia behind the drive");
    }
  }
  nl.contacts = NonlinearPart::Contacts{device.friction, device.stops, shaft};

  const auto row_of = [&](const RowVectorXd& state, Index input) {
    RowVectorXd row = RowVectorXd::Zero(n + m);
    row.head(n) = state;
    if (input >= 0) row(n + input) = 1;
    return row;
  };
  const RowVectorXd none = RowVectorXd::Zero(n);
  const auto add = [](MatrixXd& form, double factor, const RowVectorXd& a, const RowVectorXd& b) {
    form += factor / 2 * (a.transpose() * b + b.transpose() * a);
  };
  auto& e = plant.energy;
  if (device.friction) {
    const RowVectorXd effort = row_of(none, NonlinearPart::friction_input);
    add(e.dissipated, -1, effort, row_of(shaft.state, -1));
    plant.others.push_back({"friction", none, effort.tail(m)});
  }
  if (device.stops) {
    const RowVectorXd effort = row_of(none, NonlinearPart::stop_input);
    const RowVectorXd deflection = row_of(none, NonlinearPart::deflection_input);
    add(e.stored, device.stops->stiffness / 2, deflection, deflection);
    add(e.dissipated, -1, effort + device.stops->stiffness * deflection,
        row_of(plant.port_velocity.state, -1));
    plant.others.push_back({"stop_effort", none, effort.tail(m)});
  }
}

// A law that felt a contact's effort at once would close a second loop around both.
void require_inertia_at_contacts(const NonlinearPart& nl) {
  for (std::size_t k = 0; k < nl.ports.size(); ++k) {
    if (nl.D.row(static_cast<Index>(k)).segment(2, 3).isZero(1e-12)) continue;
    throw Error(ErrorCode::numerical, nl.ports[k].element,
                "feels friction or a stop without an inertia between: not simulated");
  }
}

}  // namespace

Plant build_plant(const DeviceNetwork& device) {
  const NetworkEquations equations(device.network);
  return assemble(device, equations, reduce(equations.descriptor()));
}

bool NonlinearPart::is_piecewise_linear() const {
  return std::all_of(ports.begin(), ports.end(), [](const NonlinearPort& port) {
    return gyrator::is_piecewise_linear(port.law);
  });
}

Plant build_moving_plant(const DeviceNetwork& given) {
  const bool touches = given.friction || given.stops;
  if (given.network.is_linear() && !touches) return build_plant(given);
  const DeviceNetwork device = touches ? add_contact_inputs(given) : given;
  const Network& network = device.network;
  const NetworkEquations equations = NetworkEquations::with_ports(network);
  const Reduction reduction = reduce(equations.descriptor());
  require_no_rates(equations, reduction);
  Plant plant = assemble(device, equations, reduction);
  const OperatingPoint point = find_operating_point(network);

  NonlinearPart nl;
  if (const auto element = network.find_nonlinear()) {
    nl.named_by = network.element(*element).name;
  } else {
    nl.named_by = device.friction ? "mechanics.friction" : "mechanics.stops";
  }
  nl.ports = equations.ports();
  const auto p = static_cast<Index>(nl.ports.size());
  for (Index k = 0; k < p; ++k) {
    const auto* warm = std::get_if<ThermalResistor>(&nl.ports[static_cast<std::size_t>(k)].law);
    if (!warm) continue;
    nl.thermal.push_back({k, plant.states(), *warm});
    const bool first = nl.thermal.size() == 1;
    append_thermal_state(
        plant, first ? "winding_temperature_rise"
                     : nl.ports[static_cast<std::size_t>(k)].element + ".temperature_rise");
  }
  const Index n = plant.states();
  nl.A = plant.A;
  nl.B = plant.B;
  nl.C = MatrixXd::Zero(p, n);
  nl.D = MatrixXd::Zero(p, plant.B.cols());
  nl.at_rest = Eigen::Map<const VectorXd>(point.arguments.data(), p);
  Index k = 0;
  VectorXd slopes(p);
  for (int e = 0; e < static_cast<int>(network.elements().size()); ++e) {
    if (!is_nonlinear(network.element({e}).law)) continue;
    const ReducedForm argument = reduction.reduce(equations.argument({e}));
    nl.C.row(k).head(argument.state.size()) = argument.state;
    nl.D.row(k) = argument.input;
    const NonlinearPort& port = nl.ports[static_cast<std::size_t>(k)];
    const auto* warm = std::get_if<ThermalResistor>(&port.law);
    slopes(k) = evaluate_law(port.law, nl.at_rest(k), warm ? warm->initial_rise : 0).slope +
                port.leak - port.companion;
    ++k;
  }

  VectorXd inputs = VectorXd::Zero(plant.B.cols());
  inputs.tail(p + 1) << point.port_inputs, 1;
  plant.bias = VectorXd::Zero(n);
  plant.bias.head(reduction.A.rows()) =
      find_state(equations.descriptor(), reduction, point.unknowns, inputs);
  for (const auto& t : nl.thermal) plant.bias(t.state) = t.law.initial_rise;
  plant.nonlinear = std::move(nl);
  if (touches) {
    require_inertia_at_contacts(*plant.nonlinear);
    add_contacts(plant, device, reduction.reduce(equations.across(device.motor_shaft)));
  }
  set_tangent(plant, slopes);
  return plant;
}

}  // namespace gyrator
