#include "gyrator/passivity/minimum_mass.hpp"

#include "gyrator/core/error.hpp"

#include <gtest/gtest.h>

namespace gyrator {
namespace {

constexpr double T = 1e-3, m = 0.04, b = 0.8;  // P3

PassivityModel make_model(const SpringDamper& coupling) {
  PassivityModel model;
  model.device.motion = Motion::linear;
  model.device.mechanics.inertia = m;
  model.device.mechanics.damping = b;
  VirtualCoupling law;
  law.coupling = coupling;
  model.controller = law;
  return model;
}

TEST(MinimumMass, of_a_semi_implicit_tool_is_what_the_loop_allows_at_nyquist) {
  // H(-1) = (K + 2 B/T)/(1 - (K T/2 + B) T/(2 m)) and b > T/2 H(-1) give (mass-1),
  //   m > T/2 b_w b/(b - b_w),   b_w = K T/2 + B.
  for (const SpringDamper& c :
       {SpringDamper{300, 0.2}, SpringDamper{1000, 0.1}, SpringDamper{20, 0.6}}) {
    const double wall = c.stiffness * T / 2 + c.damping;
    const auto found = find_minimum_mass(make_model(c), Integration::semi_implicit);
    ASSERT_TRUE(found.has_value());
    EXPECT_NEAR(*found / (T / 2 * wall * b / (b - wall)), 1, 1e-4);  // the search: 1e-5
  }
}

TEST(MinimumMass, decides_the_verdict_from_both_sides) {
  PassivityModel model = make_model({300, 0.2});
  auto& law = std::get<VirtualCoupling>(model.controller.law);
  law.wall = ToolWall{{2000, 1}, 0, true};
  const double smallest = find_minimum_mass(model, Integration::semi_implicit).value();
  law.tool_inertia = 1.01 * smallest;
  EXPECT_TRUE(judge_passivity(model, false).passive);
  law.tool_inertia = 0.99 * smallest;
  EXPECT_FALSE(judge_passivity(model, false).passive);
}

TEST(MinimumMass, explicit_needs_the_largest_and_implicit_none) {
  // Explicit Euler pumps the tool's own swing, by K T against B: below B = K T no mass is passive.
  const auto mass = [](double damping, Integration integration) {
    return find_minimum_mass(make_model({300, damping}), integration);
  };
  EXPECT_FALSE(mass(0.29, Integration::explicit_euler).has_value());
  const auto heavy = mass(0.5, Integration::explicit_euler);
  const auto middle = mass(0.5, Integration::semi_implicit);
  ASSERT_TRUE(heavy && middle);
  EXPECT_GT(*heavy, 1.5 * *middle);
  EXPECT_EQ(mass(0.5, Integration::implicit), 0.0);
  EXPECT_EQ(mass(0.2, Integration::implicit), 0.0);
}

TEST(MinimumMass, a_coupling_that_would_not_be_passive_as_a_wall_has_none) {
  for (const Integration integration :
       {Integration::explicit_euler, Integration::semi_implicit, Integration::implicit}) {
    EXPECT_FALSE(find_minimum_mass(make_model({300, 0.7}), integration).has_value());  // b_w 0.85
  }
}

TEST(MinimumMass, a_free_tool_counts_behind_a_unilateral_wall) {
  // Explicit: in contact with a damping wall all is well, free the tool's swing grows.
  PassivityModel model = make_model({300, 0.2});
  auto& law = std::get<VirtualCoupling>(model.controller.law);
  law.integration = Integration::explicit_euler;
  law.tool_inertia = 0.05;
  law.wall = ToolWall{{100, 2}, 0, false};
  EXPECT_TRUE(judge_passivity(model, false).passive);
  law.wall->unilateral = true;
  const Verdict verdict = judge_passivity(model, false);
  EXPECT_FALSE(verdict.passive);
  EXPECT_NE(verdict.explanation.find("away from its wall"), std::string::npos);
}

TEST(MinimumMass, is_refused_where_there_is_no_tool_or_no_law) {
  PassivityModel model = make_model({300, 0.2});
  std::get<VirtualCoupling>(model.controller.law).update.period = Rational(1, 60);
  EXPECT_THROW(find_minimum_mass(model, Integration::implicit), Error);
  EXPECT_THROW(judge_passivity(model, false), Error);
  model.controller = VirtualWall{};
  EXPECT_THROW(find_minimum_mass(model, Integration::implicit), Error);
}

}  // namespace
}  // namespace gyrator
