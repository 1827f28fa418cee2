#include "gyrator/core/error.hpp"
#include "gyrator/cosim/simulation.hpp"

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "support/contact_devices.hpp"
#include "support/nonlinear_devices.hpp"

// Plants that switch: the exact engine against cvode, which finds the same switchings by other
// means, and against itself.

namespace gyrator {
namespace {

const Sampling one_ms{Rational(1, 1000), 0};
// What cvode promises at 1e-9 a step. Each stick and each impact adds a restart.
constexpr double agreement = 1e-6;

TimeRun run(const Device& device, EngineKind engine, SimulationOptions options,
            const Controller& controller, const Sensor& sensor = {},
            const Sampling& sampling = one_ms, const Operator& held_by = FreeOperator{}) {
  options.engine = engine;
  const Plant plant = build_moving_plant(build_device_network(device, held_by));
  return simulate(plant, sensor, controller, sampling, options);
}

double find_largest(const std::vector<double>& column) {
  double largest = 0;
  for (const double value : column) largest = std::max(largest, std::abs(value));
  return largest;
}

void expect_same(const TimeRun& found, const TimeRun& exact, const std::string& where,
                 double known_to = agreement) {
  ASSERT_EQ(found.trace.names, exact.trace.names);
  for (const char* name : {"position", "velocity"}) {
    const auto& expected = exact.trace.column(name);
    const auto& column = found.trace.column(name);
    ASSERT_EQ(column.size(), expected.size());
    double worst = 0;
    for (std::size_t k = 0; k < column.size(); ++k)
      worst = std::max(worst, std::abs(column[k] - expected[k]));
    EXPECT_LE(worst, known_to * find_largest(expected)) << where << ": " << name;
  }
  const double moved = std::abs(exact.energy.source) + std::abs(exact.energy.operator_work) +
                       exact.energy.dissipated;
  EXPECT_NEAR(found.energy.dissipated, exact.energy.dissipated, 2 * known_to * moved) << where;
  EXPECT_NEAR(found.energy.source, exact.energy.source, 2 * known_to * moved) << where;
  EXPECT_EQ(found.events.slips, exact.events.slips) << where;
  EXPECT_EQ(found.events.sticks, exact.events.sticks) << where;
  EXPECT_EQ(found.events.impacts, exact.events.impacts) << where;
  EXPECT_EQ(found.classification.outcome, exact.classification.outcome) << where;
}

double residual_of(const TimeRun& r) {
  const EnergyLedger& e = r.energy;
  const double moved =
      std::abs(e.operator_work) + std::abs(e.source) + e.dissipated + e.stored + e.stored_initially;
  return std::abs(e.residual) / moved;
}

TEST(ContactEngines, exact_and_cvode_agree_on_every_kind_of_contact_and_delay) {
  for (const auto& [name, device] : testing::make_contact_devices()) {
    for (const Rational& delay : {Rational(0), Rational(3, 10), Rational(3, 2)}) {
      SimulationOptions options;
      options.duration = Rational(1, 5);
      options.initial_velocity = 0.7;
      options.external_effort = 1.3e-3;
      VirtualWall wall{.stiffness = 0.08, .damping = 1e-4};
      wall.unilateral = true;
      const Sensor sensor{.quantum = 1e-3, .offset = 5e-4};
      const Sampling sampling{Rational(1, 1000), delay * Rational(1, 1000)};
      const TimeRun exact = run(device, EngineKind::exact, options, wall, sensor, sampling);
      const TimeRun other = run(device, EngineKind::cvode, options, wall, sensor, sampling);
      const std::string where = name + ", " + std::to_string(delay.to_double()) + " periods late";
      expect_same(other, exact, where);
      EXPECT_LE(residual_of(exact), 1e-10) << where;
      EXPECT_LE(residual_of(other), agreement) << where;
      EXPECT_GT(exact.events.slips + exact.events.sticks + exact.events.impacts, 0) << where;
    }
  }
}

TEST(ContactEngines, a_spring_pulled_evenly_makes_stick_and_slip) {
  // The block hangs on a spring whose far end moves at v_p: its force k v_p t comes as an effort
  // that grows at each sample.
  Device device = testing::make_p3();
  device.mechanics.damping = 0.05;
  device.mechanics.coulomb_friction = 0.4;
  device.mechanics.stiction = 0.8;
  for (const double stribeck : {0.0, 0.05}) {
    device.mechanics.stribeck_velocity = stribeck;
    const MassSpringDamper spring{
        .inertia = 0.02, .damping = 0.1, .stiffness = 200, .resonators = {}};
    const Plant plant = build_moving_plant(build_device_network(device, spring));
    const auto exact = make_engine(EngineKind::exact, plant, {});
    const auto cvode = make_engine(EngineKind::cvode, plant, {});
    PlantState one;
    one.xi = plant.initial_state(0, 0);
    PlantState other = one;
    const int ms = exact->prepare(1e-3);
    const int its = cvode->prepare(1e-3);
    long resting = 0;
    for (int k = 0; k < 3000; ++k) {
      const Eigen::Vector2d u(0, 200 * 0.02 * 1e-3 * k);
      exact->advance(ms, 1e-3 * k, u, one);
      cvode->advance(its, 1e-3 * k, u, other);
      const double v = plant.port_velocity.value(one.xi, exact->inputs(u, one));
      EXPECT_NEAR(plant.port_velocity.value(other.xi, cvode->inputs(u, other)), v, agreement);
      if (v == 0) ++resting;
    }
    EXPECT_GT(one.events.slips, 3);
    EXPECT_EQ(one.events.slips, other.events.slips);
    EXPECT_EQ(one.events.sticks, other.events.sticks);
    EXPECT_GT(resting, 1000);
    EXPECT_LT(resting, 2990);
  }
}

TEST(ContactEngines, exact_and_cvode_agree_on_limited_amplifiers_clamps_and_brakes) {
  for (const auto& [name, device] : testing::make_nonlinear_devices()) {
    const Plant plant = build_moving_plant(build_device_network(device, FreeOperator{}));
    if (!plant.nonlinear->is_piecewise_linear()) continue;
    EXPECT_EQ(choose_engine(plant), EngineKind::exact) << name;
    SimulationOptions options;
    options.duration = Rational(1, 20);
    options.initial_velocity = 1;
    options.external_effort = 2e-4;
    const VirtualWall wall{.stiffness = 0.08, .damping = 1e-4};
    const TimeRun exact = run(device, EngineKind::exact, options, wall);
    expect_same(run(device, EngineKind::cvode, options, wall), exact, name);
    EXPECT_LE(residual_of(exact), 1e-9) << name;
  }
}

TEST(ContactEngines, the_exact_run_does_not_depend_on_where_it_is_looked_at) {
  for (const auto& [name, device] : testing::make_contact_devices()) {
    SimulationOptions options;
    options.duration = Rational(1, 10);
    options.initial_velocity = 0.7;
    options.external_effort = 1.3e-3;
    const VirtualWall wall{.stiffness = 0.08, .damping = 1e-4};
    const Sampling sampling{Rational(1, 1000), Rational(37, 100000)};
    const TimeRun plain = run(device, EngineKind::exact, options, wall, {}, sampling);
    for (const Rational& step : {Rational(1, 10000), Rational(1, 7000)}) {
      options.trace_step = step;
      const TimeRun traced = run(device, EngineKind::exact, options, wall, {}, sampling);
      const double size = find_largest(plain.trace.column("velocity"));
      EXPECT_NEAR(traced.trace.column("velocity").back(), plain.trace.column("velocity").back(),
                  1e-11 * size)
          << name;
      EXPECT_EQ(traced.events.slips, plain.events.slips) << name;
      EXPECT_EQ(traced.events.impacts, plain.events.impacts) << name;
    }
  }
}

TEST(ContactEngines, a_length_that_comes_only_once_moves_as_an_announced_one) {
  for (const EngineKind kind : {EngineKind::exact, EngineKind::cvode}) {
    for (const auto& [name, device] : testing::make_contact_devices()) {
      const Plant plant = build_moving_plant(build_device_network(device, FreeOperator{}));
      const auto engine = make_engine(kind, plant, {});
      const int whole = engine->prepare(2e-3);
      PlantState announced;
      announced.xi = plant.initial_state(0, 0.4);
      PlantState parts = announced;
      const Eigen::Vector2d u(-5e-3, 1e-3);
      for (int k = 0; k < 20; ++k) {
        engine->advance(whole, 2e-3 * k, u, announced);
        engine->advance_once(0.37e-3, 2e-3 * k, u, parts);
        engine->advance_once(2e-3 - 0.37e-3, 2e-3 * k + 0.37e-3, u, parts);
      }
      const double known_to = kind == EngineKind::exact ? 1e-11 : agreement;
      EXPECT_LE((announced.xi - parts.xi).norm(), known_to * (1 + announced.xi.norm())) << name;
      EXPECT_NEAR(parts.dissipated / announced.dissipated, 1, 10 * known_to) << name;
    }
  }
}

TEST(ContactEngines, a_smooth_law_beside_friction_is_for_cvode_and_closes_its_ledger) {
  Device device = testing::make_rc_display();
  device.mechanics.coulomb_friction = 5e-4;
  device.mechanics.stops =
      HardStops{.lower = -0.01, .upper = 0.01, .stiffness = 6, .damping = 2e-3};
  device.drive.motor->thermal = WindingThermal{.resistance = 8, .capacity = 1e-4};
  device.drive.damping.emplace_back(ClampDamping{.voltage = 0.02, .resistance = 0.1});
  const Plant plant = build_moving_plant(build_device_network(device, FreeOperator{}));
  EXPECT_EQ(choose_engine(plant), EngineKind::cvode);
  for (const EngineKind kind : {EngineKind::exact, EngineKind::odeint}) {
    try {
      (void)make_engine(kind, plant, {});
      ADD_FAILURE();
    } catch (const Error& error) {
      EXPECT_EQ(error.code(), ErrorCode::bad_input);
      EXPECT_NE(error.message().find("cvode"), std::string::npos);
    }
  }
  SimulationOptions options;
  options.duration = Rational(1, 10);
  options.initial_velocity = 3;
  const TimeRun r = run(device, EngineKind::cvode, options, VirtualWall{.stiffness = 0.05});
  EXPECT_GT(r.events.impacts, 0);
  EXPECT_LE(residual_of(r), agreement);
}

}  // namespace
}  // namespace gyrator
