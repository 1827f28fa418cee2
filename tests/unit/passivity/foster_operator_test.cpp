#include "gyrator/passivity/foster_operator.hpp"

#include <gtest/gtest.h>

#include "support/passivity_closed_forms.hpp"

namespace gyrator {
namespace {

using namespace passivity_tests;

double find_reactance(const MassSpringDamper& held_by, double omega) {
  double reactance = held_by.inertia * omega - held_by.stiffness / omega;
  for (const auto& [inertia, stiffness] : held_by.resonators) {
    reactance += stiffness * omega / (stiffness / inertia - omega * omega);
  }
  return reactance;
}

std::vector<WantedReactance> draw_wanted(Random& random, int count) {
  std::vector<WantedReactance> wanted;
  const double base = random.uniform(0.05, 0.45);  // of the sampling frequency, as aliases lie
  for (int i = 0; i < count; ++i) {
    const int alias = i % 2 == 0 ? i / 2 : -(i + 1) / 2;
    wanted.push_back(
        {std::abs(base + alias) * 6283, random.uniform(-1, 1) * random.log_uniform(1e-2, 1e2)});
  }
  return wanted;
}

TEST(FosterOperator, has_every_wanted_reactance_and_is_lossless) {
  Random random(21);
  for (int i = 0; i < 300; ++i) {
    const auto wanted = draw_wanted(random, 1 + i % 17);
    for (const double nearness : {0.45, 0.1}) {
      for (const double both : {0.0, 1.0}) {
        const auto held_by = interpolate_reactances(wanted, nearness, both);
        ASSERT_TRUE(held_by.has_value()) << i;
        EXPECT_EQ(held_by->damping, 0);
        EXPECT_GE(held_by->inertia, 0);
        EXPECT_GE(held_by->stiffness, 0);
        for (const auto& resonator : held_by->resonators) {
          EXPECT_GT(resonator.inertia, 0);
          EXPECT_GT(resonator.stiffness, 0);
        }
        double largest = 0;
        for (const auto& point : wanted) largest = std::max(largest, std::abs(point.reactance));
        for (const auto& point : wanted) {
          // The equations' condition grows with the nearness that was needed, to 1e5 at most.
          EXPECT_NEAR(find_reactance(*held_by, point.omega), point.reactance, 1e-9 * largest) << i;
        }
      }
    }
  }
}

TEST(FosterOperator, is_an_inertia_or_a_spring_for_a_single_reactance) {
  const auto inertia = interpolate_reactances({{100, 5}}, 0.45, 0);
  ASSERT_TRUE(inertia.has_value());
  EXPECT_DOUBLE_EQ(inertia->inertia, 0.05);
  EXPECT_EQ(inertia->stiffness, 0);
  const auto spring = interpolate_reactances({{100, -5}}, 0.45, 0);
  ASSERT_TRUE(spring.has_value());
  EXPECT_EQ(spring->inertia, 0);
  EXPECT_DOUBLE_EQ(spring->stiffness, 500);
}

TEST(FosterOperator, is_none_for_a_reactance_without_bound) {
  EXPECT_FALSE(interpolate_reactances({{100, INFINITY}}, 0.45, 0).has_value());
}

}  // namespace
}  // namespace gyrator
