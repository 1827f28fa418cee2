#include "gyrator/controllers/running_velocity_estimator.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <numbers>
#include <random>
#include <string>
#include <vector>

#include <gtest/gtest.h>

// The adaptive window against the sentence that defines it, in whole numbers of encoder steps.

namespace gyrator {
namespace {

using Counts = std::vector<std::int64_t>;

constexpr double T = 1e-3;
constexpr double quantum = 2 * std::numbers::pi / 8192;
// Differences of positions of some hundred quanta over 1 ms.
constexpr double rounding = 1e-9;

std::int64_t count_at(const Counts& y, std::size_t k, std::size_t back) {
  return back > k ? y.front() : y[k - back];  // the first as if it had been there for ever
}

// The line through y[k] and y[k-n] at y[k-i] is y[k] - i (y[k] - y[k-n])/n; times n no fractions.
bool passes(const Counts& y, std::size_t k, std::size_t n, std::int64_t noise) {
  const auto span = static_cast<std::int64_t>(n);
  for (std::size_t i = 1; i < n; ++i) {
    const std::int64_t line =
        static_cast<std::int64_t>(i) * (count_at(y, k, 0) - count_at(y, k, n));
    const std::int64_t sample = span * (count_at(y, k, 0) - count_at(y, k, i));
    if (std::abs(line - sample) > span * noise) return false;
  }
  return true;
}

std::size_t find_window(const Counts& y, std::size_t k, std::int64_t noise, std::size_t longest) {
  std::size_t n = longest;
  while (!passes(y, k, n, noise)) --n;
  return n;
}

// Slope of least squares through the last n + 1 samples, per sample.
double fit_slope(const Counts& y, std::size_t k, std::size_t n) {
  const auto rows = static_cast<Eigen::Index>(n) + 1;
  Eigen::MatrixXd X(rows, 2);
  Eigen::VectorXd values(rows);
  for (Eigen::Index i = 0; i < rows; ++i) {
    X.row(i) << 1, -static_cast<double>(i);
    values(i) = static_cast<double>(count_at(y, k, static_cast<std::size_t>(i)));
  }
  return X.colPivHouseholderQr().solve(values)(1);
}

// Motions of an encoder: noise, walks, swings from still to fast, with jumps.
std::vector<Counts> make_signals() {
  std::mt19937 random(7);
  std::vector<Counts> signals;
  for (const int reach : {1, 2, 40}) {
    std::uniform_int_distribution<std::int64_t> step(-reach, reach);
    Counts noise, walk{1000};
    for (int k = 0; k < 300; ++k) noise.push_back(step(random));
    for (int k = 0; k < 300; ++k) walk.push_back(walk.back() + step(random));
    signals.push_back(noise);
    signals.push_back(walk);
  }
  for (const double amplitude : {3.0, 30.0, 3000.0}) {
    Counts swing;
    for (int k = 0; k < 400; ++k)
      swing.push_back(std::llround(amplitude * std::sin(0.02 * k)) + (k > 250 ? 50 : 0));
    signals.push_back(swing);
  }
  return signals;
}

TEST(AdaptiveWindow, is_the_longest_that_a_line_passes_within_the_noise) {
  for (const Counts& y : make_signals()) {
    for (const std::int64_t noise : {1, 2, 5}) {
      for (const int longest : {1, 2, 7, 32}) {
        const double d = static_cast<double>(noise) * quantum;
        RunningAdaptiveWindow end({d, longest, WindowFit::end}, T);
        RunningAdaptiveWindow best({d, longest, WindowFit::best}, T);
        end.settle(quantum * static_cast<double>(y[0]));
        best.settle(quantum * static_cast<double>(y[0]));
        for (std::size_t k = 0; k < y.size(); ++k) {
          const double position = quantum * static_cast<double>(y[k]);
          const double from_ends = end.step(position);
          const double from_fit = best.step(position);
          const std::size_t n = find_window(y, k, noise, static_cast<std::size_t>(longest));
          ASSERT_EQ(end.window(), static_cast<int>(n)) << "sample " << k << ", noise " << noise;
          ASSERT_EQ(best.window(), static_cast<int>(n)) << "sample " << k << ", noise " << noise;
          const auto rise = static_cast<double>(count_at(y, k, 0) - count_at(y, k, n));
          ASSERT_NEAR(from_ends, rise * quantum / (static_cast<double>(n) * T), rounding);
          ASSERT_NEAR(from_fit, fit_slope(y, k, n) * quantum / T, rounding) << n;
        }
      }
    }
  }
}

TEST(AdaptiveWindow, of_a_clean_ramp_is_its_slope_with_either_fit) {
  for (const WindowFit fit : {WindowFit::end, WindowFit::best}) {
    for (const double slope : {0.0, 0.3, -17.0}) {
      RunningVelocityEstimator run(AdaptiveWindowEstimator{1e-9, 20, fit}, T);
      double v = 1;
      for (int k = 0; k < 60; ++k) v = run.step(0.25 + slope * k * T);
      EXPECT_NEAR(v, slope, 1e-11);  // rounding of positions of about one over T
    }
  }
}

TEST(AdaptiveWindow, is_the_whole_window_at_every_constant_velocity_of_an_encoder) {
  for (const double counts_per_sample : {0.0, 0.03, 0.5, 0.77, 3.3, -12.9}) {
    RunningAdaptiveWindow run({quantum, 32, WindowFit::end}, T);
    run.settle(0);
    for (int k = 0; k < 200; ++k) {
      const double v = run.step(quantum * std::floor(counts_per_sample * k + 0.5));
      if (k < 32) continue;
      ASSERT_EQ(run.window(), 32) << counts_per_sample;
      // Both ends of the window are half a quantum off at most.
      ASSERT_NEAR(v, counts_per_sample * quantum / T, quantum / (32 * T) + rounding);
    }
  }
}

TEST(AdaptiveWindow, shrinks_to_one_sample_on_a_step_and_grows_from_it) {
  RunningAdaptiveWindow run({quantum, 10, WindowFit::end}, T);
  run.settle(0);
  for (int k = 0; k < 20; ++k) run.step(0);
  EXPECT_EQ(run.window(), 10);
  const double height = 1000 * quantum;
  EXPECT_NEAR(run.step(height), height / T, rounding);
  EXPECT_EQ(run.window(), 1);
  for (int since = 1; since <= 15; ++since) {
    EXPECT_EQ(run.step(height), 0) << since;
    EXPECT_EQ(run.window(), std::min(since, 10)) << since;
  }
}

TEST(AdaptiveWindow, takes_a_longer_window_beyond_one_that_fails) {
  // From 0 back: 3, 3, 6. The line to the second 3 misses the first by 1.5, the line to 6 both
  // by 1.
  const Counts y{6, 6, 6, 3, 3, 0};
  const std::int64_t noise = 1;
  const std::size_t k = 5;
  ASSERT_FALSE(passes(y, k, 2, noise));
  ASSERT_TRUE(passes(y, k, 3, noise));
  RunningAdaptiveWindow run({quantum, 3, WindowFit::end}, T);
  run.settle(6 * quantum);
  for (const std::int64_t count : y) run.step(quantum * static_cast<double>(count));
  EXPECT_EQ(run.window(), 3);
}

}  // namespace
}  // namespace gyrator
