#include "gyrator/controllers/running_velocity_estimator.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace gyrator {
namespace {

// Samples of an encoder lie exactly one quantum off as a rule, give or take their rounding.
constexpr double rounding = 1e-9;

struct MakeRun {
  double period;

  using Run =
      std::variant<RunningDifference, RunningVelocityLaw, RunningAdaptiveWindow, RunningLevant>;
  Run operator()(const DifferenceEstimator& e) const { return RunningDifference(e, period); }
  Run operator()(const AdaptiveWindowEstimator& e) const {
    return RunningAdaptiveWindow(e, period);
  }
  Run operator()(const LevantEstimator& e) const { return RunningLevant(e, period); }
  template <class Linear>
  Run operator()(const Linear& e) const {
    return RunningVelocityLaw(make_velocity_law(e, period));
  }
};

MakeRun::Run make_run(const VelocityEstimator& estimator, double period) {
  check_velocity_estimator(estimator, period);
  return std::visit(MakeRun{period}, estimator);
}

}  // namespace

RunningDifference::RunningDifference(const DifferenceEstimator& estimator, double period)
    : history_(estimator.window + 1),
      window_(static_cast<std::size_t>(estimator.window)),
      per_window_(1 / (estimator.window * period)) {}

RunningAdaptiveWindow::RunningAdaptiveWindow(const AdaptiveWindowEstimator& estimator,
                                             double period)
    : history_(estimator.max_window + 1),
      noise_(estimator.noise * (1 + rounding)),
      fit_(estimator.fit),
      period_(period) {
  per_sample_.push_back(0);
  fit_scale_.push_back(0);
  for (int i = 1; i <= estimator.max_window; ++i) {
    const double n = i;
    per_sample_.push_back(1 / n);
    fit_scale_.push_back(6 / (period * n * (n + 1) * (n + 2)));
  }
}

double RunningAdaptiveWindow::step(double y) {
  history_.push(y);
  double least = -std::numeric_limits<double>::infinity();  // slopes that pass what lies between
  double most = std::numeric_limits<double>::infinity();
  // Sums over i = 0 ... n of y[k] - y[k-i], and of i times it: the terms of (est-4) in y[k] cancel.
  double sum = 0;
  double moment = 0;
  double velocity = 0;
  for (std::size_t n = 1; n < per_sample_.size(); ++n) {
    const double rise = y - history_[n];
    const double slope = rise * per_sample_[n];
    const auto i = static_cast<double>(n);
    sum += rise;
    moment += i * rise;
    if (slope >= least && slope <= most) {
      window_ = static_cast<int>(n);
      velocity = fit_ == WindowFit::end ? slope / period_ : fit_scale_[n] * (2 * moment - i * sum);
    }
    const double reach = noise_ * per_sample_[n];
    least = std::max(least, slope - reach);
    most = std::min(most, slope + reach);
    if (least > most) break;
  }
  return velocity;
}

RunningLevant::RunningLevant(const LevantEstimator& estimator, double period)
    : period_(period),
      root_gain_(estimator.root_gain * std::sqrt(estimator.acceleration_bound)),
      velocity_step_(period * estimator.sign_gain * estimator.acceleration_bound) {}

double RunningLevant::step(double y) {
  const double error = position_ - y;
  position_ +=
      period_ * (velocity_ - std::copysign(root_gain_ * std::sqrt(std::abs(error)), error));
  if (error != 0) velocity_ -= std::copysign(velocity_step_, error);
  return velocity_;
}

RunningVelocityEstimator::RunningVelocityEstimator(const VelocityEstimator& estimator,
                                                   double period)
    : run_(make_run(estimator, period)) {}

}  // namespace gyrator
