#include "gyrator/mechanics/actuation_roots.hpp"

#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

#include "support/device_list.hpp"

namespace gyrator {
namespace {

using Complex = std::complex<double>;

Complex evaluate(const ActuationRoots& roots, Complex s) {
  Complex value = 1;
  for (const Complex zero : roots.zeros) value *= 1.0 - s / zero;
  for (const Complex pole : roots.poles) value /= 1.0 - s / pole;
  return value;
}

TEST(ActuationRoots, of_an_rc_branch_follow_the_closed_form) {
  // A = (1 + R_1 C s)/(1 + (R_m + R_1) C s + L_m C s^2)                           [8.48]
  const ActuationRoots roots = find_actuation_roots(testing::make_rc_display());
  constexpr double R_m = 1.5, L_m = 0.5e-3, R_1 = 5, C = 2200e-6;
  ASSERT_EQ(roots.zeros.size(), 1U);
  EXPECT_NEAR(roots.zeros[0].real() * R_1 * C, -1, 1e-9);
  ASSERT_EQ(roots.poles.size(), 2U);
  for (const double hz : {0.01, 1.0, 11.0, 200.0, 5000.0, 1e5}) {
    const Complex s(0, 2 * std::numbers::pi * hz);
    const Complex expected = (1.0 + R_1 * C * s) / (1.0 + (R_m + R_1) * C * s + L_m * C * s * s);
    EXPECT_LT(std::abs(evaluate(roots, s) - expected), 1e-9 * std::abs(expected)) << hz;
  }
}

TEST(ActuationRoots, an_ideal_drive_has_none) {
  const ActuationRoots roots = find_actuation_roots(testing::make_p3());
  EXPECT_TRUE(roots.poles.empty());
  EXPECT_TRUE(roots.zeros.empty());
}

TEST(ActuationRoots, an_amplifier_bandwidth_is_one_pole) {
  Device device = testing::make_re25();
  device.drive.amplifier = CurrentAmplifier{.bandwidth_hz = 150};
  const ActuationRoots roots = find_actuation_roots(device);
  EXPECT_TRUE(roots.zeros.empty());
  ASSERT_EQ(roots.poles.size(), 1U);
  EXPECT_NEAR(roots.poles[0].real(), -2 * std::numbers::pi * 150, 1e-6);
  EXPECT_EQ(roots.poles[0].imag(), 0);
}

TEST(ActuationRoots, a_transmission_takes_no_part) {
  Device device = testing::make_rc_display();
  const ActuationRoots rigid = find_actuation_roots(device);
  device.mechanics.transmission =
      Transmission{.stiffness = 50, .damping = 1e-3, .load_inertia = 1e-5};
  const ActuationRoots compliant = find_actuation_roots(device);
  ASSERT_EQ(compliant.poles.size(), rigid.poles.size());
  const Complex s(0, 300);
  EXPECT_LT(std::abs(evaluate(compliant, s) - evaluate(rigid, s)), 1e-9);
}

}  // namespace
}  // namespace gyrator
