#include "gyrator/controllers/linear_motion.hpp"

#include <cmath>
#include <vector>

#include <gtest/gtest.h>

namespace gyrator {
namespace {

struct Case {
  double m, c, k, w;
};
// Free, damped, spring, under-, critically and overdamped, each with an effort.
const std::vector<Case> cases{{0.3, 0, 0, 2},  {0.3, 4, 0, 2},  {0.3, 0, 500, 2}, {0.3, 4, 500, -2},
                              {0.25, 2, 4, 1}, {0.3, 90, 5, 2}, {0.3, 1e-6, 0, 2}};

TEST(LinearMotion, obeys_its_equation_of_motion) {
  // Central differences over h err by h^2/6 of the third derivative: of the fastest case, 300/s,
  // h^2/6 x 0.7 x 300^2 = 1.05e-6 m/s, and 300/s x m of that in the balance of forces.
  const double h = 1e-5;
  for (const Case& p : cases) {
    const LinearMotion motion(p.m, p.c, p.k, p.w);
    const MotionState start{0.02, -0.7};
    for (const double t : {1e-4, 3e-3, 0.05, 0.4}) {
      const MotionState before = motion.after(start, t - h);
      const MotionState now = motion.after(start, t);
      const MotionState next = motion.after(start, t + h);
      const double a = (next.velocity - before.velocity) / (2 * h);
      EXPECT_NEAR((next.position - before.position) / (2 * h), now.velocity, 2e-6);
      EXPECT_NEAR(p.m * a + p.c * now.velocity + p.k * now.position, p.w, 2e-4)
          << p.c << " " << p.k << " at " << t;
    }
  }
}

TEST(LinearMotion, goes_on_from_where_it_is) {
  // Two steps are one of their sum, on both sides of where the series for short times takes over.
  for (const Case& p : cases) {
    const LinearMotion motion(p.m, p.c, p.k, p.w);
    for (const double t : {1e-7, 1e-3, 9e-3, 0.3}) {
      const MotionState start{0.02, -0.7};
      const MotionState whole = motion.after(start, 3 * t);
      const MotionState parts = motion.after(motion.after(start, t), 2 * t);
      EXPECT_NEAR(whole.position, parts.position, 1e-14) << p.c << " " << p.k << " " << t;
      EXPECT_NEAR(whole.velocity, parts.velocity, 1e-12) << p.c << " " << p.k << " " << t;
    }
  }
}

TEST(LinearMotion, finds_when_a_thrown_ball_lands) {
  const LinearMotion motion(0.5, 0, 0, 5);  // 10 m/s^2 towards the surface
  const double v = 3;                       // up: 0.45 m at 0.3 s
  const auto landing = motion.find_crossing({-0.35, -v}, 2, false);
  ASSERT_TRUE(landing);
  EXPECT_NEAR(*landing, 0.3 + std::sqrt(2 * 0.8 / 10), 1e-14);
  EXPECT_FALSE(motion.find_crossing({-0.35, -v}, 0.69, false));
  // From the surface itself: thrown up it comes back, thrown down it is inside at once.
  EXPECT_NEAR(*motion.find_crossing({0, -v}, 2, false), 0.6, 1e-14);
  EXPECT_EQ(*motion.find_crossing({0, v}, 2, false), 0);
}

TEST(LinearMotion, finds_a_surface_that_is_only_grazed) {
  // Up through the surface by 1 um and back within one look ahead.
  const LinearMotion motion(0.5, 0, 0, -5);
  const double v = 0.1;
  const double height = v * v / 20;
  const auto crossing = motion.find_crossing({1e-6 - height, v}, 0.1, false);
  ASSERT_TRUE(crossing);
  EXPECT_NEAR(*crossing, 0.01 - std::sqrt(2e-6 / 10), 1e-12);
  EXPECT_FALSE(motion.find_crossing({-1e-6 - height, v}, 0.1, false));
}

TEST(LinearMotion, finds_the_end_of_a_contact_however_far_ahead) {
  const double m = 0.2, k = 2000, w = std::sqrt(k / m);
  const LinearMotion motion(m, 0, k, 0);
  for (const double horizon : {0.04, 0.1, 1.0})
    EXPECT_NEAR(*motion.find_crossing({0, 0.5}, horizon, true), 3.14159265358979 / w, 1e-14);
  EXPECT_FALSE(motion.find_crossing({0, 0.5}, 0.031, true));
}

}  // namespace
}  // namespace gyrator
