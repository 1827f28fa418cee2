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

TEST(Butterworth, has_the_gain_of_its_order_and_cutoff_at_every_frequency) {
  // |H|^2 = 1/(1 + (tan(w T/2)/tan(pi f_c T))^(2 N)), of a bilinear map with a warped cut-off
  for (int order = 1; order <= 8; ++order) {
    for (const double cutoff : {5.0, 50.0, 250.0, 499.0}) {
      const DiscreteStateSpace law = make_velocity_law(ButterworthEstimator{order, cutoff}, T);
      for (const double f : {0.5, 5.0, 30.0, 50.0, 120.0, 250.0, 400.0, 499.9}) {
        const Complex z = std::polar(1.0, 2 * pi * f * T);
        const double filter = std::abs(law.response(z) * T / (1.0 - 1.0 / z));
        const double warped = std::tan(pi * f * T) / std::tan(pi * cutoff * T);
        EXPECT_NEAR(filter, 1 / std::sqrt(1 + std::pow(warped, 2 * order)), 1e-12)
            << "order " << order << ", cut-off " << cutoff << " Hz, at " << f << " Hz";
      }
    }
  }
}

TEST(Butterworth, has_its_poles_on_the_butterworth_circle) {
  // The gain alone would not tell a stable filter from its mirror image. By s = (z-1)/(z+1)/w the
  // poles lie on the left half of the unit circle, and one at z = 0 is the difference's.
  for (int order = 1; order <= 8; ++order) {
    const DiscreteStateSpace law = make_velocity_law(ButterworthEstimator{order, 60}, T);
    const Eigen::VectorXcd poles = law.A.eigenvalues();
    ASSERT_EQ(poles.size(), order + 1);
    int filter_poles = 0;
    for (const Complex& z : poles) {
      if (std::abs(z) < 1e-9) continue;
      ++filter_poles;
      const Complex s = (z - 1.0) / (z + 1.0) / std::tan(pi * 60 * T);
      EXPECT_NEAR(std::abs(s), 1, 1e-9) << order;
      EXPECT_LT(s.real(), 0) << order;
    }
    EXPECT_EQ(filter_poles, order);
  }
}

std::vector<VelocityEstimator> make_linear_estimators() {
  return {DifferenceEstimator{1},      DifferenceEstimator{4},      FilteredDifferenceEstimator{80},
          ButterworthEstimator{1, 80}, ButterworthEstimator{2, 80}, ButterworthEstimator{5, 120},
          ButterworthEstimator{8, 400}};
}

TEST(VelocityEstimator, of_a_ramp_is_its_slope_and_of_a_rest_is_zero) {
  for (const VelocityEstimator& estimator : make_linear_estimators()) {
    const DiscreteStateSpace law = make_velocity_law(estimator, T);
    DiscreteLawState state(law);
    double v = 0;
    for (int k = 0; k < 500; ++k) v = state.step(law, 0.25 * k * T);
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

std::string find_refusal(const VelocityEstimator& estimator) {
  try {
    check_velocity_estimator(estimator, T);
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::bad_input);
    return error.place() + ": " + error.message();
  }
  return "accepted";
}

void expect_refused(const VelocityEstimator& estimator, const std::string& key,
                    const std::string& rule) {
  const std::string refusal = find_refusal(estimator);
  EXPECT_EQ(refusal.find("controller/velocity/" + key + ": "), 0U) << refusal;
  EXPECT_NE(refusal.find(rule), std::string::npos) << refusal;
}

TEST(VelocityEstimator, refuses_an_order_or_a_cutoff_that_no_filter_has) {
  for (const int order : {-1, 0, 9})
    expect_refused(ButterworthEstimator{order, 50}, "order", "1 to 8");
  for (const int order : {1, 8})
    EXPECT_EQ(find_refusal(ButterworthEstimator{order, 50}), "accepted");
  expect_refused(ButterworthEstimator{2, 0}, "cutoff", "positive");
  expect_refused(ButterworthEstimator{2, std::nan("")}, "cutoff", "positive");
  expect_refused(ButterworthEstimator{2, 500}, "cutoff", "below 500 Hz, the Nyquist frequency");
  expect_refused(ButterworthEstimator{2, 600}, "cutoff", "600 Hz");
  EXPECT_EQ(find_refusal(ButterworthEstimator{2, 499.9}), "accepted");
}

TEST(VelocityEstimator, refuses_an_adaptive_window_without_noise_or_length) {
  expect_refused(AdaptiveWindowEstimator{0, 8, WindowFit::end}, "noise", "quantum");
  expect_refused(AdaptiveWindowEstimator{-1e-3, 8, WindowFit::end}, "noise", "positive");
  expect_refused(AdaptiveWindowEstimator{INFINITY, 8, WindowFit::end}, "noise", "positive");
  expect_refused(AdaptiveWindowEstimator{1e-3, 0, WindowFit::end}, "max_window", "at least 1");
  EXPECT_EQ(find_refusal(AdaptiveWindowEstimator{1e-3, 1, WindowFit::end}), "accepted");
}

TEST(VelocityEstimator, refuses_a_differentiator_that_cannot_follow) {
  expect_refused(LevantEstimator{0}, "acceleration_bound", "positive");
  expect_refused(LevantEstimator{10, 0, 1.1}, "root_gain", "positive");
  expect_refused(LevantEstimator{10, 1.5, 1}, "sign_gain", "above 1");
  EXPECT_EQ(find_refusal(LevantEstimator{10}), "accepted");
}

TEST(VelocityEstimator, that_is_not_linear_has_no_law_and_says_what_has) {
  for (const VelocityEstimator& estimator :
       {VelocityEstimator{AdaptiveWindowEstimator{1e-3}}, VelocityEstimator{LevantEstimator{10}}}) {
    EXPECT_FALSE(find_velocity_law(estimator, T));
    try {
      make_velocity_law(estimator, T);
      FAIL() << "a law of " << name_of(estimator);
    } catch (const Error& error) {
      EXPECT_EQ(error.code(), ErrorCode::bad_input);
      EXPECT_EQ(error.place(), "controller/velocity/kind");
      for (const std::string& part : {std::string(name_of(estimator)), std::string("butterworth")})
        EXPECT_NE(error.message().find(part), std::string::npos) << error.message();
    }
  }
  for (const VelocityEstimator& estimator : make_linear_estimators())
    EXPECT_TRUE(find_velocity_law(estimator, T)) << name_of(estimator);
}

}  // namespace
}  // namespace gyrator
