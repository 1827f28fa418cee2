#include "gyrator/cosim/engine.hpp"
#include "gyrator/cosim/simulation.hpp"

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "support/contact_devices.hpp"
#include "support/device_list.hpp"

// One contract for every engine: whatever moves the plant, the run is the same.

namespace gyrator {
namespace {

struct Scenario {
  std::string name;
  VirtualWall wall;
  Rational delay_in_periods;
  Sensor sensor;
  double position, velocity, external_effort;
};

// Stiffness and effort that give the device a motion of some 10 Hz, in its own units.
std::vector<Scenario> make_scenarios(const Device& device) {
  const double J = device.mechanics.inertia;
  const double K = 4000 * J, B = 5 * J;  // 63 rad/s
  const VelocityEstimator filtered = FilteredDifferenceEstimator{120};
  const VirtualWall plain{.stiffness = K};
  const VirtualWall damped{.stiffness = K, .damping = B, .velocity = filtered};
  VirtualWall floor{.stiffness = 4 * K, .damping = B};
  floor.unilateral = true;
  return {
      {"spring", plain, 0, {}, 0, 1, 0},
      {"spring let go at rest", plain, 0, {}, 0.02, 0, 0},
      {"spring let go at rest, hardly away", plain, 0, {}, 5e-5, 0, 0},
      {"pushed from rest", plain, 0, {}, 0, 0, 50 * J},
      {"tiny motion from rest", plain, 0, {}, 0, 0, 5e-5 * J},
      {"spring and filtered damper, 0.3 periods late", damped, Rational(3, 10), {}, 0.01, 0.5, 0},
      {"exactly one period late", damped, 1, {}, 0.01, 0.5, 0},
      {"1.5 periods late", plain, Rational(3, 2), {}, 0, 1, 0},
      {"4.9 periods late", plain, Rational(49, 10), {}, 0, 1, 0},
      // Half a quantum of offset: no sample lies on an edge, where rounding would decide.
      {"quantized sensor", damped, Rational(1, 4), {.quantum = 1e-3, .offset = 5e-4}, 0, 1, 0},
      {"unilateral wall", floor, Rational(1, 2), {}, -0.01, 1, 0},
  };
}

TimeRun run(const Plant& plant, const Scenario& scenario, EngineKind engine) {
  const Rational period(1, 1000);
  SimulationOptions options;
  options.duration = Rational(40) * period;
  options.initial_position = scenario.position;
  options.initial_velocity = scenario.velocity;
  options.external_effort = scenario.external_effort;
  options.engine = engine;
  return simulate(plant, scenario.sensor, scenario.wall,
                  {period, scenario.delay_in_periods * period}, options);
}

double find_largest(const std::vector<double>& column) {
  double largest = 0;
  for (const double value : column) largest = std::max(largest, std::abs(value));
  return largest;
}

// What the engines promise of each other: a millionth of the largest position and velocity. The
// tolerance of cvode and odeint is 1e-9 a step, over 40 periods of some ten steps.
constexpr double agreement = 1e-6;

class EngineContract : public ::testing::TestWithParam<EngineKind> {};
// Those that are compared with the exact one.
class EngineAgreement : public ::testing::TestWithParam<EngineKind> {};

// `at_rest`: what counts as no motion where the exact run has none.
void expect_same_motion(const TimeRun& found, const TimeRun& exact, const std::string& where,
                        double at_rest = 0) {
  ASSERT_EQ(found.trace.names, exact.trace.names);
  for (const char* name : {"position", "velocity"}) {
    const auto& expected = exact.trace.column(name);
    const auto& column = found.trace.column(name);
    ASSERT_EQ(column.size(), expected.size());
    double worst = 0;
    for (std::size_t k = 0; k < column.size(); ++k) {
      worst = std::max(worst, std::abs(column[k] - expected[k]));
    }
    const double largest = find_largest(expected);
    EXPECT_LE(worst, std::max(agreement * largest, at_rest))
        << where << ": " << name << ", off by " << worst / largest;
  }
}

void expect_same_energies(const EnergyLedger& found, const EnergyLedger& exact,
                          const std::string& where) {
  const double largest = std::max({std::abs(exact.operator_work), std::abs(exact.source),
                                   exact.stored, exact.stored_initially, exact.dissipated});
  const double known_to = 2 * agreement * largest;  // twice: an energy is a square
  EXPECT_NEAR(found.operator_work, exact.operator_work, known_to) << where;
  EXPECT_NEAR(found.source, exact.source, known_to) << where;
  EXPECT_NEAR(found.stored, exact.stored, known_to) << where;
  EXPECT_NEAR(found.dissipated, exact.dissipated, known_to) << where;
}

TEST_P(EngineAgreement, every_device_moves_and_spends_its_energy_as_under_the_exact_engine) {
  for (const auto& [name, device] : testing::make_device_list()) {
    const Plant plant = build_plant(build_device_network(device, FreeOperator{}));
    for (const Scenario& scenario : make_scenarios(device)) {
      const TimeRun exact = run(plant, scenario, EngineKind::exact);
      const TimeRun other = run(plant, scenario, GetParam());
      const std::string where = name + "; " + scenario.name;
      ASSERT_GT(find_largest(exact.trace.column("velocity")), 0) << where;
      expect_same_motion(other, exact, where);
      expect_same_energies(other.energy, exact.energy, where);
    }
  }
}

// Held by friction, cvode's efforts balance to rounding; the exact engine's do by construction.
constexpr double rounding_at_rest = 1e-18;

// Odeint has no part in this: it refuses contacts.
TEST(ContactAgreement, every_device_with_contacts_moves_under_cvode_as_under_the_exact_engine) {
  for (const auto& [name, device] : testing::make_contact_devices()) {
    const Plant plant = build_moving_plant(build_device_network(device, FreeOperator{}));
    for (const Scenario& scenario : make_scenarios(device)) {
      const TimeRun exact = run(plant, scenario, EngineKind::exact);
      const TimeRun other = run(plant, scenario, EngineKind::cvode);
      const std::string where = name + "; " + scenario.name;
      expect_same_motion(other, exact, where, rounding_at_rest);
      expect_same_energies(other.energy, exact.energy, where);
      EXPECT_EQ(other.events.slips, exact.events.slips) << where;
      EXPECT_EQ(other.events.impacts, exact.events.impacts) << where;
    }
  }
}

TEST_P(EngineContract, moves_nothing_in_no_time) {
  const Plant plant = build_plant(build_device_network(testing::make_rc_display(), FreeOperator{}));
  const auto engine = make_engine(GetParam(), plant, {});
  const int nothing = engine->prepare(0);
  PlantState state;
  state.xi = plant.initial_state(0.1, 2);
  engine->advance(nothing, 0, {0.3, -0.1}, state);
  EXPECT_LE((state.xi - plant.initial_state(0.1, 2)).norm(), 1e-15);
  EXPECT_EQ(state.dissipated, 0);
  EXPECT_EQ(state.source_work, 0);
}

TEST_P(EngineContract, keeps_every_announced_segment_apart) {
  const Plant plant = build_plant(build_device_network(testing::make_p3(), FreeOperator{}));
  const auto engine = make_engine(GetParam(), plant, {});
  const int half = engine->prepare(0.5e-3);
  const int whole = engine->prepare(1e-3);
  PlantState once;
  once.xi = plant.initial_state(0, 1);
  PlantState twice = once;
  const Eigen::Vector2d u(0.2, -0.7);
  engine->advance(whole, 0, u, once);
  engine->advance(half, 0, u, twice);
  engine->advance(half, 0.5e-3, u, twice);
  EXPECT_LE((once.xi - twice.xi).norm(), 1e-8 * once.xi.norm());  // some steps of 1e-9
  EXPECT_NEAR(twice.dissipated / once.dissipated, 1, 1e-7);
}

TEST_P(EngineContract, a_length_that_comes_only_once_moves_and_books_as_an_announced_one) {
  const Plant plant = build_plant(build_device_network(testing::make_rc_display(), FreeOperator{}));
  const auto engine = make_engine(GetParam(), plant, {});
  const int whole = engine->prepare(1e-3);
  PlantState announced;
  announced.xi = plant.initial_state(0, 1);
  PlantState jittered = announced;
  const Eigen::Vector2d u(0.02, -0.003);
  for (int k = 0; k < 10; ++k) engine->advance(whole, 1e-3 * k, u, announced);
  double time = 0;
  for (const double length : {0.3e-3, 1.7e-3, 1e-9, 2.9e-3, 1e-3 - 1e-9, 1.1e-3, 3e-3}) {
    engine->advance_once(length, time, u, jittered);
    time += length;
  }
  ASSERT_NEAR(time, 10e-3, 1e-17);
  const double known_to = GetParam() == EngineKind::exact ? 1e-13 : 1e-7;
  EXPECT_LE((announced.xi - jittered.xi).norm(), known_to * announced.xi.norm());
  EXPECT_NEAR(jittered.dissipated / announced.dissipated, 1, known_to);
  EXPECT_NEAR(jittered.source_work / announced.source_work, 1, known_to);
  EXPECT_NEAR(jittered.operator_work / announced.operator_work, 1, known_to);
}

TEST_P(EngineContract, without_a_ledger_books_nothing_and_moves_alike) {
  const Plant plant = build_plant(build_device_network(testing::make_rc_display(), FreeOperator{}));
  const auto with = make_engine(GetParam(), plant, {});
  const auto without = make_engine(GetParam(), plant, {.ledger = false});
  PlantState booked;
  booked.xi = plant.initial_state(0, 1);
  PlantState unbooked = booked;
  with->advance(with->prepare(1e-3), 0, {0.01, 0}, booked);
  without->advance(without->prepare(1e-3), 0, {0.01, 0}, unbooked);
  EXPECT_EQ(unbooked.dissipated, 0);
  EXPECT_EQ(unbooked.source_work, 0);
  EXPECT_GT(booked.dissipated, 0);
  EXPECT_LE((booked.xi - unbooked.xi).norm(), 1e-7 * booked.xi.norm());
}

std::string name_engine(const ::testing::TestParamInfo<EngineKind>& engine) {
  switch (engine.param) {
    case EngineKind::cvode:
      return "cvode";
    case EngineKind::odeint:
      return "odeint";
    case EngineKind::exact:
      break;
  }
  return "exact";
}
INSTANTIATE_TEST_SUITE_P(All, EngineContract,
                         ::testing::Values(EngineKind::exact, EngineKind::cvode,
                                           EngineKind::odeint),
                         name_engine);
INSTANTIATE_TEST_SUITE_P(All, EngineAgreement,
                         ::testing::Values(EngineKind::cvode, EngineKind::odeint), name_engine);

}  // namespace
}  // namespace gyrator
