#include "gyrator/circuits/port_loop.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace gyrator {
namespace {

constexpr int most_steps = 50;
constexpr double converged = 1e-13;     // of an argument, or of the size at which its law bends
constexpr double shortest_part = 1e-6;  // of the way from the last solution to the next

}  // namespace

PortLoop::PortLoop(std::vector<NonlinearPort> ports, Eigen::MatrixXd F)
    : ports_(std::move(ports)), F_(std::move(F)) {
  const Eigen::Index p = F_.rows();
  for (auto* v : {&y_, &w_, &slope_, &rises_, &residual_, &step_, &start_})
    *v = Eigen::VectorXd::Zero(p);
  for (Eigen::Index k = 0; k < p; ++k) {
    if (const auto* t = std::get_if<ThermalResistor>(&ports_[static_cast<std::size_t>(k)].law))
      rises_(k) = t->initial_rise;
  }
  jacobian_ = Eigen::MatrixXd::Identity(p, p);
  lu_ = Eigen::PartialPivLU<Eigen::MatrixXd>(p);
}

void PortLoop::evaluate(const Eigen::VectorXd& y) {
  for (Eigen::Index k = 0; k < y.size(); ++k) {
    const NonlinearPort& port = ports_[static_cast<std::size_t>(k)];
    const LawPoint at = evaluate_law(port.law, y(k), rises_(k));
    w_(k) = at.value + (port.leak - port.companion) * y(k);
    slope_(k) = at.slope + port.leak - port.companion;
  }
}

double PortLoop::measure(const Eigen::VectorXd& step, const Eigen::VectorXd& y) const {
  double largest = 0;
  for (Eigen::Index k = 0; k < y.size(); ++k) {
    const double size = std::max(std::abs(y(k)), ports_[static_cast<std::size_t>(k)].size);
    largest = std::max(largest, std::abs(step(k)) / size);
  }
  return largest;
}

// Whether the residual is no more than the rounding of its terms.
bool PortLoop::is_rounding(const Eigen::VectorXd& q) const {
  constexpr double eps = 4 * std::numeric_limits<double>::epsilon();
  for (Eigen::Index k = 0; k < q.size(); ++k) {
    double terms = std::abs(y_(k)) + std::abs(q(k));
    for (Eigen::Index j = 0; j < q.size(); ++j) terms += std::abs(F_(k, j) * w_(j));
    if (!(std::abs(residual_(k)) <= eps * terms)) return false;
  }
  return true;
}

// Newton from the present y, shortened only where a law grows exponentially.
bool PortLoop::step_to(const Eigen::VectorXd& q) {
  const Eigen::Index p = size();
  for (int steps = 0; steps < most_steps; ++steps) {
    evaluate(y_);
    residual_ = y_ - q;
    residual_.noalias() -= F_ * w_;
    if (is_rounding(q)) return true;
    jacobian_.noalias() = -(F_ * slope_.asDiagonal());
    jacobian_.diagonal().array() += 1;
    lu_.compute(jacobian_);
    step_ = lu_.solve(-residual_);
    if (!step_.allFinite()) return false;
    const bool last = measure(step_, y_) <= converged;
    for (Eigen::Index k = 0; k < p; ++k) {
      y_(k) = limit_step(ports_[static_cast<std::size_t>(k)].law, y_(k), y_(k) + step_(k));
    }
    if (last) {  // a further step would be below rounding
      evaluate(y_);
      return true;
    }
  }
  return false;
}

int PortLoop::solve(const Eigen::VectorXd& q) {
  start_ = y_;
  if (step_to(q)) return -1;

  // What the start solves is known: from there to q in parts, each short enough for Newton.
  evaluate(start_);
  const Eigen::VectorXd solved = start_ - F_ * w_;
  double done = 0;
  for (double part = 0.5; done < 1;) {
    const double next = std::min(1.0, done + part);
    y_ = start_;
    if (step_to((1 - next) * solved + next * q)) {
      start_ = y_;
      done = next;
      part *= 2;
      continue;
    }
    part /= 2;
    if (part < shortest_part) break;
  }
  if (done == 1) return -1;
  Eigen::Index worst = 0;
  if (residual_.allFinite()) {
    residual_.cwiseAbs().maxCoeff(&worst);
  } else {
    while (std::isfinite(residual_(worst))) ++worst;
  }
  y_ = start_;
  return static_cast<int>(worst);
}

}  // namespace gyrator
