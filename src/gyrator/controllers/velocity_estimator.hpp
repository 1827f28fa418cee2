#pragma once

#include "gyrator/controllers/discrete_state_space.hpp"

#include <variant>

namespace gyrator {

/// Difference over `window` samples, v[k] = (y[k] - y[k-n]) / (n T)             [8.23]
struct DifferenceEstimator {
  int window = 1;
};

/// Backward difference behind a first-order low-pass, both mapped backward, s -> (z - 1)/(T z):
///   v[k] = (tau v[k-1] + y[k] - y[k-1]) / (tau + T),  tau = 1/(2 pi cutoff)      (est-2)
struct FilteredDifferenceEstimator {
  double cutoff_hz = 0;
};

using VelocityEstimator = std::variant<DifferenceEstimator, FilteredDifferenceEstimator>;

/// The estimator as a discrete law from sampled position [m, rad] to velocity [m/s, rad/s];
/// `period` in s. Throws bad_input for a window below one sample or a cut-off that is not positive.
DiscreteStateSpace make_velocity_law(const VelocityEstimator& estimator, double period);

}  // namespace gyrator
