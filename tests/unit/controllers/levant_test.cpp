#include "gyrator/controllers/running_velocity_estimator.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <random>
#include <set>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

// Levant's differentiator against its recursion, its bound and its order of error.

namespace gyrator {
namespace {

constexpr double T = 1e-3;
constexpr double bound = 4;  // |v - y'| <= 4 L T, of the header

double sign(double x) {
  return static_cast<double>((x > 0) - (x < 0));
}

TEST(Levant, runs_the_recursion_of_its_equation) {
  const LevantEstimator config{70, 1.2, 1.4};
  RunningVelocityEstimator run(config, T);
  std::mt19937 random(3);
  std::uniform_real_distribution<double> jump(-1e-3, 1e-3);
  double y = 0.4, z0 = y, z1 = 0;
  for (int k = 0; k < 500; ++k) {
    const double e = z0 - y;
    z0 += T * (z1 - 1.2 * std::sqrt(70 * std::abs(e)) * sign(e));
    z1 -= T * 1.4 * 70 * sign(e);
    ASSERT_NEAR(run.step(y), z1, 1e-12) << k;
    if (k % 7 > 2) y += jump(random);
  }
}

struct ErrorState {
  double position, velocity;  // (z0 - y)/(L T^2) and (z1 - y')/(L T), before a sample
};

// In these units the errors obey one map, whatever L and T:
//   p' = p + q - g0 sqrt|p| sgn p - a,   q' = q - g1 sgn p - m
// m in [-1, 1] the mean acceleration over the step by L, a its mean weighted towards the step's
// start, between m/2 -+ (1 - m^2)/4. All states that a motion can reach, in cells of `cell`.
double find_largest_error(double cell) {
  std::vector<std::pair<double, double>> motions;
  for (const double m : {-1.0, -0.5, 0.0, 0.5, 1.0}) {
    for (const double side : {-1.0, 1.0}) motions.emplace_back(m, m / 2 + side * (1 - m * m) / 4);
  }
  std::set<std::pair<long, long>> seen{{0, 0}};
  std::vector<ErrorState> open{{0, 0}};
  double largest = 0;
  while (!open.empty()) {
    const auto [p, q] = open.back();
    open.pop_back();
    const double estimate = q - 1.1 * sign(p);  // v - y' at the sample
    largest = std::max(largest, std::abs(estimate));
    for (const auto& [m, a] : motions) {
      const ErrorState next{p + q - 1.5 * std::sqrt(std::abs(p)) * sign(p) - a, estimate - m};
      if (seen.emplace(std::lround(next.position / cell), std::lround(next.velocity / cell)).second)
        open.push_back(next);
    }
  }
  return largest;
}

TEST(Levant, has_no_reachable_error_beyond_its_bound) {
  const double largest = find_largest_error(0.1);
  EXPECT_LE(largest, bound);
  EXPECT_GT(largest, 0.9 * bound);  // the bound is not an idle one
}

// Largest |v - y'| after `from` seconds.
template <class Position, class Velocity>
double find_error(const LevantEstimator& config, double period, double from, double until,
                  const Position& position, const Velocity& velocity) {
  RunningVelocityEstimator run(config, period);
  double largest = 0;
  for (int k = 0; k * period < until; ++k) {
    const double t = k * period;
    const double v = run.step(position(t));
    if (t >= from) largest = std::max(largest, std::abs(v - velocity(t)));
  }
  return largest;
}

TEST(Levant, converges_on_a_ramp_in_the_time_that_its_gain_needs) {
  const double L = 50;
  for (const double slope : {0.5, -3.0, 20.0}) {
    const auto position = [&](double t) { return 0.1 + slope * t; };
    const auto velocity = [&](double) { return slope; };
    const double rise = std::abs(slope) / (1.1 * L);
    // The integral alone climbs for that long; overshoot and sliding in take less than as much
    // again.
    EXPECT_LE(find_error({L}, T, 2 * rise + 10 * T, 4 * rise + 1, position, velocity),
              bound * L * T)
        << slope;
    EXPECT_GT(find_error({L}, T, 0.5 * rise, 0.6 * rise + 2 * T, position, velocity),
              0.3 * std::abs(slope))
        << "converged sooner than its gain allows";
  }
}

TEST(Levant, follows_a_sine_of_its_largest_acceleration_to_first_order_in_the_period) {
  const double omega = 12, L = 50;
  const double amplitude = L / (omega * omega);
  for (const double period : {2e-3, 1e-3, 1e-4, 1e-5}) {
    const double error = find_error(
        {L}, period, 0, 3, [&](double t) { return amplitude * std::cos(omega * t); },
        [&](double t) { return -amplitude * omega * std::sin(omega * t); });
    EXPECT_LE(error, bound * L * period) << period;
    EXPECT_GT(error, 0.5 * L * period) << period;
  }
}

TEST(Levant, suffers_from_noise_as_its_root) {
  const double omega = 12, L = 100, fast = 1e-5;
  std::vector<double> ratios;
  for (const double noise : {1e-5, 1e-4, 1e-3}) {  // far above L T^2 = 1e-8
    std::mt19937 random(11);
    std::uniform_real_distribution<double> disturb(-noise, noise);
    const double error = find_error(
        {L}, fast, 0.5, 3, [&](double t) { return 0.3 * std::cos(omega * t) + disturb(random); },
        [&](double t) { return -0.3 * omega * std::sin(omega * t); });
    ratios.push_back(error / std::sqrt(L * noise));
  }
  // A line or a constant in the noise would be off by 10 from one to the next.
  for (const double ratio : ratios) {
    EXPECT_NEAR(ratio / ratios.front(), 1, 0.5) << ratio;
    EXPECT_LE(ratio, 4);
  }
}

TEST(Levant, stays_at_rest_at_rest) {
  RunningVelocityEstimator run(LevantEstimator{50}, T);
  for (int k = 0; k < 100; ++k) EXPECT_EQ(run.step(0.7), 0);
}

}  // namespace
}  // namespace gyrator
