#include "gyrator/cosim/hold.hpp"

#include <numbers>

#include <gtest/gtest.h>

namespace gyrator {
namespace {

TEST(NormalizedHold, is_the_quotient_that_it_stands_for_and_one_in_continuous_time) {
  constexpr double T = 0.03;
  for (const double omega : {0.5, 20.0, std::numbers::pi / T}) {
    const std::complex<double> s(0, omega);
    const std::complex<double> quotient = (1.0 - std::exp(-s * T)) / (s * T);
    // The quotient's own rounding: one of 1 over wT >= 0.015.
    EXPECT_NEAR(std::abs(compute_normalized_hold(omega, T) - quotient), 0, 3e-14);
  }
  EXPECT_EQ(compute_normalized_hold(3, 0), 1.0);
}

}  // namespace
}  // namespace gyrator
