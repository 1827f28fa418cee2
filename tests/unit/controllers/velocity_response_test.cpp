#include "gyrator/controllers/velocity_response.hpp"

#include "gyrator/core/error.hpp"

#include <cmath>
#include <numbers>
#include <vector>

#include <gtest/gtest.h>

namespace gyrator {
namespace {

constexpr double T = 1e-3;
constexpr double pi = std::numbers::pi;
constexpr double rounding = 1e-10;  // relative, of sums over the law's memory

TEST(VelocityResponse, of_a_difference_is_a_sinc_half_a_window_late) {
  // V/(j w) = sin(n w T/2)/(n w T/2) e^(-j w n T/2)
  for (const int n : {1, 4}) {
    const auto responses = compute_velocity_response(DifferenceEstimator{n}, T, {0.1, 20, 70});
    ASSERT_EQ(responses.size(), 3U);
    for (const VelocityResponse& r : responses) {
      const double half = pi * r.frequency_hz * n * T;
      EXPECT_NEAR(std::abs(r.ratio), std::sin(half) / half, rounding);
      EXPECT_NEAR(r.delay_s, n * T / 2, rounding);
      EXPECT_NEAR(std::abs(r.value), 2 * pi * r.frequency_hz * std::abs(r.ratio), rounding);
    }
  }
}

TEST(VelocityDelay, is_that_of_the_closed_forms) {
  for (const int n : {1, 3, 20})
    EXPECT_NEAR(compute_velocity_delay(DifferenceEstimator{n}, T), n * T / 2, rounding * T);
  for (const double cutoff : {1.0, 50.0, 1000.0}) {
    EXPECT_NEAR(compute_velocity_delay(FilteredDifferenceEstimator{cutoff}, T),
                T / 2 + 1 / (2 * pi * cutoff), rounding);
  }
  for (int order = 1; order <= 8; ++order) {
    for (const double cutoff : {10.0, 200.0, 490.0}) {
      // The analog filter's delay is 1/(w sin(pi/(2 N))); the trapezoidal rule adds none at zero.
      EXPECT_NEAR(compute_velocity_delay(ButterworthEstimator{order, cutoff}, T),
                  T / 2 + T / (2 * std::tan(pi * cutoff * T) * std::sin(pi / (2 * order))),
                  rounding)
          << order << " at " << cutoff;
    }
  }
}

TEST(VelocityDelay, is_the_phase_delay_at_low_frequency) {
  for (const VelocityEstimator& estimator : {VelocityEstimator{DifferenceEstimator{7}},
                                             VelocityEstimator{FilteredDifferenceEstimator{40}},
                                             VelocityEstimator{ButterworthEstimator{3, 40}}}) {
    const double slow = compute_velocity_response(estimator, T, {0.01}).front().delay_s;
    // The phase is odd in frequency: what is left is of second order, (0.01/40)^2.
    EXPECT_NEAR(slow / compute_velocity_delay(estimator, T), 1, 1e-6) << name_of(estimator);
  }
}

TEST(VelocityNoiseGain, is_the_root_of_the_impulse_responses_energy) {
  for (const int n : {1, 6})
    EXPECT_NEAR(compute_velocity_noise_gain(DifferenceEstimator{n}, T), std::sqrt(2) / (n * T),
                rounding / T);
  const double tau = 1 / (2 * pi * 30), p = tau / (tau + T);
  EXPECT_NEAR(compute_velocity_noise_gain(FilteredDifferenceEstimator{30}, T),
              std::sqrt(2 / (1 + p)) / (tau + T), rounding / T);
  const VelocityEstimator butterworth = ButterworthEstimator{4, 60};
  const DiscreteStateSpace law = make_velocity_law(butterworth, T);
  DiscreteLawState state(law);
  double energy = 0;
  for (int k = 0; k < 2000; ++k) energy += std::pow(state.step(law, k == 0 ? 1 : 0), 2);
  EXPECT_NEAR(compute_velocity_noise_gain(butterworth, T), std::sqrt(energy), rounding / T);
}

TEST(VelocityResponse, is_refused_of_an_estimator_that_is_not_linear) {
  const VelocityEstimator levant = LevantEstimator{10};
  EXPECT_THROW(compute_velocity_response(levant, T, {1}), Error);
  EXPECT_THROW(compute_velocity_delay(levant, T), Error);
  EXPECT_THROW(compute_velocity_noise_gain(levant, T), Error);
}

}  // namespace
}  // namespace gyrator
