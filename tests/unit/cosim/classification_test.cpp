#include "gyrator/cosim/classification.hpp"

#include <cmath>
#include <functional>
#include <numbers>
#include <vector>

#include <gtest/gtest.h>

namespace gyrator {
namespace {

constexpr double T = 1e-3;

// Velocity e^(rate t) sin(2 pi f t) and its position but for a constant, for `count` samples.
struct Motion {
  std::vector<double> position, velocity;
};
Motion oscillate(double hz, double rate, int count, double drift = 0) {
  Motion m;
  const double w = 2 * std::numbers::pi * hz;
  for (int k = 0; k < count; ++k) {
    const double t = k * T;
    const double e = std::exp(rate * t);
    m.velocity.push_back(e * std::sin(w * t) + drift);
    m.position.push_back(
        e * (rate * std::sin(w * t) - w * std::cos(w * t)) / (w * w + rate * rate) + drift * t);
  }
  return m;
}
Classification judge(const Motion& m, const ClassificationOptions& options = {}) {
  return classify(m.position, m.velocity, T, false, options);
}

TEST(Classification, tells_a_decay_a_cycle_and_a_growth_apart) {
  EXPECT_EQ(judge(oscillate(40, -3, 1500)).outcome, Outcome::settles);
  EXPECT_EQ(judge(oscillate(40, 0, 1500)).outcome, Outcome::limit_cycle);
  EXPECT_EQ(judge(oscillate(40, 3, 1500)).outcome, Outcome::diverges);
}

TEST(Classification, growth_is_that_of_one_half_of_the_last_third_over_the_other) {
  // 1500 samples: halves of 250 ms, ten cycles each; e^(rate 0.25 s).
  for (const double rate : {-2.0, 0.0, 1.0}) {
    // The extremes of a sampled sinusoid are found to 1 - cos(w T/2) = 0.8 %, alike in both halves.
    EXPECT_NEAR(judge(oscillate(40, rate, 1500)).growth, std::exp(rate * 0.25), 0.01) << rate;
  }
}

TEST(Classification, changes_its_mind_at_the_growth_limit_from_both_sides) {
  // Periods of a whole number of samples (25), so that the extremes are found alike.
  const double at_limit = std::log(1.02) / 0.25;
  EXPECT_EQ(judge(oscillate(40, 1.05 * at_limit, 1500)).outcome, Outcome::diverges);
  EXPECT_EQ(judge(oscillate(40, 0.95 * at_limit, 1500)).outcome, Outcome::limit_cycle);
  EXPECT_EQ(judge(oscillate(40, -0.95 * at_limit, 1500)).outcome, Outcome::limit_cycle);
  EXPECT_EQ(judge(oscillate(40, -1.05 * at_limit, 1500)).outcome, Outcome::settles);
  EXPECT_EQ(judge(oscillate(40, 1.05 * at_limit, 1500), {.growth_limit = 1.05}).outcome,
            Outcome::limit_cycle);
}

TEST(Classification, a_swing_below_the_rest_fraction_of_the_largest_is_rest) {
  // A unit kick first, then a lasting chatter of 2e-4 or 0.5e-4 of it.
  for (const double chatter : {2e-4, 0.5e-4}) {
    Motion m = oscillate(40, 0, 1500);
    for (std::size_t k = 100; k < m.velocity.size(); ++k) m.velocity[k] *= chatter;
    EXPECT_EQ(judge(m).outcome, chatter > 1e-4 ? Outcome::limit_cycle : Outcome::settles);
    EXPECT_EQ(judge(m, {.rest_fraction = 1e-3}).outcome, Outcome::settles);
  }
}

TEST(Classification, measures_amplitude_and_frequency_of_a_cycle) {
  for (const double hz : {11.0, 40.0, 137.3}) {
    const Classification c = judge(oscillate(hz, 0, 3000));
    // Sampled extremes fall short by 1 - cos(w T/2) at most. A crossing is interpolated with an
    // error of (w T)^2/16 of T at most, over the whole last second.
    const double angle = 2 * std::numbers::pi * hz * T;
    const double amplitude = 1 / (2 * std::numbers::pi * hz);
    EXPECT_LE(c.amplitude, amplitude * (1 + 1e-12)) << hz;
    EXPECT_GE(c.amplitude, amplitude * std::cos(angle / 2)) << hz;
    EXPECT_NEAR(c.frequency_hz / hz, 1, angle * angle / 8 * 1e-3 / 0.9 + 1e-6) << hz;
  }
}

TEST(Classification, ignores_a_steady_drift) {
  const Classification c = judge(oscillate(40, -20, 1500, 0.3));
  EXPECT_EQ(c.outcome, Outcome::settles);
  EXPECT_NEAR(judge(oscillate(40, 0, 1500, 5)).frequency_hz, 40, 0.04);
  const Motion rest{std::vector<double>(300, 1.0), std::vector<double>(300, 0.0)};
  EXPECT_EQ(judge(rest).outcome, Outcome::settles);
  EXPECT_EQ(judge(rest).frequency_hz, 0);
}

TEST(Classification, a_run_that_was_stopped_diverges_whatever_it_looks_like) {
  const Motion m = oscillate(40, -3, 1500);
  EXPECT_EQ(classify(m.position, m.velocity, T, true).outcome, Outcome::diverges);
}

TEST(Classification, of_a_few_samples_or_none_is_rest) {
  for (const int count : {0, 1, 2, 5}) {
    const Classification c = judge(oscillate(40, 3, count));
    EXPECT_EQ(c.outcome, Outcome::settles) << count;
    EXPECT_EQ(c.frequency_hz, 0) << count;
  }
}

TEST(Classification, names_its_outcomes_as_the_interface_does) {
  EXPECT_EQ(name_of(Outcome::settles), "settles");
  EXPECT_EQ(name_of(Outcome::limit_cycle), "limit_cycle");
  EXPECT_EQ(name_of(Outcome::diverges), "diverges");
}

}  // namespace
}  // namespace gyrator
