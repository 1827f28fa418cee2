#pragma once

#include "gyrator/controllers/velocity_estimator.hpp"

#include <complex>
#include <vector>

namespace gyrator {

/// A linear estimator at one frequency, against the derivative j w that it stands for.
struct VelocityResponse {
  double frequency_hz = 0;
  std::complex<double> value;  ///< V(e^(j w T)) [1/s]
  std::complex<double> ratio;  ///< V/(j w): 1 for a perfect differentiator
  double delay_s = 0;          ///< phase delay, -arg(V/(j w))/w; below a turn of phase
};

/// V(z) of the estimator at each frequency [Hz], above zero and at most the Nyquist frequency.
/// Throws bad_input for an estimator that is not linear (make_velocity_law).
std::vector<VelocityResponse> compute_velocity_response(const VelocityEstimator& estimator,
                                                        double period,
                                                        const std::vector<double>& frequency_hz);

/// How late the estimate is at low frequency [s], the limit of delay_s at zero:
///   difference           n T/2
///   filtered_difference  T/2 + tau
///   butterworth          T/2 + T/(2 tan(pi f_c T) sin(pi/(2 N)))                       (est-7)
/// Throws bad_input for an estimator that is not linear.
double compute_velocity_delay(const VelocityEstimator& estimator, double period);

/// Standard deviation of the estimate per standard deviation of white noise in the position [1/s],
///   sqrt(sum h[k]^2), h the impulse response; sqrt(2)/(n T) for the difference         (est-8)
/// Throws bad_input for an estimator that is not linear.
double compute_velocity_noise_gain(const VelocityEstimator& estimator, double period);

}  // namespace gyrator
