#include "gyrator/identification/motor_fit.hpp"

#include "gyrator/core/random_stream.hpp"
#include "gyrator/identification/amplifier_fit.hpp"

#include <cmath>
#include <complex>
#include <numbers>
#include <vector>

#include <gtest/gtest.h>

namespace gyrator {
namespace {

using Complex = std::complex<double>;
constexpr double tick = 1e-4;
constexpr double R = 2, L = 0.3e-3, K = 0.025, J_per_K = 5e-5, b_per_K = 6e-5, c_per_K = 0.02;

HeldLag make_lag(double bandwidth_hz, double delay) {
  return {1 / (2 * std::numbers::pi * bandwidth_hz), delay, tick};
}

// Sines of 1 A through the lag, of a frictionless rotor at 318.15 K, with noise on every part.
std::vector<SineMeasurement> make_sines(const HeldLag& lag, double noise, RandomStream& random) {
  std::vector<SineMeasurement> sines;
  const auto disturb = [&](Complex value) {
    return Phasor{value + noise * Complex(random.normal(), random.normal()),
                  std::max(noise, 1e-12)};
  };
  for (int turn = 0; turn < 2; ++turn)
    for (double f = 40; f < 1500; f *= 1.48) {
      const Complex s(0, 2 * std::numbers::pi * f);
      const Complex current = compute_held_lag(lag, f);
      const Complex velocity = current / (s * J_per_K + b_per_K);
      const Complex slope = compute_held_slope(lag, f, find_acting_age(lag));
      SineMeasurement sine;
      sine.frequency_hz = f;
      sine.command = Phasor{1, 0};
      sine.current = disturb(current);
      sine.temperature = 318.15;
      sine.voltage = disturb((R * (1 + 0.00393 * 20) + slope * L) * current + K * velocity);
      sine.velocity = disturb(velocity);
      sine.group = static_cast<int>(sines.size());
      sines.push_back(sine);
    }
  return sines;
}

TEST(AmplifierFit, FindsBandwidthAndDelayExactly) {
  RandomStream random(1, 1);
  for (const double bandwidth : {400.0, 1000.0, 3000.0})
    for (const double delay : {0.0, 40e-6, 100e-6, 200e-6, 290e-6}) {
      const auto fit = fit_amplifier(make_sines(make_lag(bandwidth, delay), 0, random), tick);
      ASSERT_TRUE(fit);
      EXPECT_NEAR(fit->fit.values[0], 1, 1e-6);
      EXPECT_NEAR(fit->lag(tick).time_constant * 2 * std::numbers::pi * bandwidth, 1, 1e-5);
      EXPECT_NEAR(fit->lag(tick).delay, delay, 1e-9);
    }
}

TEST(AmplifierFit, NeedsTheCommand) {
  RandomStream random(1, 1);
  auto sines = make_sines(make_lag(1000, 0), 0, random);
  for (SineMeasurement& sine : sines) sine.command.reset();
  EXPECT_FALSE(fit_amplifier(sines, tick));
}

// 200 intervals of 90 %, 1.2 times as wide: as those of 95 %, 10 misses with a deviation of 3.
constexpr int repetitions = 200, fewest = 1, most = 22;

TEST(AmplifierFit, ItsIntervalsHold) {
  RandomStream random(2, 1);
  const HeldLag lag = make_lag(1200, 130e-6);
  int constant_misses = 0, delay_misses = 0;
  for (int k = 0; k < repetitions; ++k) {
    const auto fit = fit_amplifier(make_sines(lag, 2e-3, random), tick);
    const Interval constant = find_interval(fit->fit.at(1), 0.9);
    const Interval delay = find_interval(fit->fit.at(2), 0.9);
    constant_misses += lag.time_constant < constant.low || lag.time_constant > constant.high;
    delay_misses += lag.delay < delay.low || lag.delay > delay.high;
  }
  EXPECT_GE(constant_misses, fewest);
  EXPECT_LE(constant_misses, most);
  EXPECT_GE(delay_misses, fewest);
  EXPECT_LE(delay_misses, most);
}

// Windows of ± slow motion with all of (motion-1) and (winding-1).
std::vector<MotionWindow> make_windows(double noise, RandomStream& random) {
  std::vector<MotionWindow> windows;
  for (int k = 0; k < 240; ++k) {
    MotionWindow window;
    const double phase = 2 * std::numbers::pi * (k + 0.5) / 40;
    window.velocity = 300 * std::sin(phase);
    window.acceleration = 300 * 8 * std::cos(phase);
    window.direction = std::abs(window.velocity) < 10 ? 0 : window.velocity > 0 ? 1 : -1;
    const double friction = window.velocity > 0 ? c_per_K : -c_per_K;
    const double current =
        J_per_K * window.acceleration + b_per_K * window.velocity + friction + 0.004;
    window.temperature = 298.15 + k / 100.0;
    window.voltage = R * (1 + 0.00393 * k / 100.0) * (current - 0.004) + K * window.velocity +
                     0.01 + 5 * noise * random.normal();
    window.current = current - 0.004 + noise * random.normal();
    window.group = k / 10;
    windows.push_back(window);
  }
  return windows;
}

TEST(MotorFit, MotionIsFoundBesideAnOffsetOfTheCurrent) {
  RandomStream random(1, 1);
  std::vector<MotionWindow> windows = make_windows(0, random);
  for (MotionWindow& window : windows) window.current += 0.004;
  const MotionFit fit = fit_motion(windows);
  EXPECT_NEAR(fit.inertia() / J_per_K, 1, 1e-9);
  EXPECT_NEAR(fit.damping() / b_per_K, 1, 1e-9);
  EXPECT_NEAR(fit.friction() / c_per_K, 1, 1e-9);
  EXPECT_NEAR(fit.fit.values[3], 0.004, 1e-12);
}

TEST(MotorFit, IntervalsOfTheMotionHold) {
  RandomStream random(6, 1);
  const double truth[] = {J_per_K, b_per_K, c_per_K};
  int misses[3] = {0, 0, 0};
  for (int k = 0; k < repetitions; ++k) {
    const MotionFit fit = fit_motion(make_windows(1e-3, random));
    for (int i = 0; i < 3; ++i) {
      const Interval interval = find_interval(fit.fit.at(i), 0.9);
      misses[i] += truth[i] < interval.low || truth[i] > interval.high;
    }
  }
  for (const int missed : misses) {
    EXPECT_GE(missed, fewest);
    EXPECT_LE(missed, most);
  }
}

TEST(MotorFit, FrictionLowersAndTurnsTheSpeedOfASine) {
  MotionFit motion;
  motion.fit.values = Eigen::Vector4d(J_per_K, b_per_K, c_per_K, 0);
  const double f = 100, w = 2 * std::numbers::pi * f;
  const Complex velocity = compute_sine_velocity(motion, 1.0, f);
  const double speed = std::abs(velocity);
  // What (motion-2) asks for, put in.
  const Complex current =
      Complex(b_per_K, w * J_per_K) * velocity + 4 / std::numbers::pi * c_per_K * velocity / speed;
  EXPECT_NEAR(std::abs(current - 1.0), 0, 1e-12);
  EXPECT_EQ(compute_sine_velocity(motion, 0.02, f), Complex(0));
}

TEST(MotorFit, TheWindingIsFoundAtItsReferenceTemperature) {
  RandomStream random(1, 1);
  const HeldLag lag = make_lag(1000, 130e-6);
  WindingOptions options;
  options.lag = lag;
  const auto fit = fit_winding(make_sines(lag, 0, random), make_windows(0, random), options);
  ASSERT_TRUE(fit);
  EXPECT_EQ(fit->age, 2);
  EXPECT_NEAR(fit->fit.values[0] / R, 1, 1e-9);
  EXPECT_NEAR(fit->fit.values[1] / L, 1, 1e-9);
  EXPECT_NEAR(fit->fit.values[2] / K, 1, 1e-9);
  EXPECT_NEAR(fit->fit.values[3], 0.01, 1e-9);
}

TEST(MotorFit, WithoutTheImagesTheInductanceWouldBeWrong) {
  RandomStream random(1, 1);
  const HeldLag lag = make_lag(1000, 130e-6);
  const auto fit = fit_winding(make_sines(lag, 0, random), make_windows(0, random), {});
  EXPECT_GT(std::abs(fit->fit.values[1] / L - 1), 0.03);
}

TEST(MotorFit, IntervalsOfTheWindingHoldWithNoiseOnAllSignals) {
  RandomStream random(7, 1);
  const HeldLag lag = make_lag(1000, 130e-6);
  WindingOptions options;
  options.lag = lag;
  const double truth[] = {R, L, K};
  int misses[3] = {0, 0, 0};
  for (int k = 0; k < repetitions; ++k) {
    const auto fit =
        fit_winding(make_sines(lag, 2e-3, random), make_windows(1e-3, random), options);
    for (int i = 0; i < 3; ++i) {
      const Interval interval = find_interval(fit->fit.at(i), 0.9);
      misses[i] += truth[i] < interval.low || truth[i] > interval.high;
    }
  }
  for (const int missed : misses) {
    EXPECT_GE(missed, fewest);
    EXPECT_LE(missed, most);
  }
}

TEST(MotorFit, WithoutAVoltageThereIsNoWinding) {
  RandomStream random(1, 1);
  auto sines = make_sines(make_lag(1000, 0), 0, random);
  for (SineMeasurement& sine : sines) sine.voltage.reset();
  EXPECT_FALSE(fit_winding(sines, {}, {}));
}

}  // namespace
}  // namespace gyrator
