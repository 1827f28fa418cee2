// The exact disk on random RC-damped devices: safe below its limit, tight above, and the
// counterexamples' runs diverge. Every kind of drive: bench/random_loop_study.

#include "random_rc.hpp"

#include <gtest/gtest.h>

namespace gyrator {
namespace {

using namespace reference;

constexpr int devices = 25;
constexpr std::uint64_t seed = 2024;

TEST(RandomRcDevices, no_passive_operator_breaks_a_loop_at_97_percent_of_the_limit) {
  Random random(seed + 1);
  int close = 0;
  for (const RcCase& c : draw_cases(devices, seed).cases) {
    std::vector<MassSpringDamper> operators = draw_operators(random, c, 120);
    const Verdict above = judge_passivity(c.model(1.03));
    if (above.counterexample) operators.push_back(above.counterexample->held_by);
    double largest = 0;
    for (const MassSpringDamper& held_by : operators) {
      largest = std::max(largest, find_radius(c, 0.97, held_by));
    }
    // Eigenvalues are known to 1e-9 (stability_tolerance).
    EXPECT_LE(largest, 1 + stability_tolerance) << c.describe();
    close += largest > 1 - 1e-3;
  }
  // The operators tried do come close.
  EXPECT_GT(close, devices / 2);
}

TEST(RandomRcDevices, a_lossless_operator_breaks_the_loop_at_103_percent_of_the_limit) {
  int found = 0;
  int run_out = 0;
  for (const RcCase& c : draw_cases(devices, seed).cases) {
    const Verdict above = judge_passivity(c.model(1.03));
    EXPECT_FALSE(above.passive) << c.describe();
    if (!above.counterexample) continue;
    ++found;
    EXPECT_EQ(above.counterexample->held_by.damping, 0);
    EXPECT_GT(find_radius(c, 1.03, above.counterexample->held_by), 1) << c.describe();
    // A quarter of a million samples: what grows more slowly is left to its eigenvalue.
    const RunResult outcome = run_counterexample(c, 1.03, *above.counterexample, 2.5e5);
    EXPECT_NE(outcome, RunResult::does_not_diverge) << c.describe();
    run_out += outcome == RunResult::diverges;
  }
  EXPECT_GE(found, 0.95 * devices);
  EXPECT_GE(run_out, devices / 2);
}

TEST(RandomRcDevices, are_mostly_allowed_too_much_by_the_textbook) {
  // [8.46] knows neither the lag of the command path nor what the aliases do.
  int unsafe = 0;
  for (const RcCase& c : draw_cases(devices, seed).cases) unsafe += c.textbook > c.limit;
  EXPECT_GT(unsafe, devices / 2);
}

}  // namespace
}  // namespace gyrator
