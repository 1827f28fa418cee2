#include "gyrator/circuits/operating_point.hpp"

#include "gyrator/circuits/descriptor.hpp"
#include "gyrator/circuits/port_loop.hpp"
#include "gyrator/circuits/reduction.hpp"
#include "gyrator/core/error.hpp"

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

#include <fmt/core.h>
#include <fmt/ranges.h>

namespace gyrator {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr double balanced = 1e-12;  // what counts as nothing left over, of the largest term

std::vector<ElementId> nonlinear_elements(const Network& network) {
  std::vector<ElementId> ids;
  for (int e = 0; e < static_cast<int>(network.elements().size()); ++e) {
    if (is_nonlinear(network.element({e}).law)) ids.push_back({e});
  }
  return ids;
}

bool has_constant_source(const Network& network) {
  return std::any_of(network.elements().begin(), network.elements().end(), [](const Element& e) {
    return std::holds_alternative<ConstantVoltageSource>(e.law) ||
           std::holds_alternative<ConstantCurrentSource>(e.law);
  });
}

// Steady state with every mechanical node at rest, as a linear function of [w; 1].
class HeldNetwork {
 public:
  explicit HeldNetwork(const NetworkEquations& equations) : equations_(equations) {
    const auto& nodes = equations.network().nodes();
    for (Index i = 0; i < equations.descriptor().size(); ++i) {
      const auto node = static_cast<std::size_t>(i) + 1;
      if (node >= nodes.size() || nodes[node].domain == Domain::electrical) kept_.push_back(i);
    }
    const Descriptor& d = equations.descriptor();
    const auto given = static_cast<Index>(equations.network().inputs().size());
    A_ = d.A(kept_, kept_);
    B_ = d.B(kept_, Eigen::all).rightCols(d.B.cols() - given);
    // Rows and columns of about one, so that rank does not depend on units.
    const auto even = [](const VectorXd& sizes) -> VectorXd {
      return (sizes.array() > 0).select(sizes.cwiseInverse(), 1.0);
    };
    if (A_.size() == 0) return;
    const VectorXd rows = even(A_.cwiseAbs().rowwise().maxCoeff());
    MatrixXd scaled = rows.asDiagonal() * A_;
    const VectorXd columns = even(scaled.cwiseAbs().colwise().maxCoeff().transpose());
    scaled = scaled * columns.asDiagonal();
    answer_ = columns.asDiagonal() *
              scaled.completeOrthogonalDecomposition().solve(-(rows.asDiagonal() * B_));
  }

  MatrixXd read(const std::vector<LinearForm>& forms) const {
    MatrixXd rows(static_cast<Index>(forms.size()), answer_.cols());
    for (Index k = 0; k < rows.rows(); ++k)
      rows.row(k) = forms[static_cast<std::size_t>(k)].x(kept_) * answer_;
    return rows;
  }

  VectorXd unknowns(const VectorXd& inputs) const {
    VectorXd x = VectorXd::Zero(equations_.descriptor().size());
    x(kept_) = answer_ * inputs;
    require_balance(x(kept_), inputs);
    return x;
  }

 private:
  void require_balance(const VectorXd& x, const VectorXd& inputs) const {
    const VectorXd left_over = A_ * x + B_ * inputs;
    const VectorXd size = A_.cwiseAbs() * x.cwiseAbs() + B_.cwiseAbs() * inputs.cwiseAbs();
    Index worst = 0;
    if (left_over.size() == 0) return;
    const double largest = left_over.cwiseAbs().maxCoeff(&worst);
    if (largest <= balanced * size.maxCoeff()) return;
    const auto row = static_cast<std::size_t>(kept_[static_cast<std::size_t>(worst)]);
    throw Error(ErrorCode::numerical,
                fmt::format("{}", fmt::join(equations_.descriptor().equation_elements[row], ", ")),
                "no steady state: a constant source drives what these elements cannot take for "
                "ever (a current into a capacitor, a voltage across an inductor)");
  }

