#include "gyrator/twin/twin_plant.hpp"

#include "gyrator/twin/simulated_amplifier.hpp"

#include <cmath>

#include <gtest/gtest.h>

#include "unit/twin/twin_models.hpp"

namespace gyrator {
namespace {

constexpr double tick = SimulatedAmplifier::tick;
constexpr double rounding = 1e-12;  // of a carry: two products with a network's matrices

// In full motion, with every storage charged.
TwinPlant make_moving(const Device& device) {
  TwinPlant plant(device, tick, 0.4 * tick);
  for (int k = 0; k < 300; ++k) {
    const double command = std::sin(0.01 * k);
    plant.advance(k * tick, command, std::sin(0.01 * (k + 1)));
  }
  return plant;
}

Device make_device(DriveMode mode, bool has_branch, double friction, bool has_transmission) {
  TwinDevice twin = make_plain_twin();
  twin.device.mechanics.coulomb_friction = friction;
  if (has_transmission) {
    twin.device.mechanics.transmission = Transmission{5, 1e-4, 1e-5};
    twin.device.sensor = SensorLocation::motor;
  }
  TwinSettings settings = find_initial_settings(twin);
  settings.enable = true;
  settings.drive_mode = mode;
  settings.damping_resistance = 5;
  settings.damping_capacitance = 1e-3;
  settings.damping_connected = has_branch;
  settings.cancellation_resistance = mode == DriveMode::voltage ? 0.5 : 0;
  settings.back_emf_damping = 1e-4;
  settings.back_emf_resistance = 1.4;
  return make_plant_device(twin, settings, 1.5);
}

TEST(TwinPlant, TheSameCircuitTakesOverEverything) {
  for (const DriveMode mode : {DriveMode::current, DriveMode::voltage}) {
    for (const bool has_branch : {false, true}) {
      for (const double friction : {0.0, 1e-3}) {
        for (const bool has_transmission : {false, true}) {
          const Device device = make_device(mode, has_branch, friction, has_transmission);
          TwinPlant from = make_moving(device);
          TwinPlant to(device, tick, 0.4 * tick);
          to.set_state(from.physical_state(), std::sin(3.0));
          const auto expect_same = [&](int limit) {
            const double size = rounding * limit;
            EXPECT_NEAR(to.position(), from.position(), size * std::abs(from.position()));
            EXPECT_NEAR(to.velocity(), from.velocity(), size * std::abs(from.velocity()));
            EXPECT_NEAR(to.current(), from.current(), size);
            EXPECT_NEAR(to.voltage(), from.voltage(), size * 10);
            EXPECT_NEAR(to.stored_energy(), from.stored_energy(), size * from.stored_energy());
          };
          ASSERT_GT(std::abs(from.velocity()), 1);
          ASSERT_GT(std::abs(from.current()), 1e-3);
          expect_same(1);
          for (int k = 0; k < 100; ++k) {
            from.advance(k * tick, 0.1, 0.2);
            to.advance(k * tick, 0.1, 0.2);
          }
          expect_same(100);
        }
      }
    }
  }
}

TEST(TwinPlant, AnotherBranchKeepsCurrentChargeAndMotion) {
  const Device before = make_device(DriveMode::voltage, true, 0, false);
  Device after = before;
  std::get<RcDamping>(after.drive.damping[0]) = {2, 4e-3};
  TwinPlant from = make_moving(before);
  TwinPlant to(after, tick, 0);
  const PhysicalState stored = from.physical_state();
  to.set_state(stored, 0);
  EXPECT_NEAR(to.current(), from.current(), rounding);
  EXPECT_NEAR(to.velocity(), from.velocity(), rounding * std::abs(from.velocity()));
  EXPECT_NEAR(to.position(), from.position(), rounding);
  const double charge = *stored.find("damping.0.node", true);
  ASSERT_GT(std::abs(charge), 0.01);
  EXPECT_NEAR(*to.physical_state().find("damping.0.node", true), charge, rounding);
  // What the larger capacitor holds more at the same voltage, 3 mF of it.
  EXPECT_NEAR(to.stored_energy() - from.stored_energy(), 3e-3 / 2 * charge * charge,
              rounding * from.stored_energy());
}

TEST(TwinPlant, AnImposedCurrentWinsOverTheWindings) {
  // With the branch gone all of the amplifier's current must pass the winding. (Feedback of the
  // terminal voltage would feel the impulse.)
  Device before = make_device(DriveMode::current, true, 0, false);
  before.drive.damping.resize(1, RcDamping{});
  Device after = before;
  after.drive.damping.clear();
  std::get<CurrentAmplifier>(after.drive.amplifier).voltage_limit.reset();
  TwinPlant from = make_moving(before);
  TwinPlant to(after, tick, 0);
  const PhysicalState stored = from.physical_state();
  ASSERT_GT(std::abs(stored.output_current - from.current()), 0.01);
  to.set_state(stored, 0);
  EXPECT_NEAR(to.current(), stored.output_current, rounding);
  EXPECT_NEAR(to.velocity(), from.velocity(), rounding * std::abs(from.velocity()));
}

TEST(RailedPlant, RailsThatAreOnlyPutInWhenReachedActAsRailsThatAreAlwaysThere) {
  for (const double friction : {0.0, 1e-3}) {
    Device device = make_device(DriveMode::current, false, friction, false);
    device.drive.damping.clear();
    std::get<CurrentAmplifier>(device.drive.amplifier).voltage_limit = 2;
    TwinPlant always(device, tick, 0.4 * tick);
    RailedPlant seldom(device, tick, 0.4 * tick);
    double largest = 0;
    double before = 0;
    for (int k = 0; k < 3000; ++k) {
      const double after = (k / 100) % 2 == 0 ? 0.8 : -0.8;  // 1.2 V, and L di/dt of much more
      always.advance(k * tick, before, after);
      seldom.advance(k * tick, before, after);
      before = after;
      largest = std::max(largest, std::abs(always.voltage()));
      // The rails' leakage of 1e-7 S draws 0.2 uA, and what it leaves away of the impulse.
      ASSERT_NEAR(seldom.now().current(), always.current(), 1e-5) << k;
      ASSERT_NEAR(seldom.now().velocity(), always.velocity(), 1e-4) << k;
    }
    EXPECT_GT(largest, 1.9);
    EXPECT_LT(largest, 2 + rail_resistance * 2);
  }
}

}  // namespace
}  // namespace gyrator
