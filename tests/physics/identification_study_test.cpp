#include "support/identification_study.hpp"

#include <gtest/gtest.h>

// Twelve hidden motors on each bench; bench/identification_study has fifty and more.

namespace gyrator {
namespace {

constexpr int devices = 12;

void expect_honest_and_close(const IdentificationStudy& study) {
  int cases = 0, covered = 0;
  for (const auto& [name, s] : study.scores) {
    // Two of twelve outside of 99 % intervals happen in 0.6 % of all studies.
    EXPECT_GE(s.covered, devices - 1) << name;
    EXPECT_EQ(s.identifiable, devices) << name;
    cases += s.cases;
    covered += s.covered;
    const bool is_friction = name == "damping" || name == "coulomb_friction";
    EXPECT_LT(find_median(s.errors), is_friction ? 0.10 : 0.02) << name;
    // Honest, and not by being wide.
    EXPECT_LT(find_median(s.widths), is_friction ? 0.20 : 0.04) << name;
  }
  EXPECT_GE(covered, 0.95 * cases) << describe(study);
  EXPECT_LT(study.longest, 40);
}

TEST(IdentificationStudy, HiddenMotorsAreFoundWithinTheirIntervals) {
  const IdentificationStudy study = run_identification_study(StudyBench::own, devices, 1);
  expect_honest_and_close(study);
  EXPECT_LT(study.worst_current, 0.35);
  EXPECT_LT(study.worst_voltage, 1);
}

TEST(IdentificationStudy, HiddenTwinsAreFoundWithinTheirIntervals) {
  expect_honest_and_close(run_identification_study(StudyBench::twin, devices, 2));
}

}  // namespace
}  // namespace gyrator
