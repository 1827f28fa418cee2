#include "gyrator/controllers/velocity_estimator.hpp"

#include "gyrator/core/error.hpp"

#include <numbers>

#include <fmt/core.h>

namespace gyrator {
namespace {

DiscreteStateSpace make_difference(int window, double period) {
  if (window < 1) {
    throw Error(ErrorCode::bad_input, "velocity/window",
                fmt::format("{} samples: must be at least 1", window));
  }
  // The state is the last n samples, newest first.
  DiscreteStateSpace law;
  law.A = Eigen::MatrixXd::Zero(window, window);
  for (int i = 1; i < window; ++i) law.A(i, i - 1) = 1;
  law.B = Eigen::VectorXd::Unit(window, 0);
  law.C = Eigen::RowVectorXd::Zero(window);
  law.C(window - 1) = -1 / (window * period);
  law.D = 1 / (window * period);
  return law;
}

DiscreteStateSpace make_filtered_difference(double cutoff_hz, double period) {
  if (!(cutoff_hz > 0)) {
    throw Error(ErrorCode::bad_input, "velocity/cutoff",
                fmt::format("{:g} Hz: must be positive", cutoff_hz));
  }
  const double tau = 1 / (2 * std::numbers::pi * cutoff_hz);
  // q[k+1] = tau v[k] - y[k], so that v[k] = (q[k] + y[k]) / (tau + T).
  const double a = 1 / (tau + period);
  DiscreteStateSpace law;
  law.A = Eigen::MatrixXd::Constant(1, 1, tau * a);
  law.B = Eigen::VectorXd::Constant(1, tau * a - 1);
  law.C = Eigen::RowVectorXd::Constant(1, a);
  law.D = a;
  return law;
}

}  // namespace

DiscreteStateSpace make_velocity_law(const VelocityEstimator& estimator, double period) {
  if (const auto* difference = std::get_if<DifferenceEstimator>(&estimator)) {
    return make_difference(difference->window, period);
  }
  return make_filtered_difference(std::get<FilteredDifferenceEstimator>(estimator).cutoff_hz,
                                  period);
}

}  // namespace gyrator
