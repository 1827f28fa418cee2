#pragma once

#include "gyrator/controllers/discrete_state_space.hpp"
#include "gyrator/controllers/velocity_estimator.hpp"

#include <cstddef>
#include <variant>
#include <vector>

namespace gyrator {

/// The last samples, newest first, in one piece of memory.
class SampleHistory {
 public:
  explicit SampleHistory(int length)
      : length_(static_cast<std::size_t>(length)), samples_(2 * length_) {}

  void fill(double y) { samples_.assign(samples_.size(), y); }

  // Every sample is kept twice, one length apart, so that the last ones never wrap around.
  void push(double y) {
    newest_ = (newest_ == 0 ? length_ : newest_) - 1;
    samples_[newest_] = samples_[newest_ + length_] = y;
  }

  /// y[k-i], i below the length.
  double operator[](std::size_t i) const { return samples_[newest_ + i]; }

 private:
  std::size_t length_;
  std::size_t newest_ = 0;
  std::vector<double> samples_;
};

/// (y[k] - y[k-n])/(n T), whatever n at the same cost.
class RunningDifference {
 public:
  RunningDifference(const DifferenceEstimator& estimator, double period);
  void settle(double y) { history_.fill(y); }
  double step(double y) {
    history_.push(y);
    return (y - history_[window_]) * per_window_;
  }

 private:
  SampleHistory history_;
  std::size_t window_;
  double per_window_;  // 1/(n T)
};

/// Any linear estimator, by its law.
class RunningVelocityLaw {
 public:
  explicit RunningVelocityLaw(DiscreteStateSpace law)
      : law_(std::move(law)), state_(law_), settled_at_one_(law_.settled_state(1)) {}
  void settle(double y) { state_.settle(settled_at_one_, y); }
  double step(double y) { return state_.step(law_, y); }

 private:
  DiscreteStateSpace law_;
  DiscreteLawState state_;
  Eigen::VectorXd settled_at_one_;
};

/// (est-4), in one pass over the window: a line from y[k] with slope s passes within d of y[k-i] if
///   (y[k] - y[k-i] - d)/i <= s <= (y[k] - y[k-i] + d)/i                                (est-6)
/// so that the slopes that pass all samples up to i are an interval that only shrinks. Where it is
/// empty no longer window can pass.
class RunningAdaptiveWindow {
 public:
  RunningAdaptiveWindow(const AdaptiveWindowEstimator& estimator, double period);
  void settle(double y) { history_.fill(y); }
  double step(double y);

  int window() const { return window_; }  ///< that the last estimate used [samples]

 private:
  SampleHistory history_;
  double noise_;
  WindowFit fit_;
  std::vector<double> per_sample_;  // 1/i
  std::vector<double> fit_scale_;   // 6/(T n (n+1)(n+2))
  double period_;
  int window_ = 1;
};

/// (est-5)
class RunningLevant {
 public:
  RunningLevant(const LevantEstimator& estimator, double period);
  void settle(double y) {
    position_ = y;
    velocity_ = 0;
  }
  double step(double y);

 private:
  double period_, root_gain_, velocity_step_;  // g0 sqrt(L), T g1 L
  double position_ = 0, velocity_ = 0;         // z0, z1
};

/// An estimator while it runs: sampled position in [m, rad], velocity out [m/s, rad/s]. It starts
/// as if the first position had been there for ever, with velocity zero. Allocates only when
/// constructed. `period` in s; throws as check_velocity_estimator.
class RunningVelocityEstimator {
 public:
  RunningVelocityEstimator(const VelocityEstimator& estimator, double period);

  double step(double y) {
    return std::visit(
        [&](auto& run) {
          if (!started_) run.settle(y);
          started_ = true;
          return run.step(y);
        },
        run_);
  }

 private:
  std::variant<RunningDifference, RunningVelocityLaw, RunningAdaptiveWindow, RunningLevant> run_;
  bool started_ = false;
};

}  // namespace gyrator
