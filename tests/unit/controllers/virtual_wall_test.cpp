#include "gyrator/controllers/virtual_wall.hpp"

#include "gyrator/controllers/controller.hpp"

#include <cmath>
#include <complex>
#include <numbers>
#include <vector>

#include <gtest/gtest.h>

namespace gyrator {
namespace {

using Complex = std::complex<double>;

constexpr double T = 1e-3;
constexpr double rounding = 1e-9;  // of efforts of about 1e3, from differences over 1 ms

std::vector<double> run(const Controller& controller, const std::vector<double>& positions) {
  RunningController running(controller, T);
  std::vector<double> commands;
  for (const double y : positions) commands.push_back(running.step(y));
  return commands;
}

void expect_near(const std::vector<double>& found, const std::vector<double>& expected) {
  ASSERT_EQ(found.size(), expected.size());
  for (std::size_t k = 0; k < found.size(); ++k) EXPECT_NEAR(found[k], expected[k], rounding) << k;
}

TEST(VirtualWall, opposes_with_spring_and_damper) {
  // -(K y + B (y[k] - y[k-1])/T), and no velocity at the first sample
  const VirtualWall wall{.stiffness = 1000, .damping = 2};
  expect_near(run(wall, {0.1, 0.1, 0.103, 0.05, -0.2}),
              {-100, -100, -(103.0 + 6), -(50.0 - 106), -(-200.0 - 500)});
}

TEST(VirtualWall, takes_the_first_sample_as_a_rest_with_every_estimator) {
  for (const VelocityEstimator& estimator :
       {VelocityEstimator{DifferenceEstimator{1}}, VelocityEstimator{DifferenceEstimator{7}},
        VelocityEstimator{FilteredDifferenceEstimator{30}}}) {
    const VirtualWall wall{.stiffness = 10, .damping = 5, .velocity = estimator};
    expect_near(run(wall, {0.7, 0.7, 0.7}), {-7, -7, -7});
  }
}

TEST(VirtualWall, runs_the_law_that_its_transfer_function_tells) {
  // H = K + B V(z), with V of the estimator; drive the running wall with a long sinusoid.
  const double K = 300, B = 0.8, tau = 1 / (2 * std::numbers::pi * 100), angle = 0.6;
  const VirtualWall wall{
      .stiffness = K, .damping = B, .velocity = FilteredDifferenceEstimator{100}};
  const Complex z = std::polar(1.0, angle);
  const Complex s = (z - 1.0) / (T * z);
  const Complex H = K + B * s / (tau * s + 1.0);
  EXPECT_LE(std::abs(make_wall_law(wall, T).response(z) - H), rounding);
  EXPECT_LE(std::abs(find_linear_law(wall, T)->response(z) - H), rounding);
  RunningController cosine(wall, T), sine(wall, T);
  for (int k = 0; k < 400; ++k) {
    const Complex y = std::polar(1.0, angle * k);
    const Complex command(cosine.step(y.real()), sine.step(y.imag()));
    if (k < 200) continue;  // 0.61^200 is left of the start
    ASSERT_LE(std::abs(command + H * y), rounding) << k;
  }
}

TEST(VirtualWall, unilateral_acts_inside_only_and_knows_the_velocity_when_it_is_entered) {
  const VirtualWall wall{.stiffness = 1000, .damping = 2, .unilateral = true};
  // Outside nothing; at the surface itself nothing; then v from outside counts at once.
  expect_near(run(wall, {-0.02, 0, 0.003, 0.004}), {0, 0, -(3.0 + 6), -(4.0 + 2)});
}

TEST(VirtualWall, unilateral_pulls_on_the_way_out_unless_told_not_to) {
  // From 5 mm to 1 mm in one sample: K y = 1, B v = -8.
  VirtualWall wall{.stiffness = 1000, .damping = 2, .unilateral = true};
  expect_near(run(wall, {0.005, 0.001, -0.003}), {-5, 7, 0});
  wall.no_pull = true;
  expect_near(run(wall, {0.005, 0.001, -0.003}), {-5, 0, 0});
  expect_near(run(wall, {0.005, 0.0045}), {-5, -(4.5 - 1)});  // less push is still a push
}

TEST(VirtualWall, no_pull_says_nothing_to_a_bilateral_wall) {
  const VirtualWall wall{.stiffness = 1000, .no_pull = true};
  expect_near(run(wall, {0.002, -0.003}), {-2, 3});
}

TEST(Controller, none_commands_nothing) {
  expect_near(run(NoController{}, {1, 2}), {0, 0});
  EXPECT_EQ(find_linear_law(NoController{}, T)->response(1), 0.0);
}

TEST(Controller, a_unilateral_wall_has_no_linear_law_but_one_in_contact) {
  VirtualWall wall{.stiffness = 70, .damping = 1, .unilateral = true};
  EXPECT_FALSE(find_linear_law(wall, T).has_value());
  const Complex z = std::polar(1.0, 0.2);
  EXPECT_EQ(make_contact_law(wall, T).response(z), make_wall_law(wall, T).response(z));
  wall.unilateral = false;
  EXPECT_TRUE(find_linear_law(wall, T).has_value());
}

}  // namespace
}  // namespace gyrator
