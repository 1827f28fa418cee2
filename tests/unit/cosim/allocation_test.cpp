#include "gyrator/cosim/engine.hpp"

#include <cmath>

#include <gtest/gtest.h>

#include "support/allocation_count.hpp"

namespace gyrator {
namespace {

constexpr double T = 1e-3;
constexpr int steps = 1000;

Device make_display() {
  Device device;
  device.drive.motor = Motor{0.05, 1.5, 0.5e-3};
  device.drive.amplifier = CurrentAmplifier{};
  device.drive.damping = {RcDamping{5, 2200e-6}};
  device.mechanics.inertia = 2e-5;
  device.mechanics.damping = 1e-4;
  return device;
}

// Swings under a command of 2 Hz held over each period; returns the allocations of that.
long swing(Engine& engine, int segment, PlantState& state) {
  const long before = testing::allocations;
  for (int k = 0; k < steps; ++k) {
    const Eigen::Vector2d u(5e-3 * std::sin(2 * M_PI * 2 * k * T), 0);
    engine.advance(segment, k * T, u, state);
    (void)engine.inputs(u, state);
  }
  return testing::allocations - before;
}

TEST(Allocation, happens_in_no_segment_of_the_exact_engine) {
  if (!GYRATOR_COUNTS_ALLOCATIONS) GTEST_SKIP();
  const Plant plant = build_plant(build_device_network(make_display(), FreeOperator{}));
  for (const bool ledger : {false, true}) {
    const auto engine = make_exact_engine(plant, {.ledger = ledger});
    const int segment = engine->prepare(T);
    PlantState state;
    state.xi = plant.initial_state(0, 0);
    (void)engine->inputs(Eigen::Vector2d::Zero(), state);  // gives it its length
    EXPECT_EQ(swing(*engine, segment, state), 0) << ledger;
  }
}

TEST(Allocation, happens_in_no_segment_of_the_exact_engine_in_modes_that_it_knows) {
  if (!GYRATOR_COUNTS_ALLOCATIONS) GTEST_SKIP();
  Device device = make_display();
  device.mechanics.coulomb_friction = 1e-3;
  device.mechanics.stiction = 1.5e-3;
  const Plant plant = build_moving_plant(build_device_network(device, FreeOperator{}));
  for (const bool ledger : {false, true}) {
    const auto engine = make_exact_engine(plant, {.ledger = ledger});
    const int segment = engine->prepare(T);
    PlantState state;
    state.xi = plant.initial_state(0, 0);
    EXPECT_GT(swing(*engine, segment, state), 0) << "the modes that it meets";
    const ContactEvents known = state.events;
    EXPECT_EQ(swing(*engine, segment, state), 0) << ledger;
    EXPECT_GT(state.events.sticks, known.sticks);
    EXPECT_GT(state.events.slips, known.slips);
  }
}

}  // namespace
}  // namespace gyrator
