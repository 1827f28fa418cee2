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

TEST(Classification, growth_is_the_factor_of_swing_over_a_sixth_of_the_run) {
  // 1500 samples: a sixth is 250 ms, ten cycles, e^(rate 0.25 s).                        (cls-1)
  for (const double rate : {-2.0, 0.0, 1.0}) {
    // The extremes of a sampled sinusoid are found to 1 - cos(w T/2) = 0.8 %, alike in each cycle.
    EXPECT_NEAR(judge(oscillate(40, rate, 1500)).growth, std::exp(rate * 0.25), 0.01) << rate;
  }
}

TEST(Classification, only_the_last_third_counts_where_it_holds_two_cycles) {
  // Decays fast for two thirds, then goes on for ever at what is left; and the other way round.
  Motion cycle = oscillate(40, -4, 1500);
  Motion decay = oscillate(40, 4, 1500);
  const Motion steady = oscillate(40, 0, 1500), falling = oscillate(40, -4, 1500);
  for (std::size_t k = 1000; k < 1500; ++k) {
    cycle.velocity[k] = std::exp(-4.0) * steady.velocity[k];
    decay.velocity[k] = std::exp(8.0) * falling.velocity[k];
  }
  EXPECT_EQ(judge(cycle).outcome, Outcome::limit_cycle);
  EXPECT_NEAR(judge(cycle).growth, 1, 0.01);
  EXPECT_EQ(judge(decay).outcome, Outcome::settles);
}

TEST(Classification, a_run_of_few_cycles_is_judged_by_all_of_them) {
  // From three cycles in all (one in the last third), at several phases of the start.
  for (const int lead : {0, 7, 13, 19, 31}) {
    for (const int count : {125, 150, 200, 300}) {  // three to eight cycles of 25 samples
      for (const double rate : {-6.0, -1.0, 1.0, 6.0}) {
        const Motion all = oscillate(40, rate, count + lead);
        const Motion part{{all.position.begin() + lead, all.position.end()},
                          {all.velocity.begin() + lead, all.velocity.end()}};
        const double growth = std::exp(rate * count * T / 6);
        if (std::abs(std::log(growth)) < 2 * std::log(1.02)) continue;  // too near to tell
        EXPECT_EQ(judge(part).outcome, rate > 0 ? Outcome::diverges : Outcome::settles)
            << "rate " << rate << ", " << count << " samples from " << lead << ", growth "
            << judge(part).growth;
      }
    }
  }
}

TEST(Classification, without_a_cycle_an_exponential_diverges_and_a_swing_on_its_way_does_not) {
  Motion runaway, ramp, terminal;
  for (int k = 0; k < 600; ++k) {
    const double t = k * T;
    runaway.velocity.push_back(1e-3 * std::exp(20 * t));
    ramp.velocity.push_back(t);                        // a free mass under a steady push
    terminal.velocity.push_back(-std::expm1(-5 * t));  // and with a damper
  }
  for (Motion* motion : {&runaway, &ramp, &terminal}) motion->position.assign(600, 0.0);
  EXPECT_EQ(judge(runaway).outcome, Outcome::diverges);
  EXPECT_NE(judge(ramp).outcome, Outcome::diverges);
  EXPECT_NE(judge(ramp).outcome, Outcome::limit_cycle) << "nothing goes round";
  EXPECT_EQ(judge(terminal).outcome, Outcome::settles);
  // Any part of a decaying swing that is shorter than a cycle of 250 samples.
  for (const int count : {60, 100, 150, 200}) {
    EXPECT_NE(judge(oscillate(4, -10, count)).outcome, Outcome::diverges) << count;
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

// Velocity and height of a ball under 1 g whose bounces leave with `factor` times the speed.
Motion bounce(double factor, double seconds) {
  Motion m;
  double height = 0;
  double v = 1;
  for (int k = 0; k < seconds / T; ++k) {
    v -= 9.81 * T;
    height += v * T;
    if (height < 0 && v < 0) v *= -factor;
    m.velocity.push_back(v);
    m.position.push_back(height);
  }
  return m;
}

TEST(Classification, a_ball_that_flies_for_most_of_the_run_does_not_rest) {
  EXPECT_EQ(judge(bounce(4, 1.5)).outcome, Outcome::diverges);  // flights of 0.2, 0.8, 3.3 s
  EXPECT_EQ(judge(bounce(2, 4)).outcome, Outcome::diverges);
  EXPECT_EQ(judge(bounce(1, 1.5)).outcome, Outcome::limit_cycle);
  EXPECT_EQ(judge(bounce(0.9, 1.5)).outcome, Outcome::settles);
}

TEST(Classification, a_swing_that_is_measured_unevenly_is_averaged) {
  // The last cycle alone is 6 % smaller than the first of the window.
  Motion m = oscillate(10, 0, 3000);
  for (std::size_t i = 2880; i < m.velocity.size(); ++i) m.velocity[i] *= 0.94;
  EXPECT_EQ(judge(m).outcome, Outcome::limit_cycle);
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
