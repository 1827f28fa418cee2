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

// H(-1) of the tool at Nyquist and b > T/2 H(-1), with b_w = K T/2 + B, give (mass-1) and (mass-2):
//   semi-implicit  m > T/2 (b_w b/(b - b_w) + K_e T/2 + B_e)
//   explicit       m > T/2 (B - K T/2) b/(b - b_w), where it holds at all
constexpr double search = 1e-4;  // the search ends at 1e-5 of the mass

TEST(MinimumMass, of_a_semi_implicit_tool_is_what_the_loop_allows_at_nyquist) {
  const SpringDamper wall{2000, 1};
  for (const SpringDamper& c :
       {SpringDamper{300, 0.2}, SpringDamper{300, 0.5}, SpringDamper{20, 0.6}}) {
    const double b_w = c.stiffness * T / 2 + c.damping;
    const double free = T / 2 * b_w * b / (b - b_w);
    PassivityModel model = make_model(c);
    EXPECT_NEAR(find_minimum_mass(model, Integration::semi_implicit).value() / free, 1, search);
    std::get<VirtualCoupling>(model.controller.law).wall = ToolWall{wall, 0, true};
    const double touching = free + T / 2 * (wall.stiffness * T / 2 + wall.damping);
    EXPECT_NEAR(find_minimum_mass(model, Integration::semi_implicit).value() / touching, 1, search);
  }
}

TEST(MinimumMass, of_a_semi_implicit_tool_is_larger_where_the_coupling_is_hardly_damped) {
  // B = 0.1 K T: another frequency than Nyquist binds.
  const double b_w = 1000 * T / 2 + 0.1;
  const auto found = find_minimum_mass(make_model({1000, 0.1}), Integration::semi_implicit);
  EXPECT_GT(found.value(), 1.5 * T / 2 * b_w * b / (b - b_w));
}

TEST(MinimumMass, of_an_explicit_tool_exists_only_where_damping_outweighs_the_scheme) {
  // Explicit Euler feeds the tool's swing by K T against B: below B = K T no mass is passive.
  const auto mass = [](double damping) {
    return find_minimum_mass(make_model({300, damping}), Integration::explicit_euler);
  };
  EXPECT_FALSE(mass(0.29).has_value());
  for (const double B : {0.32, 0.5}) {
    const double b_w = 300 * T / 2 + B;
    EXPECT_NEAR(mass(B).value() / (T / 2 * (B - 300 * T / 2) * b / (b - b_w)), 1, search) << B;
  }
}

TEST(MinimumMass, an_implicit_tool_may_have_any) {
  for (const double B : {0.0, 0.2, 0.5})
    EXPECT_EQ(find_minimum_mass(make_model({300, B}), Integration::implicit), 0.0);
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
