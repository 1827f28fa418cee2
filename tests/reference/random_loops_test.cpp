// The exact disk on random loops of every linear kind of drive, both sensor places, filters,
// estimators and delays: passive just below its limit and not just above. The long version, with a
// table, is bench/random_loop_study.

#include "random_loops.hpp"

#include <cstdlib>

#include <gtest/gtest.h>

namespace gyrator {
namespace {

using namespace reference;

constexpr std::uint64_t first_seed = 3'000'000;

int loops_per_kind() {
  const char* asked = std::getenv("GYRATOR_RANDOM_LOOPS");
  return asked ? std::atoi(asked) : 2;
}

class RandomLoopsOfKind : public ::testing::TestWithParam<std::size_t> {
 protected:
  RandomLoops loops_ = draw_loops(make_loop_kinds()[GetParam()], loops_per_kind(), first_seed);
};

TEST_P(RandomLoopsOfKind, are_passive_at_99_percent_of_their_limit_and_not_at_101) {
  ASSERT_EQ(static_cast<int>(loops_.loops.size()), loops_per_kind());
  for (const RandomLoop& loop : loops_.loops) {
    EXPECT_TRUE(judge_passivity(loop.model(0.99), false).passive) << loop.describe();
    EXPECT_FALSE(judge_passivity(loop.model(1.01), false).passive) << loop.describe();
  }
}

TEST_P(RandomLoopsOfKind, are_broken_by_an_operator_above_their_limit_and_by_none_below) {
  for (const RandomLoop& loop : loops_.loops) {
    const Verdict above = judge_passivity(loop.model(1.03));
    std::optional<MassSpringDamper> example;
    if (above.counterexample) {
      example = above.counterexample->held_by;
      EXPECT_GT(above.counterexample->spectral_radius, 1) << loop.describe();
      // The loop put together once more.
      EXPECT_GT(loop.spectral_radius(1.03, *example), 1) << loop.describe();
    } else if (loop.kind != "wave line") {  // whose K hardly changes |Gamma|
      // Most are found at once, the rest further above the limit.
      EXPECT_TRUE(judge_passivity(loop.model(1.5)).counterexample) << loop.describe();
    }
    Random random(loop.seed + 1);
    std::vector<MassSpringDamper> operators = draw_passive_operators(random, loop, 30, example);
    if (example) operators.push_back(*example);
    for (const MassSpringDamper& held_by : operators)
      EXPECT_LE(loop.spectral_radius(0.99, held_by), 1 + stability_tolerance) << loop.describe();
  }
}

// Dips of the law's own between the grid's frequencies, and limits too close to call there.
TEST(RandomLoop, has_a_proved_limit_below_what_the_grid_alone_shows) {
  struct Known {
    std::string kind;
    std::uint64_t seed;
    double least_overestimate;  // of the limit on the grid
  };
  for (const Known& known :
       {Known{"wave line", 1001024, 1.05}, Known{"wave line", 1000679, 1.01},
        Known{"wave line", 1001025, 1.01}, Known{"rc", 1000091, 1}, Known{"voltage", 1000058, 1}}) {
    const auto kinds = make_loop_kinds();
    const auto kind = std::find_if(kinds.begin(), kinds.end(),
                                   [&](const DampingKind& k) { return k.name == known.kind; });
    ASSERT_NE(kind, kinds.end()) << known.kind;
    const auto loop = draw_loop(*kind, known.seed);
    ASSERT_TRUE(loop) << known.seed;
    StiffnessLimits limits(loop->device, loop->sampling, loop->controller, FreeOperator{});
    EXPECT_GE(limits.find_on_grid(loop->virtual_damping).stiffness,
              known.least_overestimate * loop->limit)
        << loop->describe();
    EXPECT_TRUE(judge_passivity(loop->model(0.99), false).passive) << loop->describe();
    EXPECT_FALSE(judge_passivity(loop->model(1.01), false).passive) << loop->describe();
  }
}

INSTANTIATE_TEST_SUITE_P(Kinds, RandomLoopsOfKind,
                         ::testing::Range<std::size_t>(0, make_loop_kinds().size()),
                         [](const auto& kind) {
                           std::string name = make_loop_kinds()[kind.param].name;
                           std::replace(name.begin(), name.end(), ' ', '_');
                           return name;
                         });

}  // namespace
}  // namespace gyrator
