#pragma once

#include "gyrator/controllers/discrete_state_space.hpp"

#include <optional>
#include <string_view>
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

/// Backward difference behind a Butterworth low-pass of order N, mapped by the trapezoidal rule so
/// that its gain is 1/sqrt(2) at the cut-off f_c itself:                         [8.24]
///   V(z) = (1 - z^-1)/T H(z),   |H|^2 = 1/(1 + (tan(w T/2)/tan(pi f_c T))^(2 N))      (est-3)
/// Order 1 to 8, cut-off below the Nyquist frequency 1/(2 T).
struct ButterworthEstimator {
  int order = 2;
  double cutoff_hz = 0;
};

/// What line is laid through the window of an adaptive estimator.
enum class WindowFit {
  end,  ///< through its two ends
  best  ///< of least squares through all its samples
};

/// First-order adaptive window: the longest n <= max_window for which the line through y[k] and
/// y[k-n] passes within the noise d of every sample between, then the slope of that line (end) or
/// of the line of least squares (best):                                         [8.25-8.28]
///   end   v[k] = (y[k] - y[k-n]) / (n T)
///   best  v[k] = 6 sum (n - 2 i) y[k-i] / (T n (n+1)(n+2)),  i = 0 ... n               (est-4)
/// d [m, rad] is one quantum for an encoder: then a constant velocity always has the whole window.
/// Samples exactly d off count as within (1e-9 of d is left to rounding). The published procedure
/// ends at the first window that fails; here a longer one that passes is taken.
/// Source: Janabi-Sharifi, Hayward and Chen 2000.
struct AdaptiveWindowEstimator {
  double noise = 0;
  int max_window = 16;
  WindowFit fit = WindowFit::best;
};

/// Levant's robust exact differentiator of first order, for positions with |y''| <= L:
///   e = z0[k] - y[k],   v[k] = z1[k+1] = z1[k] - T g1 L sgn e
///   z0[k+1] = z0[k] + T (z1[k] - g0 sqrt(L |e|) sgn e)                                 (est-5)
/// L [m/s^2, rad/s^2]; g0 = 1.5 and g1 = 1.1 unless given, g1 above 1. Explicit steps; at this
/// order the homogeneous discretization has no further terms. With the default gains, without
/// noise and once it has converged, |v - y'| <= 4 L T; a start |v - y'| away takes about as
/// many seconds as that is times 1/(1.1 L). Noise d adds an error of order sqrt(L d).
/// Source: Levant 1998, 2003; the bound by exhausting the reachable errors, in levant_test.
struct LevantEstimator {
  double acceleration_bound = 0;
  double root_gain = 1.5;
  double sign_gain = 1.1;
};

/// The closed list of estimators, as configuration.
using VelocityEstimator =
    std::variant<DifferenceEstimator, FilteredDifferenceEstimator, ButterworthEstimator,
                 AdaptiveWindowEstimator, LevantEstimator>;

/// The name in model files: "difference", "foaw".
std::string_view name_of(const VelocityEstimator& estimator);

/// Whether it has a V(z): all but foaw and levant.
bool is_linear(const VelocityEstimator& estimator);

/// Throws bad_input at "controller/velocity/KEY" for what no estimator can be at this period [s]: a
/// window below one sample, an order outside 1 to 8, a cut-off, noise, bound or gain that is not
/// positive, a Butterworth cut-off that is not below the Nyquist frequency.
void check_velocity_estimator(const VelocityEstimator& estimator, double period);

/// The estimator as a discrete law from sampled position [m, rad] to velocity [m/s, rad/s]; none
/// for the two that are not linear (foaw, levant): they have no V(z). `period` in s. Checks it.
std::optional<DiscreteStateSpace> find_velocity_law(const VelocityEstimator& estimator,
                                                    double period);

/// The same for who cannot do without: throws bad_input at "controller/velocity/kind" for an
/// estimator that is not linear, naming it and those to use instead.
DiscreteStateSpace make_velocity_law(const VelocityEstimator& estimator, double period);

}  // namespace gyrator
