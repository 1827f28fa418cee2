#include "gyrator/cosim/simulation.hpp"

#include <cmath>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "support/device_list.hpp"

// Runs of a device whose wall is an analog loop: nothing is sampled, so that they have closed
// forms.

namespace gyrator {
namespace {

constexpr double J = 2e-5, b = 1e-4, k = 0.05, d = 1e-4;

Device make_ideal_held() {
  Device device;
  device.mechanics.inertia = J;
  device.mechanics.damping = b;
  device.drive.damping = {HeldImpedance{k, d, {}}};
  return device;
}

TimeRun let_go(const Device& device, const Operator& held_by, double position, double velocity) {
  SimulationOptions options;
  options.duration = Rational(1, 5);
  options.initial_position = position;
  options.initial_velocity = velocity;
  return simulate(build_plant(build_device_network(device, held_by)), {}, NoController{},
                  {Rational(1, 1000), 0}, options);
}

// x of m x'' + c x' + s x = 0, underdamped.
double swing(double m, double c, double s, double x_0, double v_0, double t) {
  const double decay = c / (2 * m);
  const double omega = std::sqrt(s / m - decay * decay);
  return std::exp(-decay * t) *
         (x_0 * std::cos(omega * t) + (v_0 + decay * x_0) / omega * std::sin(omega * t));
}

TEST(HeldImpedance, swings_as_a_mass_on_its_spring_and_damper) {
  const TimeRun run = let_go(make_ideal_held(), FreeOperator{}, 0.02, -1);
  const auto& x = run.trace.column("position");
  EXPECT_DOUBLE_EQ(x.front(), 0.02);
  for (std::size_t i = 0; i < x.size(); ++i)
    ASSERT_NEAR(x[i], swing(J, b + d, k, 0.02, -1, static_cast<double>(i) * 1e-3), 1e-12) << i;
  // Of what has gone, the device's own damper has turned b/(b + d) into heat; the loop's damper is
  // the amplifier's work.
  const double v = run.trace.column("velocity").back();
  const double gone = (J * (1 - v * v) + k * (0.02 * 0.02 - x.back() * x.back())) / 2;
  EXPECT_NEAR(run.energy.dissipated / gone, b / (b + d), 1e-9);
}

TEST(HeldImpedance, in_a_hand_with_a_spring_starts_with_both_deflected) {
  // Were the loop's position or the hand's spring at rest where the run starts, the start would
  // be the first swing's centre.
  const MassSpringDamper hand{.inertia = 3e-5, .damping = 2e-4, .stiffness = 0.3, .resonators = {}};
  const TimeRun run = let_go(make_ideal_held(), hand, 0.02, 0);
  const auto& x = run.trace.column("position");
  EXPECT_DOUBLE_EQ(x.front(), 0.02);
  for (std::size_t i = 0; i < x.size(); ++i) {
    ASSERT_NEAR(
        x[i], swing(J + 3e-5, b + d + 2e-4, k + 0.3, 0.02, 0, static_cast<double>(i) * 1e-3), 1e-12)
        << i;
  }
}

TEST(HeldImpedance, behind_a_transmission_starts_with_both_ends_at_the_position) {
  // A stiff link: the run is that of all inertias together, to the link's own k J_l/(k_t J).
  Device device = make_ideal_held();
  device.mechanics.transmission =
      Transmission{.stiffness = 2e4, .damping = 0.1, .load_inertia = 1e-5};
  for (const SensorLocation sensor : {SensorLocation::port, SensorLocation::motor}) {
    device.sensor = sensor;
    const TimeRun run = let_go(device, FreeOperator{}, 0.02, 0);
    const auto& x = run.trace.column("position");
    EXPECT_DOUBLE_EQ(x.front(), 0.02);
    for (std::size_t i = 0; i < x.size(); ++i) {
      ASSERT_NEAR(x[i], swing(J + 1e-5, b + d, k, 0.02, 0, static_cast<double>(i) * 1e-3), 1e-6)
          << i;
    }
  }
}

}  // namespace
}  // namespace gyrator
