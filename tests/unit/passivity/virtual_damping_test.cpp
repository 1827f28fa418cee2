#include "gyrator/passivity/virtual_damping.hpp"

#include "gyrator/controllers/virtual_wall.hpp"

#include <gtest/gtest.h>

#include "support/passivity_closed_forms.hpp"

namespace gyrator {
namespace {

using passivity_tests::Complex;
using passivity_tests::pi;
using passivity_tests::Random;

// A handful of rounded operations on numbers of the size of |H| T / sin(wT/2).
constexpr double rounding = 1e-14;

Complex on_unit_circle(double omega, double period) {
  return std::polar(1.0, omega * period);
}

TEST(VirtualDamping, of_a_spring_is_minus_half_a_period_at_every_frequency) {
  const double K = 1234;
  for (const double period : {1e-4, 1e-3, 5e-3}) {
    for (const double share : {1e-9, 1e-4, 0.1, 0.5, 0.999, 1.0}) {
      EXPECT_NEAR(compute_virtual_damping(share * pi / period, period, K), -K * period / 2,
                  rounding * K * period / share)
          << share;
    }
  }
}

TEST(VirtualDamping, of_a_backward_difference_is_its_damping_at_dc_and_minus_that_at_nyquist) {
  const double B = 0.7;
  const double period = 2e-3;
  const DiscreteStateSpace law = make_wall_law({0, B}, period);
  const auto at = [&](double share) {
    const double omega = share * pi / period;
    return compute_virtual_damping(omega, period, law.response(on_unit_circle(omega, period)));
  };
  // B cos(wT): at a thousandth of Nyquist it is B to (wT)^2/2 = 5e-6.
  EXPECT_NEAR(at(1e-3), B, 5e-6 * B);
  EXPECT_NEAR(at(0.5), 0, 1e-12 * B);
  EXPECT_NEAR(at(1), -B, 1e-12 * B);
  for (const double share : {0.01, 0.2, 0.4, 0.9}) {
    // The difference y[k] - y[k-1] loses digits as 1/(wT).
    EXPECT_NEAR(at(share), B * std::cos(share * pi), rounding * B / (share * share));
  }
}

TEST(VirtualDamping, has_the_textbooks_form_with_the_one_minus_cosine) {
  Random random(1);
  for (int i = 0; i < 1000; ++i) {
    const double period = random.log_uniform(1e-4, 1e-2);
    const double share = random.uniform(0.02, 1);
    const double omega = share * pi / period;
    const Complex law(random.uniform(-1, 1), random.uniform(-1, 1));
    const Complex back = std::conj(on_unit_circle(omega, period));
    const double textbook =
        period / (2 * (1 - std::cos(omega * period))) * std::real((back - 1.0) * law);
    // 1 - cos loses digits as 1/(wT)^2, which is why the code has the other form.
    EXPECT_NEAR(compute_virtual_damping(omega, period, law), textbook,
                rounding * period / (share * share * share));
  }
}

TEST(VirtualDamping, falls_by_the_whole_delay_for_a_spring_at_low_frequency) {
  // H = K e^(-j w t_d): b_v -> -K (T/2 + t_d), to (w (T + t_d))^2/6.
  const double K = 50;
  const double period = 1e-3;
  const double delay = 3.3e-3;
  const double omega = 1e-4 * pi / period;
  const Complex late = K * std::polar(1.0, -omega * delay);
  EXPECT_NEAR(compute_virtual_damping(omega, period, late), -K * (period / 2 + delay),
              1e-6 * K * delay);
}

}  // namespace
}  // namespace gyrator
