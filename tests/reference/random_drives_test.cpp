// The exact disk on random devices of every linear kind of damping: safe below its limit, tight
// above.

#include "random_drives.hpp"

#include <cstdlib>

#include <gtest/gtest.h>

namespace gyrator {
namespace {

using namespace reference;

constexpr std::uint64_t seed = 7;

int devices_per_kind() {
  const char* asked = std::getenv("GYRATOR_RANDOM_DEVICES");
  return asked ? std::atoi(asked) : 10;
}

struct Tally {
  int devices = 0, infeasible = 0, found = 0, close = 0, textbook_unsafe = 0;
};

Tally study(const DampingKind& kind) {
  Random random(seed + 1);
  Tally tally;
  const RcCases drawn = draw_drive_cases(kind, devices_per_kind(), seed);
  tally.infeasible = drawn.infeasible;
  for (const RcCase& c : drawn.cases) {
    ++tally.devices;
    tally.textbook_unsafe += c.textbook > c.limit;
    std::vector<MassSpringDamper> operators = draw_operators(random, c, 40);
    const Verdict above = judge_passivity(c.model(1.03));
    EXPECT_FALSE(above.passive) << kind.name << ": " << c.describe();
    if (!above.counterexample) {
      std::printf("%s, no counterexample: %s\n", kind.name.c_str(), c.describe().c_str());
    } else {
      ++tally.found;
      EXPECT_EQ(above.counterexample->held_by.damping, 0);
      EXPECT_GT(find_radius(c, 1.03, above.counterexample->held_by), 1)
          << kind.name << ": " << c.describe();
      operators.push_back(above.counterexample->held_by);
    }
    EXPECT_TRUE(judge_passivity(c.model(0.97), false).passive) << kind.name << ": " << c.describe();
    double largest = 0;
    for (const MassSpringDamper& held_by : operators)
      largest = std::max(largest, find_radius(c, 0.97, held_by));
    // Eigenvalues are known to 1e-9 (stability_tolerance).
    EXPECT_LE(largest, 1 + stability_tolerance) << kind.name << ": " << c.describe();
    tally.close += largest > 1 - 1e-3;
  }
  return tally;
}

// Measured on 60 devices of each kind: none broken below, and a counterexample at 1.03 for all but
// two with a high-pass damper, which bind so slowly that rounding hides the growth. The textbook
// allows too much on 250.
TEST(RandomDrives, are_broken_by_no_operator_below_their_limit_and_by_a_lossless_one_above) {
  Tally all;
  for (const DampingKind& kind : make_damping_kinds()) {
    const Tally t = study(kind);
    std::printf(
        "%s: %d devices, %d more without a limit; counterexamples for %d; close %d; the "
        "textbook allows too much on %d\n",
        kind.name.c_str(), t.devices, t.infeasible, t.found, t.close, t.textbook_unsafe);
    EXPECT_EQ(t.devices, devices_per_kind()) << kind.name;
    EXPECT_GE(t.found, 0.8 * t.devices) << kind.name;
    // The operators tried do come close.
    EXPECT_GT(t.close, 0.5 * t.devices) << kind.name;
    all.devices += t.devices;
    all.found += t.found;
    all.textbook_unsafe += t.textbook_unsafe;
  }
  EXPECT_GE(all.found, 0.95 * all.devices);
  // [8.46] knows neither the lag of the command path nor what the aliases do.
  EXPECT_GT(all.textbook_unsafe, 0.3 * all.devices);
}

}  // namespace
}  // namespace gyrator
