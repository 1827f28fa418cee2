#include "gyrator/identification/held_lag.hpp"

#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>
#include <vector>

#include <gtest/gtest.h>

namespace gyrator {
namespace {

struct Samples {
  std::complex<double> value, slope;  // per sine of the command
};

// The lag stepped exactly from jump to jump of the delayed command e^{jwt}, until it is steady; the
// instant looked at is just before its tick's new command.
Samples step_lag(const HeldLag& lag, double frequency_hz) {
  const double T = lag.tick, w = 2 * std::numbers::pi * frequency_hz, rate = 1 / lag.time_constant;
  const auto command = [&](int k) { return std::polar(1.0, w * T * k); };
  const int whole = static_cast<int>(std::floor(lag.delay / T));
  const double rest = lag.delay - whole * T;
  const int last = 50 + static_cast<int>(40 * lag.time_constant / T);
  std::complex<double> y = 0;
  for (int k = 0; k < last; ++k) {
    const std::complex<double> before = command(k - whole - 1), after = command(k - whole);
    y = before + (y - before) * std::exp(-rest * rate);
    y = after + (y - after) * std::exp(-(T - rest) * rate);
  }
  const std::complex<double> acting = command(last - whole - 1);
  return {y / command(last), (acting - y) * rate / y};
}

TEST(HeldLag, IsTheResponseOfALagSteppedFromJumpToJump) {
  for (const double bandwidth : {150.0, 1000.0, 5000.0})
    for (const double delay : {0.0, 30e-6, 100e-6, 270e-6})
      for (const double frequency : {40.0, 700.0, 3000.0}) {
        const HeldLag lag{1 / (2 * std::numbers::pi * bandwidth), delay, 1e-4};
        const Samples stepped = step_lag(lag, frequency);
        EXPECT_NEAR(std::abs(compute_held_lag(lag, frequency) - stepped.value), 0, 1e-11);
        const std::complex<double> slope = compute_held_slope(lag, frequency, find_acting_age(lag));
        EXPECT_NEAR(std::abs(slope / stepped.slope - 1.0), 0, 1e-9)
            << bandwidth << " " << delay << " " << frequency;
      }
}

// The mean over a tick of the stepped lag, against e^{jwt}: the Fourier coefficient of the sine.
TEST(HeldLag, ItsMeanIsTheFourierCoefficientOfTheLagBetweenTicks) {
  const HeldLag lag{1.5e-4, 130e-6, 1e-4};
  const double frequency = 300, w = 2 * std::numbers::pi * frequency;
  constexpr int parts = 20000;
  const double h = lag.tick / parts;
  // Steady, y(t + T) = z y(t): one tick is enough.
  const auto command = [&](double t) {
    return std::polar(1.0, w * lag.tick * std::floor((t - lag.delay) / lag.tick));
  };
  std::complex<double> y = compute_held_lag(lag, frequency), sum = 0;
  for (int k = 0; k < parts; ++k) {
    const double t = (k + 0.5) * h;
    const std::complex<double> u = command(t);
    const std::complex<double> middle = u + (y - u) * std::exp(-h / 2 / lag.time_constant);
    sum += middle * std::polar(1.0, -w * t) / static_cast<double>(parts);
    y = u + (y - u) * std::exp(-h / lag.time_constant);
  }
  EXPECT_NEAR(std::abs(compute_held_mean(lag, frequency) * compute_held_lag(lag, frequency) - sum),
              0, 1e-7);
}

TEST(HeldLag, WithoutImagesItsSlopeWouldBeJw) {
  const double w = 2 * std::numbers::pi * 40;
  // A lag of many ticks follows a smooth command; a fast one does not.
  const auto off = [&](const HeldLag& lag) {
    return std::abs(compute_held_slope(lag, 40, find_acting_age(lag)) / std::complex<double>(0, w) -
                    1.0);
  };
  EXPECT_LT(off({1e-2, 30e-6, 1e-4}), 0.01);
  EXPECT_GT(off({5e-5, 30e-6, 1e-4}), 0.1);
}

}  // namespace
}  // namespace gyrator
