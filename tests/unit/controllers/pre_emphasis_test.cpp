#include "gyrator/controllers/pre_emphasis.hpp"

#include "gyrator/core/error.hpp"

#include <cmath>
#include <numbers>
#include <vector>

#include <gtest/gtest.h>

namespace gyrator {
namespace {

using Complex = std::complex<double>;
constexpr double T = 1e-3;
constexpr double nyquist = std::numbers::pi / T;

TEST(PreEmphasis, undoes_a_first_order_lag_exactly_at_the_samples) {
  // The held command through 1/(1 - s/p): y[k+1] = a y[k] + (1 - a) u[k], a = e^(pT).
  const double p = -400;
  RunningPreEmphasis stage(make_pre_emphasis({p}, {}, nyquist, T));
  const double a = std::exp(p * T);
  double y = 0;
  for (int k = 0; k < 200; ++k) {
    const double wanted = std::sin(0.37 * k) + 0.2 * (k % 7);
    y = a * y + (1 - a) * stage.step(0, wanted);
    EXPECT_NEAR(y, wanted, 1e-13);
  }
}

TEST(PreEmphasis, has_unit_gain_for_a_constant_command_and_the_closed_form_elsewhere) {
  const std::vector<Complex> poles{{-60, 0}, {-300, 400}, {-300, -400}};
  const std::vector<Complex> zeros{{-90, 0}};
  const DiscreteStateSpace F = make_pre_emphasis(poles, zeros, nyquist, T).filter;
  EXPECT_NEAR(std::abs(F.response(1.0) - 1.0), 0, 1e-12);
  for (const double omega : {1.0, 80.0, 700.0, 3000.0}) {
    const Complex z = std::polar(1.0, omega * T);
    Complex expected = 1;
    for (const Complex s : poles) {
      const Complex a = std::exp(s * T);
      expected *= (1.0 - a / z) / (1.0 - a);
    }
    for (const Complex s : zeros) {
      const Complex c = std::exp(s * T);
      expected *= (1.0 - c) / (1.0 - c / z);
    }
    EXPECT_LT(std::abs(F.response(z) - expected), 1e-11 * std::abs(expected)) << omega;
  }
}

TEST(PreEmphasis, leaves_what_lies_beyond_the_band_or_in_the_right_half_plane) {
  const DiscreteStateSpace F = make_pre_emphasis({-50, -900}, {500.0}, 600, T).filter;
  const DiscreteStateSpace slow = make_pre_emphasis({-50}, {}, 600, T).filter;
  for (const double omega : {10.0, 1000.0}) {
    const Complex z = std::polar(1.0, omega * T);
    EXPECT_LT(std::abs(F.response(z) - slow.response(z)), 1e-14);
  }
}

TEST(PreEmphasis, undoes_the_lag_of_what_is_beyond_nyquist_to_first_order) {
  const Complex pole = -2 * nyquist;
  const DiscreteStateSpace F = make_pre_emphasis({pole}, {}, nyquist, T).filter;
  for (const double omega : {1.0, 30.0}) {
    const Complex s(0, omega);
    // What is left is of second order in sT.
    const Complex left = F.response(std::polar(1.0, omega * T)) / (1.0 - s / pole) - 1.0;
    EXPECT_LT(std::abs(left), omega * T * omega * T) << omega;
  }
}

TEST(PreEmphasis, refuses_a_band_beyond_nyquist_or_without_width) {
  EXPECT_THROW(make_pre_emphasis({}, {}, 1.01 * nyquist, T), Error);
  EXPECT_THROW(make_pre_emphasis({}, {}, 0, T), Error);
  EXPECT_NO_THROW(make_pre_emphasis({}, {}, nyquist, T));
}

}  // namespace
}  // namespace gyrator
