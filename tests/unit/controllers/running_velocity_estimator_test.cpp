#include "gyrator/controllers/running_velocity_estimator.hpp"

#include "gyrator/controllers/controller.hpp"
#include "gyrator/core/error.hpp"

#include <cmath>
#include <random>
#include <vector>

#include <gtest/gtest.h>

// One contract for every estimator of the list.

namespace gyrator {
namespace {

constexpr double T = 1e-3;
constexpr double rounding = 1e-9;  // of velocities of about 1e3, from positions of about one

std::vector<VelocityEstimator> make_estimators() {
  return {DifferenceEstimator{1},
          DifferenceEstimator{9},
          FilteredDifferenceEstimator{80},
          ButterworthEstimator{1, 30},
          ButterworthEstimator{8, 120},
          AdaptiveWindowEstimator{1e-3, 16, WindowFit::end},
          AdaptiveWindowEstimator{1e-3, 16, WindowFit::best},
          LevantEstimator{200}};
}

std::vector<double> make_motion(std::size_t count) {
  std::mt19937 random(5);
  std::uniform_real_distribution<double> jump(-0.01, 0.01);
  std::vector<double> y{0.3};
  while (y.size() < count) y.push_back(y.back() + jump(random));
  return y;
}

TEST(RunningVelocityEstimator, takes_the_first_position_as_a_rest) {
  for (const VelocityEstimator& estimator : make_estimators()) {
    RunningVelocityEstimator run(estimator, T);
    for (int k = 0; k < 40; ++k) EXPECT_NEAR(run.step(-3.5), 0, rounding) << name_of(estimator);
  }
}

TEST(RunningVelocityEstimator, starts_as_if_the_first_position_had_been_there_for_ever) {
  const std::vector<double> motion = make_motion(60);
  for (const VelocityEstimator& estimator : make_estimators()) {
    RunningVelocityEstimator fresh(estimator, T), waited(estimator, T);
    for (int k = 0; k < 50; ++k) waited.step(motion.front());
    for (const double y : motion)
      ASSERT_NEAR(fresh.step(y), waited.step(y), rounding) << name_of(estimator);
  }
}

TEST(RunningVelocityEstimator, runs_the_law_of_every_linear_estimator) {
  const std::vector<double> motion = make_motion(300);
  for (const VelocityEstimator& estimator : make_estimators()) {
    const auto law = find_velocity_law(estimator, T);
    if (!law) continue;
    RunningVelocityEstimator run(estimator, T);
    DiscreteLawState state(*law);
    state.settle(*law, motion.front());
    for (const double y : motion)
      ASSERT_NEAR(run.step(y), state.step(*law, y), rounding) << name_of(estimator);
  }
}

TEST(RunningVelocityEstimator, does_not_depend_on_where_zero_is) {
  const std::vector<double> motion = make_motion(200);
  for (const VelocityEstimator& estimator : make_estimators()) {
    RunningVelocityEstimator here(estimator, T), there(estimator, T);
    // By a power of two, so that little rounding is added to the positions.
    for (const double y : motion)
      ASSERT_NEAR(here.step(y), there.step(y + 8), 1e3 * rounding) << name_of(estimator);
  }
}

TEST(RunningVelocityEstimator, converges_on_a_ramp) {
  for (const VelocityEstimator& estimator : make_estimators()) {
    RunningVelocityEstimator run(estimator, T);
    double v = 0;
    for (int k = 0; k < 600; ++k) v = run.step(0.8 * k * T);
    const auto* levant = std::get_if<LevantEstimator>(&estimator);
    EXPECT_NEAR(v, 0.8, levant ? 4 * levant->acceleration_bound * T : rounding)
        << name_of(estimator);
  }
}

TEST(RunningVelocityEstimator, refuses_what_its_configuration_cannot_be) {
  EXPECT_THROW(RunningVelocityEstimator(DifferenceEstimator{0}, T), Error);
  EXPECT_THROW(RunningVelocityEstimator(ButterworthEstimator{2, 500}, T), Error);
  EXPECT_THROW(RunningVelocityEstimator(AdaptiveWindowEstimator{0, 4, WindowFit::end}, T), Error);
  EXPECT_THROW(RunningVelocityEstimator(LevantEstimator{-1}, T), Error);
}

TEST(UnilateralWall, steps_with_every_estimator) {
  for (const VelocityEstimator& estimator : make_estimators()) {
    const VirtualWall wall{
        .stiffness = 400, .damping = 1.5, .velocity = estimator, .unilateral = true};
    VirtualWallController running(wall, T);
    RunningVelocityEstimator velocity(estimator, T);
    for (int k = 0; k < 500; ++k) {
      const double y = -0.01 + 0.03 * std::sin(0.02 * k);
      const double v = velocity.step(y);  // from outside too
      const double command = running.step(y);
      const double expected = y > 0 ? -(400 * y + 1.5 * v) : 0;
      ASSERT_NEAR(command, expected, rounding) << name_of(estimator) << " at " << y;
    }
  }
}

TEST(Controller, a_wall_with_an_estimator_that_is_not_linear_has_no_linear_law) {
  for (const VelocityEstimator& estimator : make_estimators()) {
    const VirtualWall wall{.stiffness = 400, .damping = 1.5, .velocity = estimator};
    const bool linear = find_velocity_law(estimator, T).has_value();
    EXPECT_EQ(find_linear_law(wall, T).has_value(), linear) << name_of(estimator);
    if (linear) continue;
    EXPECT_THROW(make_contact_law(wall, T), Error) << name_of(estimator);
  }
}

}  // namespace
}  // namespace gyrator
