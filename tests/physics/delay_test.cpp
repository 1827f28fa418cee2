#include "gyrator/cosim/simulation.hpp"

#include <algorithm>
#include <cmath>
#include <deque>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "support/device_list.hpp"

// Delays of any length against a second simulation, written out here: a list of commands with the
// exact instant at which each takes effect, and the closed form of P3 in between.

namespace gyrator {
namespace {

constexpr double m = 0.04, b = 0.8, tau = m / b;  // P3
const Rational T(1, 1000);

struct Reference {
  std::vector<double> position, velocity, command;
};

// A wall with a plain difference; quantum 0 for none.
Reference simulate_by_hand(const VirtualWall& wall, double quantum, const Rational& delay,
                           int samples, double x, double v) {
  struct Pending {
    Rational at;
    double command;
  };
  std::deque<Pending> pending;
  Reference result;
  double held = 0, previous = 0;
  const auto coast = [&](const Rational& from, const Rational& to) {
    const double h = (to - from).to_double();
    const double lost = -std::expm1(-h / tau);
    x += tau * lost * v + held / b * (h - tau * lost);
    v += lost * (held / b - v);
  };
  for (int k = 0; k <= samples; ++k) {
    const Rational now = Rational(k) * T;
    const double y = quantum > 0 ? quantum * std::floor(x / quantum + 0.5) : x;
    if (k == 0) previous = y;
    double effort = wall.stiffness * y + wall.damping * (y - previous) / T.to_double();
    if (wall.unilateral && y <= 0) effort = 0;
    previous = y;
    result.position.push_back(x);
    result.velocity.push_back(v);
    result.command.push_back(-effort);
    pending.push_back({now + delay, -effort});

    const Rational end = now + T;
    Rational at = now;
    while (!pending.empty() && pending.front().at < end) {
      coast(at, pending.front().at);
      at = pending.front().at;
      held = pending.front().command;
      pending.pop_front();
    }
    coast(at, end);
  }
  return result;
}

std::vector<Rational> make_delays() {
  std::vector<Rational> delays;
  for (const Rational& periods :
       {Rational(0), Rational(3, 10), Rational(999, 1000), Rational(1), Rational(1001, 1000),
        Rational(3, 2), Rational(10), Rational(10) + Rational(1, 3)}) {
    delays.push_back(periods * T);
  }
  return delays;
}

double find_largest(const std::vector<double>& values) {
  double largest = 0;
  for (const double value : values) largest = std::max(largest, std::abs(value));
  return largest;
}

void expect_as_by_hand(const VirtualWall& wall, const Sensor& sensor, EngineKind engine,
                       double tolerance) {
  constexpr int samples = 200;
  const Plant plant = build_plant(build_device_network(testing::make_p3(), FreeOperator{}));
  for (const Rational& delay : make_delays()) {
    SimulationOptions options;
    options.duration = Rational(samples) * T;
    options.initial_position = -0.011;
    options.initial_velocity = 0.4;
    options.engine = engine;
    const TimeRun run = simulate(plant, sensor, wall, {T, delay}, options);
    const Reference expected = simulate_by_hand(wall, sensor.quantum, delay, samples, -0.011, 0.4);
    const std::string where = "delay of " + (delay / T).to_string() + " periods";
    ASSERT_EQ(run.trace.column("position").size(), expected.position.size());
    const double position = find_largest(expected.position);
    const double velocity = find_largest(expected.velocity);
    for (std::size_t k = 0; k < expected.position.size(); ++k) {
      ASSERT_NEAR(run.trace.column("position")[k], expected.position[k], tolerance * position)
          << where << ", sample " << k;
      ASSERT_NEAR(run.trace.column("velocity")[k], expected.velocity[k], tolerance * velocity)
          << where << ", sample " << k;
    }
    ASSERT_GT(find_largest(expected.command), 0.5) << where << ": the wall was never felt";
  }
}

// Two hundred periods exact to rounding; near and beyond the limit of stability a difference grows
// with the motion itself, against whose largest size it is measured.
constexpr double exact_tolerance = 1e-9;
constexpr double integrated_tolerance = 1e-6;  // steps to 1e-9 each, some thousand of them

TEST(Delay, of_any_length_acts_at_its_exact_instant) {
  expect_as_by_hand({.stiffness = 120, .damping = 0.3}, {}, EngineKind::exact, exact_tolerance);
}

TEST(Delay, of_any_length_acts_at_its_exact_instant_on_a_unilateral_wall) {
  const VirtualWall wall{
      .stiffness = 600, .damping = 0.5, .velocity = DifferenceEstimator{}, .unilateral = true};
  expect_as_by_hand(wall, {}, EngineKind::exact, exact_tolerance);
}

TEST(Delay, of_any_length_acts_at_its_exact_instant_with_a_quantized_sensor) {
  // 0.1 mm: no sample comes so close to an edge that rounding decides (it would fail at once).
  expect_as_by_hand({.stiffness = 120, .damping = 0.1}, {.quantum = 1e-4}, EngineKind::exact,
                    exact_tolerance);
}

TEST(Delay, is_kept_by_the_integrating_engines_too) {
  for (const EngineKind engine : {EngineKind::cvode, EngineKind::odeint}) {
    expect_as_by_hand({.stiffness = 120, .damping = 0.3}, {}, engine, integrated_tolerance);
  }
}

TEST(Delay, makes_the_difference_that_it_should) {
  // The published limit b/(T/2 + T_d) of a delayed spring: 100 ms allow 7.96 N/m, 50 ms 15.84.
  // Exactly sampled it lies a little above; 20 % on either side decide.
  const Plant plant = build_plant(build_device_network(testing::make_p3(), FreeOperator{}));
  for (const int delay_ms : {50, 100}) {
    const double limit = b / (0.5e-3 + delay_ms * 1e-3);
    for (const double side : {0.8, 1.25}) {
      SimulationOptions options;
      options.duration = 6;
      options.initial_velocity = 0.1;
      const TimeRun run = simulate(plant, {}, VirtualWall{.stiffness = side * limit},
                                   {T, Rational(delay_ms, 1000)}, options);
      EXPECT_EQ(run.classification.outcome == Outcome::diverges, side > 1)
          << delay_ms << " ms, " << side << " of the limit";
    }
  }
}

}  // namespace
}  // namespace gyrator
