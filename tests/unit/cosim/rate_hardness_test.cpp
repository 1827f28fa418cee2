#include "gyrator/cosim/rate_hardness.hpp"

#include <vector>

#include <gtest/gtest.h>

namespace gyrator {
namespace {

constexpr double T = 1e-3;

// A body that nothing can slow down enters at 0.4 m/s, `share` of a period before a sample.
TimeRun enter(const Controller& controller, double share,
              std::optional<Rational> trace_step = std::nullopt) {
  Device device;
  device.motion = Motion::linear;
  device.mechanics.inertia = 1e9;
  SimulationOptions options;
  options.duration = Rational(1, 100);
  options.initial_position = -0.4 * T * (3 - share);
  options.initial_velocity = 0.4;
  options.trace_step = trace_step;
  return simulate(build_plant(build_device_network(device, FreeOperator{})), {}, controller,
                  {Rational(1, 1000), 0}, options);
}

TEST(RateHardness, is_stiffness_and_damping_over_the_period_wherever_the_surface_is_crossed) {
  const VirtualWall wall{.stiffness = 3000, .damping = 7, .unilateral = true};
  for (const double share : {0.05, 0.5, 0.95}) {
    const auto found = find_rate_hardness(enter(wall, share).trace, T);
    ASSERT_TRUE(found);
    EXPECT_NEAR(*found, 3000 + 7 / T, 1e-4) << share;  // 1e9 kg are slowed by 4e-9 of their motion
  }
}

TEST(RateHardness, a_braking_pulse_adds_its_damping_over_the_period) {
  const VirtualWall wall{.stiffness = 3000, .unilateral = true};
  const BrakingPulse pulse{.damping = 11, .duration = 3e-3};
  EXPECT_NEAR(*find_rate_hardness(enter({wall, {pulse}}, 0.3).trace, T), 3000 + 11 / T, 1e-4);
}

TEST(RateHardness, is_the_same_with_rows_between_the_samples) {
  const VirtualWall wall{.stiffness = 3000, .damping = 7, .unilateral = true};
  const auto between = find_rate_hardness(enter(wall, 0.3, Rational(1, 7000)).trace, T);
  EXPECT_EQ(*between, *find_rate_hardness(enter(wall, 0.3).trace, T));
}

TEST(RateHardness, is_none_where_the_effort_falls_at_the_surface) {
  // Damping of -7 N.s/m pulls the device in with 7/T, above what the spring pushes.
  const VirtualWall wall{.stiffness = 3000, .damping = -7, .unilateral = true};
  EXPECT_FALSE(find_rate_hardness(enter(wall, 0.5).trace, T));
  const VirtualWall softer{.stiffness = 8000, .damping = -7, .unilateral = true};
  EXPECT_NEAR(*find_rate_hardness(enter(softer, 0.5).trace, T), 8000 - 7 / T, 1e-4);
}

TEST(RateHardness, is_none_without_a_contact) {
  const VirtualWall wall{.stiffness = 3000, .unilateral = true};
  EXPECT_FALSE(find_rate_hardness(enter(wall, -20).trace, T));
}

}  // namespace
}  // namespace gyrator
