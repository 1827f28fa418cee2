#pragma once

#include "gyrator/controllers/running_velocity_estimator.hpp"

#include <cmath>
#include <functional>
#include <numbers>
#include <string>
#include <vector>

// How far velocity estimates are off on an encoder of 8192 counts per revolution at 1 kHz: the
// table of docs/velocity-estimators.md, printed by bench/estimator_study and tested.

namespace gyrator::estimator_errors {

inline constexpr double period = 1e-3;
inline constexpr double quantum = 2 * std::numbers::pi / 8192;

struct NamedEstimator {
  std::string name;
  VelocityEstimator estimator;
};

inline std::vector<NamedEstimator> make_estimators() {
  return {{"difference", DifferenceEstimator{1}},
          {"difference, 10 samples", DifferenceEstimator{10}},
          {"filtered difference, 50 Hz", FilteredDifferenceEstimator{50}},
          {"Butterworth 2, 50 Hz", ButterworthEstimator{2, 50}},
          {"Butterworth 4, 50 Hz", ButterworthEstimator{4, 50}},
          {"FOAW to 32, end fit", AdaptiveWindowEstimator{quantum, 32, WindowFit::end}},
          {"FOAW to 32, best fit", AdaptiveWindowEstimator{quantum, 32, WindowFit::best}},
          {"Levant, 40 rad/s²", LevantEstimator{40}}};
}

struct Motion {
  std::string name;
  std::function<double(double)> position, velocity;  // of time [s], in rad and rad/s
};

/// A slow ramp, 1/15 of a count per sample; a fast one, 6.5 counts; a hand's swing of 2 Hz that
/// reaches 2.5 rad/s and 32 rad/s².
inline std::vector<Motion> make_motions() {
  const double amplitude = 0.2, omega = 4 * std::numbers::pi;
  return {{"0.05 rad/s", [](double t) { return 0.05 * t; }, [](double) { return 0.05; }},
          {"5 rad/s", [](double t) { return 5 * t; }, [](double) { return 5.0; }},
          {"0.2 rad at 2 Hz", [=](double t) { return amplitude * std::sin(omega * t); },
           [=](double t) { return amplitude * omega * std::cos(omega * t); }}};
}

inline double sense(double position) {
  return quantum * std::floor(position / quantum + 0.5);
}

/// Root mean square of estimate minus velocity over one second, after one second to settle [rad/s].
inline double measure_error(const VelocityEstimator& estimator, const Motion& motion) {
  RunningVelocityEstimator run(estimator, period);
  double sum = 0;
  for (int k = 0; k < 2000; ++k) {
    const double t = k * period;
    const double error = run.step(sense(motion.position(t))) - motion.velocity(t);
    if (k >= 1000) sum += error * error;
  }
  return std::sqrt(sum / 1000);
}

}  // namespace gyrator::estimator_errors
