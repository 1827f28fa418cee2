#include "gyrator/cosim/sampled_plant.hpp"

#include "gyrator/controllers/virtual_wall.hpp"

#include <cmath>
#include <functional>
#include <numbers>
#include <string>

#include <gtest/gtest.h>

#include "support/device_list.hpp"

namespace gyrator {
namespace {

using testing::make_p3;

constexpr double rounding = 1e-13;

Sampling every_ms(Rational period_ms, Rational delay_ms) {
  return {period_ms / 1000, delay_ms / 1000};
}

Device make_inertia(double inertia, double damping) {
  Device device;
  device.mechanics.inertia = inertia;
  device.mechanics.damping = damping;
  return device;
}

double find_radius(const Device& device, const Operator& held_by, const Sampling& sampling,
                   const VirtualWall& wall) {
  return compute_loop_radius(device, held_by, sampling,
                             make_wall_law(wall, sampling.period.to_double()));
}

TEST(SplitDelay, is_whole_periods_and_the_rest) {
  const auto split = [](Rational delay_ms) { return split_delay(every_ms(1, delay_ms)); };
  EXPECT_EQ(split(0).whole, 0);
  EXPECT_EQ(split(0).rest, 0);
  EXPECT_EQ(split(Rational(3, 10)).whole, 0);
  EXPECT_EQ(split(Rational(3, 10)).rest, 0.3e-3);
  EXPECT_EQ(split(1).whole, 1) << "exactly one period leaves no rest";
  EXPECT_EQ(split(1).rest, 0);
  EXPECT_EQ(split(Rational(5, 2)).whole, 2);
  EXPECT_EQ(split(Rational(5, 2)).rest, 0.5e-3);
  EXPECT_EQ(split_delay({Rational(1, 3), Rational(1)}).whole, 3);
  EXPECT_EQ(split_delay({Rational(1, 3), Rational(1)}).rest, 0);
}

TEST(SampledPlant, of_mass_and_damper_is_the_hold_equivalent_with_the_late_command_first) {
  // Position gain of a held effort over h: (h - tau (1 - e^{-h/tau}))/b, velocity gain
  // (1 - e^{-h/tau})/b. The late command holds for `rest`, then coasts; the recent one for T -
  // rest.
  constexpr double m = 0.04, b = 0.8, tau = m / b, T = 1e-3, rest = 0.3e-3;
  const auto position_gain = [&](double h) { return (h + tau * std::expm1(-h / tau)) / b; };
  const auto velocity_gain = [&](double h) { return -std::expm1(-h / tau) / b; };
  const Plant plant = build_plant(build_device_network(make_p3(), FreeOperator{}));
  const SampledPlant sampled = sample_plant(plant, every_ms(1, Rational(3, 10)));
  const double recent = sampled.sense * sampled.recent;
  const double late = sampled.sense * sampled.late;
  EXPECT_NEAR(recent / position_gain(T - rest), 1, 1e-11);  // the closed form cancels 1e2-fold
  const double coasting = tau * -std::expm1(-(T - rest) / tau);
  EXPECT_NEAR(late / (position_gain(rest) + velocity_gain(rest) * coasting), 1, 1e-11);
  const double v_recent = plant.port_velocity.state * sampled.recent;
  EXPECT_NEAR(v_recent / velocity_gain(T - rest), 1, rounding);
  const Eigen::VectorXd moved = sampled.phi * plant.initial_state(2, 1);
  EXPECT_NEAR(plant.port_position.state * moved, 2 - tau * std::expm1(-T / tau), rounding);
}

TEST(SampledPlant, without_a_rest_has_no_late_command) {
  const Plant plant = build_plant(build_device_network(make_p3(), FreeOperator{}));
  EXPECT_TRUE(sample_plant(plant, every_ms(1, 0)).late.isZero(0));
  EXPECT_TRUE(sample_plant(plant, every_ms(1, 3)).late.isZero(0));
}

// Stable just below the stiffness and unstable just above it, by the last digit that is given.
void expect_critical(double stiffness, double digit, const Device& device, const Operator& held_by,
                     const Sampling& sampling, double damping) {
  const auto radius = [&](double K) {
    return find_radius(device, held_by, sampling, {.stiffness = K, .damping = damping});
  };
  EXPECT_LE(radius(stiffness - digit), 1 + stability_tolerance) << "below " << stiffness;
  EXPECT_GT(radius(stiffness + digit), 1 + stability_tolerance) << "above " << stiffness;
}

TEST(LoopMatrix, case_7_critical_stiffness_of_a_spring_alone) {
  // K = b (1 - e)/((m/b)(1 - e) - T e), e = exp(-b T/m)
  expect_critical(1605.351, 1e-3, make_p3(), FreeOperator{}, every_ms(1, 0), 0);
  expect_critical(325.423, 1e-3, make_p3(), FreeOperator{}, every_ms(5, 0), 0);
  for (const int period_ms : {1, 2, 5, 20}) {
    constexpr double m = 0.04, b = 0.8;
    const double T = period_ms * 1e-3;
    const double e = std::exp(-b * T / m), lost = -std::expm1(-b * T / m);
    const double K = b * lost / (m / b * lost - T * e);
    expect_critical(K, 1e-6 * K, make_p3(), FreeOperator{}, every_ms(period_ms, 0), 0);
  }
}

TEST(LoopMatrix, case_8_a_hand_on_the_device_with_one_sample_of_delay) {
  const double expected[] = {538.50, 1909.94, 6225.92};
  const double hand_damping[] = {0, 2, 8};
  for (int i = 0; i < 3; ++i) {
    const MassSpringDamper hand{
        .inertia = 0, .damping = hand_damping[i], .stiffness = 400, .resonators = {}};
    expect_critical(expected[i], 0.01, make_p3(), hand, every_ms(1, 1), 0);
  }
}

TEST(LoopMatrix, case_9_virtual_damping_with_delays_of_whole_samples) {
  expect_critical(4990.43, 0.01, make_inertia(1, 0.5), FreeOperator{}, every_ms(1, 0), 2);
  expect_critical(1663.20, 0.01, make_inertia(1, 0.5), FreeOperator{}, every_ms(1, 1), 2);
  expect_critical(997.42, 0.01, make_inertia(1, 0.5), FreeOperator{}, every_ms(1, 2), 2);
}

TEST(LoopMatrix, case_10_an_undamped_mass) {
  // alpha = K T^2/m, beta = B T/m: stable iff 0 < beta < 2 and alpha < 2 beta (2 - beta)/(2 + beta)
  constexpr double m = 0.5, T = 1e-3;
  for (const double beta : {0.1, 0.8, 1.5, 1.95}) {
    const double alpha = 2 * beta * (2 - beta) / (2 + beta);
    const double K = alpha * m / (T * T);
    expect_critical(K, 1e-6 * K, make_inertia(m, 0), FreeOperator{}, every_ms(1, 0), beta * m / T);
  }
  for (const double beta : {2.05, -0.05}) {  // beyond: not even a soft spring
    EXPECT_GT(find_radius(make_inertia(m, 0), FreeOperator{}, every_ms(1, 0),
                          {.stiffness = 1, .damping = beta * m / T}),
              1 + 1e-7);
  }
}

TEST(LoopMatrix, delays_on_both_sides_of_a_whole_period_meet_there) {
  const auto radius = [](Rational delay_ms) {
    return find_radius(make_p3(), FreeOperator{}, every_ms(1, delay_ms),
                       {.stiffness = 900, .damping = 0.2});
  };
  const Rational tiny(1, 1000000);
  // The radius moves by some 0.1 per period of delay, so by 1e-7 over this one.
  EXPECT_NEAR(radius(1), radius(1 - tiny), 1e-6);
  EXPECT_NEAR(radius(1), radius(1 + tiny), 1e-6);
  EXPECT_NE(radius(1), radius(1 - tiny));
  EXPECT_LT(radius(0), radius(Rational(1, 2)));
  EXPECT_LT(radius(Rational(1, 2)), radius(1));
}

TEST(DominantPole, is_the_largest_with_its_frequency) {
  // A rotation by 2 pi 120 Hz T with 0.99, beside a real 0.9.
  const double T = 1e-3, angle = 2 * std::numbers::pi * 120 * T;
  Eigen::MatrixXd loop = Eigen::MatrixXd::Zero(3, 3);
  loop << 0.99 * std::cos(angle), 0.99 * std::sin(angle), 0, -0.99 * std::sin(angle),
      0.99 * std::cos(angle), 0, 0, 0, -0.9;
  const DominantPole pole = find_dominant_pole(loop, T);
  EXPECT_NEAR(pole.magnitude, 0.99, rounding);
  EXPECT_NEAR(pole.frequency_hz, 120, 120 * rounding);
  EXPECT_NEAR(compute_spectral_radius(loop), 0.99, rounding);
  loop(2, 2) = -1.5;  // alternates from sample to sample: the Nyquist frequency
  EXPECT_NEAR(find_dominant_pole(loop, T).frequency_hz, 500, 500 * rounding);
  loop(0, 0) = std::nan("");
  EXPECT_TRUE(std::isinf(compute_spectral_radius(loop))) << "not finite counts as unstable";
}

}  // namespace
}  // namespace gyrator
