#include "gyrator/cosim/step_ladder.hpp"

#include "gyrator/circuits/state_space.hpp"
#include "gyrator/mechanics/plant.hpp"

#include <cmath>

#include <gtest/gtest.h>

#include "support/device_list.hpp"

namespace gyrator {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

// Some tens of roundings, in units in which the states are of one size.
constexpr double rounding = 1e-13;

// A display whose poles lie between 0 and 3000 rad/s, and its ledger.
struct Example {
  Plant plant = build_plant(build_device_network(testing::make_rc_display(), FreeOperator{}));
  MatrixXd rate;
  std::vector<MatrixXd> forms;
  VectorXd z;

  Example() : rate(plant.states(), plant.states() + 2), z(plant.states() + 2) {
    rate << plant.A, plant.B;
    forms = {plant.energy.operator_work, plant.energy.source, plant.energy.dissipated};
    z << plant.initial_state(0.01, 2), 3e-3, -1e-3;
    z.head(plant.states()) += VectorXd::LinSpaced(plant.states(), 1e-3, 2e-3);
  }
  VectorXd moved(double length) const {
    const HeldStep step = discretize_held(plant.A, plant.B, length);
    return step.phi * z.head(plant.states()) + step.gamma * z.tail(2);
  }
  StepLadder::Work work(double length) const {
    const auto integrals = integrate_quadratic_forms(plant.A, plant.B, forms, length);
    StepLadder::Work work{};
    for (std::size_t f = 0; f < 3; ++f) work[f] = z.dot(integrals[f] * z);
    return work;
  }
};

void expect_same(const VectorXd& found, const VectorXd& expected) {
  EXPECT_LE((found - expected).norm(), rounding * expected.norm());
}
void expect_same(const StepLadder::Work& found, const StepLadder::Work& expected) {
  const double largest = std::abs(expected[0]) + std::abs(expected[1]) + std::abs(expected[2]);
  for (std::size_t f = 0; f < 3; ++f) EXPECT_NEAR(found[f], expected[f], rounding * largest);
}

TEST(StepLadder, every_step_equals_the_matrix_exponential_and_its_work) {
  const Example e;
  const StepLadder ladder(e.rate, e.forms, 4e-3);
  ASSERT_GT(ladder.steps(), 4);
  EXPECT_LE(ladder.rate() * ladder.length(ladder.steps() - 1), 0.25);
  for (int step = 0; step < ladder.steps(); ++step) {
    EXPECT_EQ(ladder.length(step), std::ldexp(4e-3, -step));
    VectorXd xi(e.plant.states());
    ladder.move(step, e.z.data(), xi.data());
    expect_same(xi, e.moved(ladder.length(step)));
    StepLadder::Work work{};
    ladder.book(step, e.z.data(), work);
    expect_same(work, e.work(ladder.length(step)));
  }
}

TEST(StepLadder, a_series_follows_the_motion_to_any_part_of_the_shortest_step) {
  const Example e;
  StepLadder ladder(e.rate, e.forms, 4e-3);
  const double length = ladder.length(ladder.steps() - 1);
  ladder.expand(e.z.data(), length);
  for (const double part : {0.1, 0.37, 1.0}) {
    VectorXd xi(e.plant.states());
    ladder.move_to(part, xi.data());
    expect_same(xi, e.moved(part * length));
    StepLadder::Work work{};
    ladder.book_to(part, work);
    expect_same(work, e.work(part * length));
  }
}

TEST(StepLadder, travels_any_length_longer_ones_than_its_longest_step_included) {
  const Example e;
  StepLadder ladder(e.rate, e.forms, 1e-3);
  for (const double length : {1e-9, 0.3e-3, 1e-3, 0.99999e-3, 4.7e-3}) {
    VectorXd z = e.z;
    StepLadder::Work work{};
    ladder.travel(length, z, work);
    expect_same(z.head(e.plant.states()), e.moved(length));
    expect_same(work, e.work(length));
  }
}

TEST(StepLadder, without_forms_books_nothing) {
  const Example e;
  StepLadder ladder(e.rate, {}, 1e-3);
  VectorXd z = e.z;
  StepLadder::Work work{};
  ladder.travel(1.3e-3, z, work);
  expect_same(z.head(e.plant.states()), e.moved(1.3e-3));
  EXPECT_EQ(work, StepLadder::Work{});
}

}  // namespace
}  // namespace gyrator
