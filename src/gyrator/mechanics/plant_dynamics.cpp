#include "gyrator/mechanics/plant_dynamics.hpp"

#include "gyrator/circuits/state_space.hpp"
#include "gyrator/core/error.hpp"

#include <algorithm>
#include <limits>

#include <fmt/core.h>

namespace gyrator {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

PlantDynamics::PlantDynamics(const Plant& plant)
    : plant_(plant),
      nl_(*plant.nonlinear),
      loop_(nl_.ports, nl_.port_columns(nl_.D)),
      q_(loop_.size()),
      inputs_(VectorXd::Zero(plant.inputs())),
      rises_(VectorXd::Zero(loop_.size())) {
  inputs_.tail(1)(0) = 1;
  loop_.start_from(nl_.at_rest);
}

const VectorXd& PlantDynamics::solve(const VectorXd& xi, const Eigen::Vector2d& u) {
  const Index p = loop_.size();
  inputs_.head(2) = u;
  if (p == 0) return inputs_;
  for (const auto& t : nl_.thermal) rises_(t.port) = xi(t.state);
  loop_.set_rises(rises_);
  q_.noalias() = nl_.C * xi;
  q_.noalias() += nl_.D.leftCols(2) * u;
  q_ += nl_.D.rightCols(1);
  const int failed = loop_.solve(q_);
  if (failed >= 0) {
    const double argument = loop_.arguments()(failed);
    loop_.start_from(nl_.at_rest);
    throw Error(ErrorCode::numerical, nl_.ports[static_cast<std::size_t>(failed)].element,
                fmt::format("its law and the circuit around it agree on no point (argument {:g})",
                            argument));
  }
  inputs_.segment(nl_.first_port(), p) = loop_.inputs();
  return inputs_;
}

const VectorXd& PlantDynamics::rate(const VectorXd& xi) {
  rate_.noalias() = nl_.A * xi;
  rate_.noalias() += nl_.B * inputs_;
  for (const auto& t : nl_.thermal) {
    const double current = loop_.arguments()(t.port);
    const double rise = xi(t.state);
    const double heat = evaluate_law(t.law, current, rise).value * current;
    rate_(t.state) = (heat - rise / t.law.thermal_resistance) / t.law.thermal_capacity;
  }
  return rate_;
}

// (I - F s) dy = C dξ + F dw/dh dh,  dw = s dy + dw/dh dh,  s = dw/dy of each port.
const MatrixXd& PlantDynamics::jacobian(const VectorXd& xi) {
  const Index p = loop_.size();
  jacobian_ = nl_.A;
  if (p == 0) {
    dw_.resize(0, xi.size());
    return jacobian_;
  }
  const auto F = nl_.port_columns(nl_.D);
  MatrixXd direct = MatrixXd::Zero(p, xi.size());  // dw/dξ at constant y
  for (const auto& t : nl_.thermal) {
    direct(t.port, t.state) =
        t.law.resistance * t.law.temperature_coefficient * loop_.arguments()(t.port);
  }
  const MatrixXd matrix = MatrixXd::Identity(p, p) - F * loop_.slopes().asDiagonal();
  const MatrixXd dy = matrix.partialPivLu().solve(nl_.C + F * direct);
  dw_ = loop_.slopes().asDiagonal() * dy + direct;
  jacobian_.noalias() += nl_.port_columns(nl_.B) * dw_;
  for (const auto& t : nl_.thermal) {
    const double current = loop_.arguments()(t.port);
    const LawPoint law = evaluate_law(t.law, current, xi(t.state));
    jacobian_.row(t.state) += 2 * law.slope * current / t.law.thermal_capacity * dy.row(t.port);
    jacobian_(t.state, t.state) +=
        (t.law.resistance * t.law.temperature_coefficient * current * current -
         1 / t.law.thermal_resistance) /
        t.law.thermal_capacity;
  }
  return jacobian_;
}

MatrixXd PlantDynamics::tangent(const VectorXd& slopes) const {
  const Index p = slopes.size();
  const MatrixXd matrix = MatrixXd::Identity(p, p) - nl_.port_columns(nl_.D) * slopes.asDiagonal();
  return nl_.A + nl_.port_columns(nl_.B) * slopes.asDiagonal() * matrix.partialPivLu().solve(nl_.C);
}

VectorXd PlantDynamics::slopes_at_rest() const {
  VectorXd slopes(loop_.size());
  for (Index k = 0; k < slopes.size(); ++k) {
    const NonlinearPort& port = nl_.ports[static_cast<std::size_t>(k)];
    const auto* warm = std::get_if<ThermalResistor>(&port.law);
    const LawPoint at = evaluate_law(port.law, nl_.at_rest(k), warm ? warm->initial_rise : 0);
    slopes(k) = at.slope + port.leak - port.companion;
  }
  return slopes;
}

VectorXd PlantDynamics::find_state_sizes() const {
  VectorXd sizes = VectorXd::Constant(nl_.C.cols(), std::numeric_limits<double>::infinity());
  const Index p = loop_.size();
  if (p == 0) return sizes;
  const MatrixXd matrix =
      MatrixXd::Identity(p, p) - nl_.port_columns(nl_.D) * slopes_at_rest().asDiagonal();
  const MatrixXd moved = matrix.partialPivLu().solve(nl_.C).cwiseAbs();
  for (Index k = 0; k < p; ++k) {
    const double size = nl_.ports[static_cast<std::size_t>(k)].size;
    for (Index i = 0; i < sizes.size(); ++i) {
      if (moved(k, i) > 0) sizes(i) = std::min(sizes(i), size / moved(k, i));
    }
  }
  return sizes;
}

double PlantDynamics::find_fastest_rate() const {
  const auto rate_of = [](const MatrixXd& A) {
    if (A.rows() == 0 || !A.allFinite()) return 0.0;
    return compute_poles(A).cwiseAbs().maxCoeff();
  };
  double fastest = rate_of(plant_.A);
  const Index p = loop_.size();
  const VectorXd rest = slopes_at_rest();
  VectorXd steepest(p);
  for (Index k = 0; k < p; ++k) {
    const NonlinearPort& port = nl_.ports[static_cast<std::size_t>(k)];
    steepest(k) = port.steepest_slope + port.leak - port.companion;
  }
  for (Index k = 0; k < p; ++k) {
    VectorXd one = rest;
    one(k) = steepest(k);
    fastest = std::max(fastest, rate_of(tangent(one)));
  }
  return p > 0 ? std::max(fastest, rate_of(tangent(steepest))) : fastest;
}

}  // namespace gyrator
