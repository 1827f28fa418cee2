#include "gyrator/controllers/contact_effect.hpp"

#include "gyrator/controllers/controller.hpp"
#include "gyrator/controllers/linear_motion.hpp"
#include "gyrator/core/error.hpp"

#include <cmath>
#include <numbers>
#include <vector>

#include <gtest/gtest.h>

namespace gyrator {
namespace {

constexpr double T = 1e-3;
const VirtualWall air{.stiffness = 0, .unilateral = true};  // leaves the effect alone

// Opposing efforts for a gesture.
std::vector<double> play(const Wrapper& effect, const std::vector<double>& positions) {
  RunningController running(Controller(air, {effect}), T);
  std::vector<double> efforts;
  for (const double y : positions) efforts.push_back(-running.step(y));
  return efforts;
}

// A free device of the given inertia and damping that meets the effect at v; its velocities at the
// samples from the first in contact on.
std::vector<double> meet(const Wrapper& effect, double inertia, double damping, double v,
                         int samples) {
  RunningController running(Controller(air, {effect}), T);
  running.step(-0.4 * v * T);
  MotionState s{0.6 * v * T, v};
  std::vector<double> velocities;
  for (int k = 0; k < samples; ++k) {
    velocities.push_back(s.velocity);
    s = LinearMotion(inertia, damping, 0, running.step(s.position)).after(s, T);
  }
  return velocities;
}

TEST(ContactEffect, begins_when_the_surface_is_crossed_and_ends_when_it_is_left) {
  const BrakingPulse pulse{.damping = 5, .duration = 3e-3};
  // Enters at 2 m/s; goes on deeper and slower; a second contact at 1 m/s is cut short.
  const auto efforts =
      play(pulse, {-1e-3, 1e-3, 2e-3, 2e-3, 2e-3, 3e-3, -5e-4, 0, 1e-3, -1e-3, 0, 0});
  const std::vector<double> expected{0, 10, 10, 10, 0, 0, 0, 0, 5, 0, 0, 0};
  ASSERT_EQ(efforts.size(), expected.size());
  for (std::size_t k = 0; k < expected.size(); ++k)
    EXPECT_NEAR(efforts[k], expected[k], 1e-12) << k;
}

TEST(ContactEffect, has_no_impact_when_it_starts_inside) {
  const auto efforts = play(BrakingPulse{.damping = 5}, {1e-3, 2e-3, 3e-3});
  EXPECT_EQ(efforts, (std::vector<double>{0, 0, 0}));
}

TEST(ContactEffect, a_braking_pulse_stops_a_device_in_one_sample_and_never_turns_it_round) {
  // g = m/T over one sample is dead-beat; ten times that is cut to it; over four samples a quarter.
  const double m = 0.3;
  for (const double duration : {0.0, T, 4 * T}) {
    for (const double factor : {1.0, 10.0}) {
      const BrakingPulse pulse{.damping = factor * m / T, .duration = duration, .inertia = m};
      const auto v = meet(pulse, m, 0, 0.8, 8);
      EXPECT_NEAR(v.front(), 0.8, 1e-12);
      EXPECT_NEAR(v.back(), 0, 1e-12);
      for (std::size_t k = 1; k < v.size(); ++k) EXPECT_LE(v[k], v[k - 1] + 1e-12);
    }
  }
  const auto reversed = meet(BrakingPulse{.damping = 2 * m / T}, m, 0, 0.8, 3);
  EXPECT_NEAR(reversed.back(), -0.8, 1e-12);  // without an inertia there is no limit
}

TEST(ContactEffect, an_event_transient_is_the_decaying_sine_of_its_law) {
  const EventTransient transient{.gain = 6, .decay_time = 0.02, .frequency_hz = 90};
  std::vector<double> positions{-1e-4};
  for (int k = 0; k < 400; ++k) positions.push_back(2e-4 + 1e-9 * k);  // enters at 0.3 m/s
  const auto efforts = play(transient, positions);
  for (int k = 0; k < 280; ++k) {  // 14 time constants
    const double t = (k + 0.5) * T;
    EXPECT_NEAR(efforts[static_cast<std::size_t>(k) + 1],
                6 * 0.3 * std::exp(-t / 0.02) * std::sin(2 * std::numbers::pi * 90 * t), 1e-12)
        << k;
  }
  for (std::size_t k = 281; k < efforts.size(); ++k) EXPECT_EQ(efforts[k], 0);
}

TEST(ContactEffect, acceleration_matching_gives_the_device_the_velocity_of_the_transient) {
  const double m = 0.4, b = 3, v = 0.5, w = 2 * std::numbers::pi * 120, B = 1 / 0.015;
  const double change = 0.7;
  const DecayingSine sine{.velocity_change = change, .decay_time = 0.015, .frequency_hz = 120};
  for (const double damping : {0.0, b}) {
    const AccelerationMatching matching{.inertia = m, .damping = damping, .transient = sine};
    // What the transient takes from a device that coasts: the coasting itself is the device's.
    const auto found = meet(matching, m, damping, v, 60);
    const double A = change * v * (B * B + w * w) / w;
    for (std::size_t k = 0; k < found.size(); ++k) {
      const double t = static_cast<double>(k) * T;
      double taken = 0;  // int a dt by Simpson's rule, fourth order in t/2000
      for (int i = 0; i <= 2000; ++i) {
        const double at = t * i / 2000;
        const double weight = i == 0 || i == 2000 ? 1 : i % 2 == 1 ? 4 : 2;
        taken += weight * A * std::exp(-B * at) * std::sin(w * at) * t / 6000;
      }
      EXPECT_NEAR(found[k], v * std::exp(-damping / m * t) - taken, 1e-8) << k;
    }
  }
}

TEST(ContactEffect, a_recorded_acceleration_is_played_in_proportion_to_the_impact) {
  // A triangle of 100 m/s^2 over 6 ms, recorded at 0.2 m/s on a 2 ms grid: int a dt = 0.3 m/s.
  const RecordedTransient recorded{
      .acceleration = {0, 100, 50, 0}, .time_step = 2e-3, .velocity = 0.2};
  const double m = 0.25, v = 0.5;
  const auto found = meet(AccelerationMatching{.inertia = m, .transient = recorded}, m, 0, v, 20);
  const std::vector<double> integral{0, 0.025, 0.1, 0.1875, 0.25, 0.2875, 0.3, 0.3};
  for (std::size_t k = 0; k < integral.size(); ++k)
    EXPECT_NEAR(found[k], v - integral[k] * v / 0.2, 1e-12) << k;
}

TEST(ContactEffect, adds_to_the_wall_and_to_one_another) {
  const BrakingPulse pulse{.damping = 5, .duration = 2e-3};
  const VirtualWall wall{.stiffness = 1000, .unilateral = true};
  RunningController running(Controller(wall, {pulse, pulse}), T);
  EXPECT_EQ(running.step(-1e-3), 0);
  EXPECT_NEAR(running.step(1e-3), -(1 + 2 * 5 * 2.0), 1e-12);
}

TEST(ContactEffect, refuses_what_has_no_course) {
  EXPECT_THROW(make_effect_course(BrakingPulse{.damping = 0}, T), Error);
  EXPECT_THROW(make_effect_course(BrakingPulse{.damping = 1, .duration = 1e4}, T), Error);
  EXPECT_THROW(make_effect_course(EventTransient{1, 0.01, 500}, T), Error);  // half the rate
  EXPECT_NO_THROW(make_effect_course(EventTransient{1, 0.01, 499}, T));
  EXPECT_THROW(make_effect_course(EventTransient{1, 0, 100}, T), Error);
  const RecordedTransient recorded{{0, 1}, 1e-3, 0.1};
  EXPECT_THROW(make_effect_course(AccelerationMatching{.transient = recorded}, T), Error);
  EXPECT_NO_THROW(make_effect_course(AccelerationMatching{.inertia = 1, .transient = recorded}, T));
  EXPECT_THROW(
      make_effect_course(
          AccelerationMatching{.inertia = 1, .transient = RecordedTransient{{1}, 1, 1}}, T),
      Error);
}

}  // namespace
}  // namespace gyrator
