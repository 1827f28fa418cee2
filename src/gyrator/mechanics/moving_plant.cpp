#include "gyrator/circuits/operating_point.hpp"
#include "gyrator/core/error.hpp"
#include "gyrator/mechanics/plant.hpp"
#include "gyrator/mechanics/plant_assembly.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace gyrator {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::RowVectorXd;
using Eigen::VectorXd;

// One more state at the end that takes no part in motion and energy: a temperature.
void append_thermal_state(Plant& plant, const std::string& name) {
  const Index n = plant.A.rows();
  plant.A.conservativeResizeLike(MatrixXd::Zero(n + 1, n + 1));
  plant.B.conservativeResizeLike(MatrixXd::Zero(n + 1, plant.B.cols()));
  plant.rest.conservativeResizeLike(MatrixXd::Zero(n + 1, 2));
  for (Signal* signal :
       {&plant.port_position, &plant.port_velocity, &plant.sensor_position, &plant.port_effort})
    signal->state = grow_row(signal->state);
  for (auto& signal : plant.others) signal.state = grow_row(signal.state);
  auto& e = plant.energy;
  for (MatrixXd* form : {&e.stored, &e.dissipated, &e.source, &e.operator_work, &e.source_jump})
    *form = grow_form(*form, n);
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
  Plant plant = assemble_plant(device, equations, reduction);
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