  const NetworkEquations& equations_;
  std::vector<Index> kept_;
  MatrixXd A_, B_, answer_;
};

bool is_regular(const Network& network, const std::vector<double>& slopes) {
  try {
    (void)reduce(NetworkEquations::with_slopes(network, slopes).descriptor());
    return true;
  } catch (const Error&) {
    return false;
  }
}

LinearRange::Quantity quantity_of(const Network& network, const Element& element) {
  using enum LinearRange::Quantity;
  if (std::holds_alternative<ThermalResistor>(element.law)) return temperature_rise;
  // An amplifier's limits act on its command; an op-amp's clamp on its own voltage.
  if (element.role == Role::signal && kind_of(element.law) != LawKind::conductance) return command;
  const NodeId node = element.positive == ground ? element.negative : element.positive;
  const bool mechanical =
      network.nodes()[static_cast<std::size_t>(node.index)].domain == Domain::mechanical;
  if (kind_of(element.law) == LawKind::resistance) return mechanical ? effort : current;
  return mechanical ? velocity : voltage;
}

}  // namespace

OperatingPoint find_operating_point(const Network& network) {
  const std::vector<ElementId> ids = nonlinear_elements(network);
  const auto p = static_cast<Index>(ids.size());
  const NetworkEquations equations = NetworkEquations::with_ports(network);
  OperatingPoint point;
  point.unknowns = VectorXd::Zero(equations.descriptor().size());
  point.port_inputs = VectorXd::Zero(p);
  point.arguments.assign(ids.size(), 0);
  if (has_constant_source(network)) {
    const HeldNetwork held(equations);
    std::vector<LinearForm> arguments;
    for (const ElementId id : ids) arguments.push_back(equations.argument(id));
    const MatrixXd answer = held.read(arguments);
    PortLoop loop(equations.ports(), answer.leftCols(p));
    const int failed = p > 0 ? loop.solve(answer.col(p)) : -1;
    if (failed >= 0) {
      throw Error(ErrorCode::numerical, loop.ports()[static_cast<std::size_t>(failed)].element,
                  "no operating point found: the element and the network around it agree on none");
    }
    VectorXd inputs(p + 1);
    inputs << loop.inputs(), 1;
    point.unknowns = held.unknowns(inputs);
    point.port_inputs = loop.inputs();
    for (std::size_t k = 0; k < ids.size(); ++k)
      point.arguments[k] = loop.arguments()(static_cast<Index>(k));
  }

  point.slopes.assign(network.elements().size(), 0);
  std::vector<double> with_leaks = point.slopes;
  for (std::size_t k = 0; k < ids.size(); ++k) {
    const NonlinearPort& port = equations.ports()[k];
    const auto* warm = std::get_if<ThermalResistor>(&port.law);
    const double slope =
        evaluate_law(port.law, point.arguments[k], warm ? warm->initial_rise : 0).slope;
    const auto e = static_cast<std::size_t>(ids[k].index);
    point.slopes[e] = slope;
    with_leaks[e] = slope + port.leak;
  }
  if (!is_regular(network, point.slopes) && is_regular(network, with_leaks))
    point.slopes = with_leaks;
  return point;
}

std::vector<LinearRange> find_linear_ranges(const Network& network) {
  std::vector<LinearRange> ranges;
  if (network.is_linear()) return ranges;
  const OperatingPoint point = find_operating_point(network);
  const std::vector<ElementId> ids = nonlinear_elements(network);
  for (std::size_t k = 0; k < ids.size(); ++k) {
    const Element& element = network.element(ids[k]);
    const auto* warm = std::get_if<ThermalResistor>(&element.law);
    const double at = warm ? warm->initial_rise : point.arguments[k];
    const ArgumentRange range = find_linear_range(element.law, at);
    ranges.push_back({ids[k], quantity_of(network, element), at, range.from, range.to});
  }
  return ranges;
}

}  // namespace gyrator
