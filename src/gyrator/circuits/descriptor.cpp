#include "gyrator/circuits/descriptor.hpp"

#include "gyrator/circuits/operating_point.hpp"
#include "gyrator/core/error.hpp"

#include <cmath>
#include <limits>
#include <numbers>
#include <utility>

#include <fmt/core.h>
#include <fmt/ranges.h>

namespace gyrator {
namespace {

template <class... Ts>
struct Overloaded : Ts... {
  using Ts::operator()...;
};

bool has_branch_unknown(const ElementLaw& law) {
  return std::holds_alternative<Inductor>(law) || std::holds_alternative<VoltageSource>(law) ||
         std::holds_alternative<VoltageControlledVoltageSource>(law) ||
         std::holds_alternative<CurrentControlledVoltageSource>(law) ||
         std::holds_alternative<Transformer>(law) || std::holds_alternative<IdealOpAmp>(law) ||
         std::holds_alternative<ConstantVoltageSource>(law) ||
         (is_nonlinear(law) &&
          (kind_of(law) == LawKind::resistance || kind_of(law) == LawKind::voltage_source));
}

// Nodes whose voltage controls a limited source.
std::pair<NodeId, NodeId> control_of(const ElementLaw& law) {
  if (const auto* e = std::get_if<LimitedVoltageControlledVoltageSource>(&law))
    return {e->control_positive, e->control_negative};
  const auto& e = std::get<LimitedVoltageControlledCurrentSource>(law);
  return {e.control_positive, e.control_negative};
}

}  // namespace

NetworkEquations::NetworkEquations(const Network& network)
    : NetworkEquations(network,
                       network.is_linear() ? std::vector<double>(network.elements().size())
                                           : find_operating_point(network).slopes,
                       false) {}

NetworkEquations NetworkEquations::with_ports(const Network& network) {
  return {network, std::vector<double>(network.elements().size()), true};
}

NetworkEquations NetworkEquations::with_slopes(const Network& network,
                                               const std::vector<double>& slopes) {
  return {network, slopes, false};
}

NetworkEquations::NetworkEquations(const Network& network, std::vector<double> slopes, bool ported)
    : network_(network), slopes_(std::move(slopes)), port_input_(slopes_.size(), -1) {
  const auto& elements = network_.elements();
  const auto& nodes = network_.nodes();
  int size = static_cast<int>(nodes.size()) - 1;
  for (const auto& element : elements)
    branch_.push_back(has_branch_unknown(element.law) ? size++ : -1);
  auto inputs = static_cast<int>(network_.inputs().size());
  for (std::size_t e = 0; ported && e < elements.size(); ++e) {
    if (!is_nonlinear(elements[e].law)) continue;
    port_input_[e] = inputs++;
    ports_.push_back(make_port(elements[e]));
    slopes_[e] = ports_.back().companion;
  }
  if (ported) constant_input_ = inputs++;

  auto& d = descriptor_;
  d.E = Eigen::MatrixXd::Zero(size, size);
  d.A = Eigen::MatrixXd::Zero(size, size);
  d.B = Eigen::MatrixXd::Zero(size, inputs);
  d.unknown_names.resize(static_cast<std::size_t>(size));
  d.equation_elements.resize(static_cast<std::size_t>(size));
  for (int node = 1; node < static_cast<int>(nodes.size()); ++node) {
    const auto row = static_cast<std::size_t>(node - 1);
    d.unknown_names[row] = nodes[static_cast<std::size_t>(node)].name;
    d.equation_elements[row] = network_.elements_at({node});
  }
  for (int e = 0; e < static_cast<int>(elements.size()); ++e) {
    const int branch = branch_of({e});
    if (branch >= 0) {
      d.unknown_names[static_cast<std::size_t>(branch)] =
          elements[static_cast<std::size_t>(e)].name;
      d.equation_elements[static_cast<std::size_t>(branch)] = {
          elements[static_cast<std::size_t>(e)].name};
    }
    stamp({e});
  }
}

// A through quantity `factor * x[column]` leaves `positive` and enters `negative`. Kirchhoff's
// rows sum what leaves a node to zero, so that it stands on the right-hand side with a minus.
void NetworkEquations::stamp_flow(NodeId positive, NodeId negative, int column, double factor) {
  if (positive != ground) descriptor_.A(positive.index - 1, column) -= factor;
  if (negative != ground) descriptor_.A(negative.index - 1, column) += factor;
}

void NetworkEquations::stamp_across(int row, NodeId positive, NodeId negative, double factor) {
  if (positive != ground) descriptor_.A(row, positive.index - 1) += factor;
  if (negative != ground) descriptor_.A(row, negative.index - 1) -= factor;
}

void NetworkEquations::stamp(ElementId id) {
  const Element& element = network_.element(id);
  const NodeId p = element.positive;
  const NodeId n = element.negative;
  const int branch = branch_of(id);
  auto& d = descriptor_;

  // i = g (v_a - v_b) through the element
  const auto stamp_transconductance = [&](NodeId from, NodeId to, NodeId a, NodeId b, double g) {
    if (a != ground) stamp_flow(from, to, a.index - 1, g);
    if (b != ground) stamp_flow(from, to, b.index - 1, -g);
  };
  const auto control_branch = [&](ElementId control) {
    const int column = branch_of(control);
    if (column < 0) {
      throw Error(
          ErrorCode::bad_input, element.name,
          fmt::format(
              "controlled by the current of {}: only a source, an inductor or a transformer "
              "can be sensed; put an ammeter in series",
              network_.element(control).name));
    }
    return column;
  };

  std::visit(
      Overloaded{
          [&](const Resistor& e) { stamp_transconductance(p, n, p, n, 1 / e.resistance); },
          [&](const Conductance& e) { stamp_transconductance(p, n, p, n, e.conductance); },
          [&](const Inductor& e) {
            stamp_flow(p, n, branch, 1);
            d.E(branch, branch) = e.inductance;  // L di/dt = v_p - v_n
            stamp_across(branch, p, n, 1);
          },
          [&](const Capacitor& e) {  // C d(v_p - v_n)/dt leaves p and enters n
            const auto add = [&](NodeId row, NodeId column, double c) {
              if (row != ground && column != ground) d.E(row.index - 1, column.index - 1) += c;
            };
            add(p, p, e.capacitance);
            add(n, n, e.capacitance);
            add(p, n, -e.capacitance);
            add(n, p, -e.capacitance);
          },
          [&](const VoltageSource& e) {  // 0 = v_p - v_n - u
            stamp_flow(p, n, branch, 1);
            stamp_across(branch, p, n, 1);
            if (e.input) d.B(branch, *e.input) = -1;
          },
          [&](const CurrentSource& e) { stamp_input_flow(p, n, e.input, 1); },
          [&](const VoltageControlledVoltageSource& e) {
            stamp_flow(p, n, branch, 1);
            stamp_across(branch, p, n, 1);
            stamp_across(branch, e.control_positive, e.control_negative, -e.gain);
          },
          [&](const VoltageControlledCurrentSource& e) {
            stamp_transconductance(p, n, e.control_positive, e.control_negative,
                                   e.transconductance);
          },
          [&](const CurrentControlledVoltageSource& e) {
            stamp_flow(p, n, branch, 1);
            stamp_across(branch, p, n, 1);
            d.A(branch, control_branch(e.control)) -= e.transresistance;
          },
          [&](const CurrentControlledCurrentSource& e) {
            stamp_flow(p, n, control_branch(e.control), e.gain);
          },
          [&](const Transformer& e) {  // 0 = v - n v_2,  i_2 = -n i
            stamp_flow(p, n, branch, 1);
            stamp_flow(e.second_positive, e.second_negative, branch, -e.ratio);
            stamp_across(branch, p, n, 1);
            stamp_across(branch, e.second_positive, e.second_negative, -e.ratio);
          },
          [&](const Gyrator& e) {
            stamp_transconductance(p, n, e.second_positive, e.second_negative, e.transconductance);
            stamp_transconductance(e.second_positive, e.second_negative, p, n, -e.transconductance);
          },
          [&](const MutualInductance& e) {
            d.E(branch_of(e.first), branch_of(e.second)) += e.inductance;
            d.E(branch_of(e.second), branch_of(e.first)) += e.inductance;
          },
          [&](const IdealOpAmp& e) {  // 0 = v_+ - v_-
            stamp_flow(p, n, branch, 1);
            stamp_across(branch, e.control_positive, e.control_negative, 1);
          },
          [&](const ConstantVoltageSource& e) {
            stamp_flow(p, n, branch, 1);
            stamp_across(branch, p, n, 1);
            if (constant_input_ >= 0) d.B(branch, constant_input_) = -e.voltage;
          },
          [&](const ConstantCurrentSource& e) {
            if (constant_input_ >= 0) stamp_input_flow(p, n, constant_input_, e.current);
          },
          [&](const auto&) { stamp_port(id); },
      },
      element.law);
}

void NetworkEquations::stamp_input_flow(NodeId positive, NodeId negative, int input,
                                        double factor) {
  if (positive != ground) descriptor_.B(positive.index - 1, input) -= factor;
  if (negative != ground) descriptor_.B(negative.index - 1, input) += factor;
}

// slope * y of a nonlinear law; what is left of it is the port's input.
void NetworkEquations::stamp_port(ElementId id) {
  const Element& element = network_.element(id);
  const NodeId p = element.positive;
  const NodeId n = element.negative;
  const LawKind kind = kind_of(element.law);
  const double slope = slopes_[static_cast<std::size_t>(id.index)];
  const int port = port_input_[static_cast<std::size_t>(id.index)];
  if (const int branch = branch_of(id); branch >= 0) {  // 0 = v - slope y - w
    stamp_flow(p, n, branch, 1);
    stamp_across(branch, p, n, 1);
    descriptor_.A.row(branch) -= slope * argument(id).x;
    if (port >= 0) descriptor_.B(branch, port) = -1;
    return;
  }
  const auto [a, b] = kind == LawKind::conductance ? std::pair{p, n} : control_of(element.law);
  if (a != ground) stamp_flow(p, n, a.index - 1, slope);
  if (b != ground) stamp_flow(p, n, b.index - 1, -slope);
  if (port >= 0) stamp_input_flow(p, n, port, 1);
}

LinearForm NetworkEquations::argument(ElementId id) const {
  const Element& element = network_.element(id);
  switch (kind_of(element.law)) {
    case LawKind::conductance:
      return across(id);
    case LawKind::resistance:
      return through(id);
    case LawKind::voltage_source:
    case LawKind::current_source:
      break;
  }
  const auto [a, b] = control_of(element.law);
  return across(a, b);
}

LinearForm NetworkEquations::across(NodeId positive, NodeId negative) const {
  LinearForm form{Eigen::RowVectorXd::Zero(descriptor_.size()),
                  Eigen::RowVectorXd::Zero(descriptor_.B.cols())};
  if (positive != ground) form.x(positive.index - 1) += 1;
  if (negative != ground) form.x(negative.index - 1) -= 1;
  return form;
}

LinearForm NetworkEquations::across(ElementId element) const {
  return across(network_.element(element).positive, network_.element(element).negative);
}

LinearForm NetworkEquations::through(ElementId id) const {
  const Element& element = network_.element(id);
  LinearForm form = across(ground);
  if (branch_of(id) >= 0) {
    form.x(branch_of(id)) = 1;
    return form;
  }
  std::visit(
      Overloaded{
          [&](const Resistor& e) { form.x = across(id).x / e.resistance; },
          [&](const Conductance& e) { form.x = across(id).x * e.conductance; },
          [&](const CurrentSource& e) { form.u(e.input) = 1; },
          [&](const VoltageControlledCurrentSource& e) {
            form.x = across(e.control_positive, e.control_negative).x * e.transconductance;
          },
          [&](const CurrentControlledCurrentSource& e) { form.x(branch_of(e.control)) = e.gain; },
          [&](const Gyrator& e) {
            form.x = across(e.second_positive, e.second_negative).x * e.transconductance;
          },
          [&](const MutualInductance&) {},  // carries none of its own
          [&](const ConstantCurrentSource& e) {
            if (constant_input_ >= 0) form.u(constant_input_) = e.current;
          },
          [&](const auto& law) {
            if (is_nonlinear(law)) {
              const int port = port_input_[static_cast<std::size_t>(id.index)];
              form.x = argument(id).x * slopes_[static_cast<std::size_t>(id.index)];
              if (port >= 0) form.u(port) = 1;
              return;
            }
            throw Error(ErrorCode::bad_input, element.name,
                        "the current of a capacitor is the derivative of an unknown: put an "
                        "ammeter in series");
          },
      },
      element.law);
  return form;
}

Eigen::MatrixXcd solve_descriptor(const Descriptor& descriptor, std::complex<double> s) {
  const Eigen::MatrixXcd pencil = s * descriptor.E.cast<std::complex<double>>() - descriptor.A;
  const Eigen::MatrixXcd solution =
      pencil.partialPivLu().solve(descriptor.B.cast<std::complex<double>>());
  if (!solution.allFinite()) {
    // The unknown that the singular equations leave free, and the elements around it.
    Eigen::Index unknown = 0;
    if (pencil.allFinite()) {
      Eigen::FullPivLU<Eigen::MatrixXcd>(pencil).kernel().col(0).cwiseAbs().maxCoeff(&unknown);
    } else {
      while (pencil.row(unknown).allFinite()) ++unknown;
    }
    throw_singular_pencil(descriptor.equation_elements[static_cast<std::size_t>(unknown)], s);
  }
  return solution;
}

void throw_singular_pencil(const std::vector<std::string>& elements, std::complex<double> s) {
  throw Error(ErrorCode::numerical, fmt::format("{}", fmt::join(elements, ", ")),
              fmt::format("the network's equations are singular to rounding at {:g} Hz: values out "
                          "of all proportion to the others",
                          std::abs(s) / (2 * std::numbers::pi)));
}

Eigen::MatrixXd solve_steady_state(const Descriptor& descriptor) {
  const Eigen::FullPivLU<Eigen::MatrixXd> lu(descriptor.A);
  Eigen::MatrixXd x = lu.solve(-descriptor.B);
  for (Eigen::Index input = 0; input < x.cols(); ++input) {
    const double residual = (descriptor.A * x.col(input) + descriptor.B.col(input)).norm();
    if (!(residual <= 1e-9 * descriptor.B.col(input).norm())) {
      x.col(input).setConstant(std::numeric_limits<double>::quiet_NaN());
    }
  }
  return x;
}

}  // namespace gyrator
