#include "gyrator/controllers/velocity_estimator.hpp"

#include "gyrator/core/error.hpp"

#include <cmath>
#include <complex>
#include <numbers>
#include <string>
#include <vector>

#include <gtest/gtest.h>

namespace gyrator {
namespace {

using Complex = std::complex<double>;

constexpr double T = 1e-3;
constexpr double pi = std::numbers::pi;
// Differences of positions of about one over T: rounding of one over 1 ms, some times.
constexpr double rounding = 1e-12;

// Response of the running law to z^k, after `settling` samples.
Complex measure_gain(const DiscreteStateSpace& law, double angle, int settling) {
  DiscreteLawState real(law), imaginary(law);
  Complex gain = 0;
  for (int k = 0; k <= settling; ++k) {
    const Complex input = std::polar(1.0, angle * k);
    const Complex output(real.step(law, input.real()), imaginary.step(law, input.imag()));
    gain = output / input;
  }
  return gain;
}

std::vector<double> impulse_response(const DiscreteStateSpace& law, int count) {
  DiscreteLawState state(law);
  std::vector<double> response;
  for (int k = 0; k < count; ++k) response.push_back(state.step(law, k == 0 ? 1 : 0));
  return response;
}

TEST(Difference, has_the_two_coefficients_of_its_window) {
  // v[k] = (y[k] - y[k-n])/(n T)                                                     [8.23]
  for (const int n : {1, 2, 5}) {
    const auto h = impulse_response(make_velocity_law(DifferenceEstimator{n}, T), 12);
    for (int k = 0; k < 12; ++k) {
      const double expected = k == 0 ? 1 / (n * T) : k == n ? -1 / (n * T) : 0;
      EXPECT_DOUBLE_EQ(h[static_cast<std::size_t>(k)], expected) << "n = " << n << ", k = " << k;
    }
  }
}

TEST(Difference, responds_as_one_minus_z_to_the_minus_n) {
  for (const int n : {1, 3}) {
    const DiscreteStateSpace law = make_velocity_law(DifferenceEstimator{n}, T);
    for (const double angle : {0.01, 0.5, 2.0, pi}) {
      const Complex z = std::polar(1.0, angle);
      const Complex expected = (1.0 - std::pow(z, -n)) / (n * T);
      EXPECT_LE(std::abs(law.response(z) - expected), rounding / T) << n << " at " << angle;
      EXPECT_LE(std::abs(measure_gain(law, angle, 10) - expected), rounding / T) << n;
    }
  }
}

TEST(FilteredDifference, has_the_coefficients_of_both_parts_mapped_backward) {
  // v[k] = (tau v[k-1] + y[k] - y[k-1])/(tau + T)                                    (est-2)
  const double tau = 1 / (2 * pi * 50);
  const auto h = impulse_response(make_velocity_law(FilteredDifferenceEstimator{50}, T), 30);
  double v = 0;
  for (int k = 0; k < 30; ++k) {
    v = (tau * v + (k == 0 ? 1.0 : k == 1 ? -1.0 : 0.0)) / (tau + T);
    EXPECT_NEAR(h[static_cast<std::size_t>(k)], v, rounding / T) << k;
  }
}

TEST(FilteredDifference, responds_as_a_filtered_backward_difference) {
  const double tau = 1 / (2 * pi * 50);
  const DiscreteStateSpace law = make_velocity_law(FilteredDifferenceEstimator{50}, T);
  for (const double angle : {0.0, 0.01, 0.5, 2.0, pi}) {
    const Complex z = std::polar(1.0, angle);
    const Complex s = (z - 1.0) / (T * z);
    const Complex expected = s / (tau * s + 1.0);
    EXPECT_LE(std::abs(law.response(z) - expected), rounding / T) << angle;
    // The filter's memory is gone after 300 samples: 0.76^300.
    EXPECT_LE(std::abs(measure_gain(law, angle, 300) - expected), 10 * rounding / T) << angle;
  }
}

TEST(FilteredDifference, far_above_the_sampling_rate_is_the_plain_difference) {
  const DiscreteStateSpace fast = make_velocity_law(FilteredDifferenceEstimator{1e9}, T);
  const DiscreteStateSpace plain = make_velocity_law(DifferenceEstimator{1}, T);
  for (const double angle : {0.1, 1.0, pi}) {
    const Complex z = std::polar(1.0, angle);
    const double tau_over_T = 1 / (2 * pi * 1e9 * T);  // 1.6e-7, the relative difference
    EXPECT_LE(std::abs(fast.response(z) / plain.response(z) - 1.0), 2 * tau_over_T) << angle;
  }
}

TEST(VelocityEstimator, of_a_ramp_is_its_slope_and_of_a_rest_is_zero) {
  for (const VelocityEstimator& estimator :
       {VelocityEstimator{DifferenceEstimator{1}}, VelocityEstimator{DifferenceEstimator{4}},
        VelocityEstimator{FilteredDifferenceEstimator{80}}}) {
    const DiscreteStateSpace law = make_velocity_law(estimator, T);
    DiscreteLawState state(law);
    double v = 0;
    for (int k = 0; k < 200; ++k) v = state.step(law, 0.25 * k * T);
    EXPECT_NEAR(v, 0.25, rounding);
    state.settle(law, 3.5);  // as if it had been there for ever
    EXPECT_NEAR(state.step(law, 3.5), 0, rounding / T);
  }
}

TEST(VelocityEstimator, refuses_a_window_or_a_cutoff_that_is_not_positive) {
  const auto refusal = [](const VelocityEstimator& estimator) {
    try {
      make_velocity_law(estimator, T);
    } catch (const Error& error) {
      EXPECT_EQ(error.code(), ErrorCode::bad_input);
      return error.place();
    }
    return std::string("accepted");
  };
  EXPECT_EQ(refusal(DifferenceEstimator{0}), "controller/velocity/window");
  EXPECT_EQ(refusal(DifferenceEstimator{-3}), "controller/velocity/window");
  EXPECT_EQ(refusal(DifferenceEstimator{1}), "accepted");
  EXPECT_EQ(refusal(FilteredDifferenceEstimator{0}), "controller/velocity/cutoff");
  EXPECT_EQ(refusal(FilteredDifferenceEstimator{-10}), "controller/velocity/cutoff");
  EXPECT_EQ(refusal(FilteredDifferenceEstimator{std::nan("")}), "controller/velocity/cutoff");
  EXPECT_EQ(refusal(FilteredDifferenceEstimator{1e-3}), "accepted");
}

}  // namespace
}  // namespace gyrator
