#include "gyrator/cosim/simulation.hpp"

#include <cmath>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "support/device_list.hpp"

// The exact engine against closed forms, at every sample of a run.

namespace gyrator {
namespace {

using testing::make_p3;

constexpr double m = 0.04, b = 0.8, tau = m / b;  // P3
constexpr double T = 1e-3;
// Five hundred steps, each exact to some roundings, of which positions collect all.
constexpr double tolerance = 1e-9;

TimeRun run(const Operator& held_by, const Controller& controller,
            const SimulationOptions& options) {
  return simulate(build_plant(build_device_network(make_p3(), held_by)), {}, controller,
                  {Rational(1, 1000), 0}, options);
}

template <class Position, class Velocity>
void expect_motion(const TimeRun& run, const Position& position, const Velocity& velocity) {
  const auto& time = run.trace.column("time_s");
  for (std::size_t k = 0; k < time.size(); ++k) {
    ASSERT_NEAR(run.trace.column("position")[k], position(time[k]), tolerance) << time[k] << " s";
    ASSERT_NEAR(run.trace.column("velocity")[k], velocity(time[k]), tolerance) << time[k] << " s";
  }
}

TEST(HeldMotion, a_free_mass_coasts_to_rest) {
  SimulationOptions options;
  options.initial_position = -0.02;
  options.initial_velocity = 1.5;
  expect_motion(
      run(FreeOperator{}, NoController{}, options),
      [](double t) { return -0.02 - 1.5 * tau * std::expm1(-t / tau); },
      [](double t) { return 1.5 * std::exp(-t / tau); });
}

TEST(HeldMotion, a_steady_push_leads_to_the_terminal_velocity) {
  constexpr double F = 0.6;
  SimulationOptions options;
  options.external_effort = F;
  expect_motion(
      run(FreeOperator{}, NoController{}, options),
      [](double t) { return F / b * (t + tau * std::expm1(-t / tau)); },
      [](double t) { return -F / b * std::expm1(-t / tau); });
}

TEST(HeldMotion, a_device_in_a_hand_is_a_damped_oscillator) {
  const MassSpringDamper hand{.inertia = 0.06, .damping = 0.5, .stiffness = 250, .resonators = {}};
  const double M = m + hand.inertia, d = (b + hand.damping) / (2 * M);
  const double w = std::sqrt(hand.stiffness / M - d * d);
  constexpr double x_0 = 0.01, v_0 = 0.3;
  SimulationOptions options;
  options.initial_position = x_0;
  options.initial_velocity = v_0;
  const double s_0 = (v_0 + d * x_0) / w;
  expect_motion(
      run(hand, NoController{}, options),
      [&](double t) { return std::exp(-d * t) * (x_0 * std::cos(w * t) + s_0 * std::sin(w * t)); },
      [&](double t) {
        return std::exp(-d * t) *
               ((w * s_0 - d * x_0) * std::cos(w * t) - (w * x_0 + d * s_0) * std::sin(w * t));
      });
}

TEST(HeldMotion, a_hand_that_is_only_a_spring_and_a_push_ends_where_they_balance) {
  const MassSpringDamper hand{.inertia = 0, .damping = 0, .stiffness = 100, .resonators = {}};
  SimulationOptions options;
  options.duration = 2;  // e^-20 of the start is left
  options.external_effort = 0.7;
  const TimeRun r = run(hand, NoController{}, options);
  EXPECT_NEAR(r.trace.column("position").back(), 0.7 / 100, 1e-8 * 0.7);
  // At rest the hand gives what it is pushed with, less what its spring holds: nothing is left.
  EXPECT_NEAR(r.trace.column("effort").back(), 0, 1e-7);
}

TEST(HeldMotion, commands_held_from_sample_to_sample_drive_it_as_the_difference_equation_says) {
  // v' = e v + u (1 - e)/b, x' = x + tau (1 - e) v + u (T - tau (1 - e))/b
  SimulationOptions options;
  options.initial_position = 0.01;
  options.initial_velocity = -0.2;
  const VirtualWall wall{.stiffness = 900, .damping = 0.6};
  const TimeRun r = run(FreeOperator{}, wall, options);
  const double lost = -std::expm1(-T / tau);
  double x = 0.01, v = -0.2, previous = 0.01;
  for (std::size_t k = 0; k < r.trace.column("position").size(); ++k) {
    ASSERT_NEAR(r.trace.column("position")[k], x, tolerance) << k;
    ASSERT_NEAR(r.trace.column("velocity")[k], v, tolerance) << k;
    const double u = -(900 * x + 0.6 * (x - previous) / T);
    ASSERT_NEAR(r.trace.column("command")[k], u, 1e5 * tolerance) << k;  // K + B/T times a position
    previous = x;
    x += tau * lost * v + u / b * (T - tau * lost);
    v += -lost * v + u / b * lost;
  }
}

TEST(HeldMotion, a_quantized_sensor_leaves_a_device_alone_within_half_a_quantum) {
  // The wall sees position zero until the device has drifted by half a quantum.
  SimulationOptions options;
  options.duration = Rational(1, 20);
  options.initial_velocity = 0.01;
  const Plant plant = build_plant(build_device_network(make_p3(), FreeOperator{}));
  const TimeRun r = simulate(plant, {.quantum = 4e-4}, VirtualWall{.stiffness = 900},
                             {Rational(1, 1000), 0}, options);
  bool touched = false;
  for (std::size_t k = 0; k < r.trace.column("position").size(); ++k) {
    const double t = static_cast<double>(k) * T;
    const double coasting = -0.01 * tau * std::expm1(-t / tau);
    if (coasting < 2e-4) {
      ASSERT_NEAR(r.trace.column("position")[k], coasting, tolerance) << t;
      ASSERT_EQ(r.trace.column("command")[k], 0) << t;
    } else {
      touched = true;
      ASSERT_EQ(r.trace.column("command")[k], -900 * 4e-4) << t;
      break;
    }
  }
  EXPECT_TRUE(touched);
}

TEST(HeldMotion, the_traced_effort_is_what_accelerates_and_brakes) {
  // Pushed by F through the ammeter: m v' = effort + command - b v; between samples v' is known.
  SimulationOptions options;
  options.external_effort = 0.5;
  options.initial_velocity = 0.2;
  const VirtualWall wall{.stiffness = 300};
  const TimeRun r = run(FreeOperator{}, wall, options);
  const auto& v = r.trace.column("velocity");
  const double lost = -std::expm1(-T / tau);
  for (std::size_t k = 0; k + 1 < v.size(); ++k) {
    EXPECT_EQ(r.trace.column("effort")[k], 0.5);
    const double u = r.trace.column("held_command_after")[k] + r.trace.column("effort")[k];
    ASSERT_NEAR(v[k + 1], v[k] - lost * v[k] + u / b * lost, tolerance);
  }
}

}  // namespace
}  // namespace gyrator
