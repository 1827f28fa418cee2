#include "gyrator/passivity/verdict.hpp"

#include <gtest/gtest.h>

#include "support/passivity_closed_forms.hpp"

namespace gyrator {
namespace {

using namespace passivity_tests;

struct Broken {
  std::string name;
  RcParameters parameters;
  Sampling sampling;
  VirtualWall wall;
};

std::vector<Broken> make_broken() {
  const Rational T(1, 1000);
  RcParameters nimble;  // its disk is exceeded in between, at a quarter of Nyquist
  nimble.J = 4e-6;
  nimble.b = 3e-4;
  nimble.R_1 = 12;
  nimble.C = 2e-5;
  const Rational late(13, 10000);
  return {{"low frequency", {}, {T, 0}, {0.2, 1.5e-4}},
          {"low frequency, late", {}, {T, Rational(7, 10000)}, {0.1, 1e-4}},
          {"Nyquist", nimble, {T, 0}, {0.1, 4e-4}},
          {"in between", nimble, {T, late}, {0.215, 2e-4}},
          {"in between, unstable alone", nimble, {T, late}, {0.45, 2.5e-4}}};
}

Verdict judge(const Broken& broken, double more_damping) {
  RcParameters p = broken.parameters;
  p.b += more_damping;
  return judge_passivity({make_rc_motor(p).device, broken.wall, broken.sampling, 0}, false);
}

TEST(ExtraDamping, added_to_the_mechanics_mends_the_loop_and_two_percent_less_does_not) {
  for (const Broken& broken : make_broken()) {
    const Verdict verdict = judge(broken, 0);
    ASSERT_FALSE(verdict.passive) << broken.name;
    ASSERT_TRUE(verdict.extra_damping.has_value()) << broken.name;
    // Found to 1e-5 of itself.
    EXPECT_TRUE(judge(broken, *verdict.extra_damping * (1 + 1e-5)).passive) << broken.name;
    EXPECT_FALSE(judge(broken, *verdict.extra_damping * 0.98).passive) << broken.name;
  }
}

TEST(ExtraDamping, is_the_missing_margin_itself_for_a_constant_damping) {
  // D = b + b_v: what is missing at the worst frequency is what has to be added.
  for (const VirtualWall wall :
       {VirtualWall{2000, 0}, VirtualWall{1000, 0.9}, VirtualWall{100, -1.2}}) {
    const Verdict verdict = judge_passivity({make_p3().device, wall, {}, 0}, false);
    const double missing = wall.stiffness * 0.5e-3 + std::abs(wall.damping) - 0.8;
    ASSERT_GT(missing, 0);
    ASSERT_TRUE(verdict.extra_damping.has_value());
    // Never less, and as much more as the proof between the points cannot tell: some 1e-6 of D's
    // terms, which are of the size of what is missing and what is there.
    EXPECT_GE(*verdict.extra_damping, missing * (1 - 1e-9));
    EXPECT_LE(*verdict.extra_damping, missing * (1 + 1e-5) + 1e-5 * (missing + 0.8));
  }
}

TEST(ExtraDamping, is_left_out_where_no_damper_at_the_port_can_mend) {
  // Sensor at the motor behind a spring: with the port held fast the motor still swings on it, and
  // this wall alone makes that unstable.
  const Device device =
      make_compliant(0.04, 0.01, {2e4, 0.001, 0.02}, SensorLocation::motor).device;
  const Verdict verdict = judge_passivity({device, VirtualWall{4000, 0}, {}, 0}, false);
  EXPECT_FALSE(verdict.passive);
  EXPECT_FALSE(verdict.extra_damping.has_value()) << *verdict.extra_damping;
}

// A tool behind a unilateral wall is judged in contact first; with more damping it must be passive
// away from the wall, too. Each of the two is the verdict of a loop of its own.
TEST(ExtraDamping, of_a_tool_at_a_wall_that_it_may_leave_mends_it_in_contact_and_free) {
  const auto judge_with = [](VirtualCoupling coupling, double more) {
    return judge_passivity({make_point_mass(0.04, 0.8 + more).device, coupling, {}, 0}, false);
  };
  const auto make_coupling = [](SpringDamper coupling, double mass, SpringDamper wall) {
    VirtualCoupling made;
    made.coupling = coupling;
    made.tool_inertia = mass;
    made.wall.emplace().law = wall;
    return made;
  };
  int free_needs_more = 0;
  for (VirtualCoupling coupling : {make_coupling({1900, 0.12}, 0.015, {34, 0.26}),
                                   make_coupling({280, 1.9}, 0.003, {1.9, 2})}) {
    const Verdict contact = judge_with(coupling, 0);
    VirtualCoupling tool = coupling;
    tool.wall.reset();
    const Verdict free = judge_with(tool, 0);
    ASSERT_FALSE(contact.passive);
    ASSERT_TRUE(contact.extra_damping && free.extra_damping);
    coupling.wall->unilateral = true;
    const Verdict verdict = judge_with(coupling, 0);
    ASSERT_TRUE(verdict.extra_damping.has_value());
    EXPECT_EQ(*verdict.extra_damping, std::max(*contact.extra_damping, *free.extra_damping));
    EXPECT_TRUE(judge_with(coupling, *verdict.extra_damping * (1 + 1e-5)).passive);
    EXPECT_FALSE(judge_with(coupling, *verdict.extra_damping * 0.98).passive);
    free_needs_more += *free.extra_damping > 1.1 * *contact.extra_damping ? 1 : 0;
  }
  EXPECT_EQ(free_needs_more, 1) << "either of the two may decide";
}

}  // namespace
}  // namespace gyrator
