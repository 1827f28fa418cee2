#include "gyrator/cosim/simulation.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "support/device_list.hpp"

// Dry friction and hard stops against closed forms, and the engines against each other.

namespace gyrator {
namespace {

using testing::make_p3;
using testing::make_rc_display;

const Sampling one_ms{Rational(1, 1000), 0};

constexpr double located = 1e-9;     // of the exact engine: rounding, and 2^-52 of a switching time
constexpr double integrated = 1e-6;  // of cvode at 1e-9 a step

double accuracy_of(EngineKind engine) {
  return engine == EngineKind::exact ? located : integrated;
}

// A block of 0.04 kg without any damping.
Device make_block(double sliding, double breakaway, double stribeck_velocity = 0) {
  Device device = make_p3();
  device.mechanics.damping = 0;
  device.mechanics.coulomb_friction = sliding;
  device.mechanics.stiction = breakaway;
  device.mechanics.stribeck_velocity = stribeck_velocity;
  return device;
}

TimeRun run(const Device& device, const SimulationOptions& options,
            const Operator& held_by = FreeOperator{}, const Controller& controller = NoController{},
            const Sensor& sensor = {}, const Sampling& sampling = one_ms) {
  const Plant plant = build_moving_plant(build_device_network(device, held_by));
  return simulate(plant, sensor, controller, sampling, options);
}

SimulationOptions make_options(EngineKind engine, const Rational& duration) {
  SimulationOptions options;
  options.engine = engine;
  options.duration = duration;
  return options;
}

void expect_closed_ledger(const TimeRun& r, EngineKind engine) {
  const EnergyLedger& e = r.energy;
  const double moved =
      std::abs(e.operator_work) + std::abs(e.source) + e.dissipated + e.stored + e.stored_initially;
  EXPECT_NEAR(e.residual, 0, (engine == EngineKind::exact ? 1e-12 : integrated) * moved);
  EXPECT_GE(e.dissipated, -1e-15 * moved);
}

class Contact : public ::testing::TestWithParam<EngineKind> {};

TEST_P(Contact, a_coasting_block_stops_in_finite_time_and_stays) {
  const Device device = make_block(0.3, 0.5);
  const double m = device.mechanics.inertia;
  SimulationOptions options = make_options(GetParam(), Rational(1, 4));
  for (const double v0 : {1.5, -1.5}) {
    options.initial_velocity = v0;
    const TimeRun r = run(device, options);
    const double stop = m * std::abs(v0) / 0.3;
    ASSERT_LT(stop, 0.21);
    for (std::size_t k = 0; k < r.trace.column("time_s").size(); ++k) {
      const double t = std::min(r.trace.column("time_s")[k], stop);
      const double way = std::copysign(1, v0);
      EXPECT_NEAR(r.trace.column("velocity")[k], way * (std::abs(v0) - 0.3 / m * t),
                  accuracy_of(GetParam()) * 1.5);
      EXPECT_NEAR(r.trace.column("position")[k], way * (std::abs(v0) * t - 0.15 / m * t * t),
                  accuracy_of(GetParam()));
    }
    EXPECT_EQ(r.trace.column("velocity").back(), 0);
    EXPECT_EQ(r.trace.column("friction").back(), 0);
    EXPECT_NEAR(r.trace.column("friction").front(), std::copysign(0.3, -v0), 1e-15);
    EXPECT_EQ(r.events.sticks, 1);
    EXPECT_EQ(r.events.slips, 0);
    EXPECT_NEAR(r.energy.dissipated, m / 2 * v0 * v0, accuracy_of(GetParam()) * m);
    expect_closed_ledger(r, GetParam());
  }
}

TEST_P(Contact, with_viscous_damping_it_stops_after_j_over_b_times_a_logarithm) {
  Device device = make_block(0.3, 0.3);
  device.mechanics.damping = 0.4;
  const double m = device.mechanics.inertia;
  const double b = 0.4;
  SimulationOptions options = make_options(GetParam(), Rational(1, 4));
  options.initial_velocity = 1.5;
  const TimeRun r = run(device, options);
  const double stop = m / b * std::log1p(b * 1.5 / 0.3);
  const auto travelled = [&](double t) {
    return (1.5 + 0.3 / b) * m / b * -std::expm1(-b / m * t) - 0.3 / b * t;
  };
  ASSERT_GT(stop, 0.1);
  ASSERT_LT(stop, 0.2);
  for (std::size_t k = 0; k < r.trace.column("time_s").size(); ++k) {
    const double t = r.trace.column("time_s")[k];
    EXPECT_NEAR(r.trace.column("position")[k], travelled(std::min(t, stop)),
                accuracy_of(GetParam()));
    const double v = t < stop ? (1.5 + 0.3 / b) * std::exp(-b / m * t) - 0.3 / b : 0;
    EXPECT_NEAR(r.trace.column("velocity")[k], v, accuracy_of(GetParam()) * 1.5);
  }
  EXPECT_EQ(r.trace.column("velocity").back(), 0);
  expect_closed_ledger(r, GetParam());
}

TEST_P(Contact, holds_an_effort_just_below_stiction_and_gives_way_just_above) {
  const double fs = 0.5;
  const Device device = make_block(0.3, fs);
  for (const double way : {1.0, -1.0}) {
    SimulationOptions options = make_options(GetParam(), Rational(1, 10));
    options.external_effort = way * fs * (1 - 1e-9);
    const TimeRun held = run(device, options);
    for (const double v : held.trace.column("velocity")) EXPECT_EQ(v, 0);
    for (const double x : held.trace.column("position")) EXPECT_EQ(x, 0);
    EXPECT_NEAR(held.trace.column("friction").back(), -options.external_effort, 1e-15);
    EXPECT_EQ(held.events.sticks + held.events.slips, 0);
    EXPECT_EQ(held.energy.dissipated, 0);

    options.external_effort = way * fs * (1 + 1e-9);
    const TimeRun slid = run(device, options);
    const double a = (fs * (1 + 1e-9) - 0.3) / device.mechanics.inertia;
    for (std::size_t k = 0; k < slid.trace.column("time_s").size(); ++k) {
      const double t = slid.trace.column("time_s")[k];
      EXPECT_NEAR(slid.trace.column("velocity")[k], way * a * t, accuracy_of(GetParam()));
    }
    EXPECT_EQ(slid.events.slips, 1);
    EXPECT_EQ(slid.events.sticks, 0);
    expect_closed_ledger(slid, GetParam());
  }
}

// A current amplifier of a few Hz makes the ramp: effort u (1 - e^(-t/T)).
TEST_P(Contact, a_shaft_pushed_by_a_ramp_sticks_until_f_s_and_then_slides_in_closed_form) {
  Device device = make_rc_display();
  device.drive.damping.clear();
  device.drive.amplifier = CurrentAmplifier{.bandwidth_hz = 3};
  device.mechanics.damping = 0;
  device.mechanics.coulomb_friction = 0.02;
  device.mechanics.stiction = 0.035;
  const Plant plant = build_moving_plant(build_device_network(device, FreeOperator{}));
  const auto engine = make_engine(GetParam(), plant, {});
  const int ms = engine->prepare(1e-3);
  const double u = 0.06;
  const double T = 1 / (2 * std::numbers::pi * 3);
  const double t1 = -T * std::log(1 - 0.035 / u);
  ASSERT_GT(t1, 0.04);
  const double J = device.mechanics.inertia;
  const double last =
      ((u - 0.02) * (0.1 - t1) + u * T * (std::exp(-0.1 / T) - std::exp(-t1 / T))) / J;
  for (const double way : {1.0, -1.0}) {
    PlantState state;
    state.xi = plant.initial_state(0, 0);
    for (int step = 1; step <= 100; ++step) {
      engine->advance(ms, 1e-3 * (step - 1), {way * u, 0}, state);
      const double t = 1e-3 * step;
      double v = 0;
      if (t > t1) v = ((u - 0.02) * (t - t1) + u * T * (std::exp(-t / T) - std::exp(-t1 / T))) / J;
      const Eigen::VectorXd& U = engine->inputs({way * u, 0}, state);
      EXPECT_NEAR(plant.port_velocity.value(state.xi, U), way * v, accuracy_of(GetParam()) * last);
      const double friction = t > t1 ? 0.02 : u * -std::expm1(-t / T);
      EXPECT_NEAR(U(NonlinearPart::friction_input), -way * friction, accuracy_of(GetParam()) * u);
    }
    EXPECT_EQ(state.events.slips, 1);
    EXPECT_EQ(state.events.sticks, 0);
  }
}

// Kelvin–Voigt contact: e = k q + d q' until e = 0.
TEST_P(Contact, bounces_from_a_stop_with_the_restitution_of_a_damped_contact) {
  for (const double d : {0.0, 0.5, 2.0}) {
    for (const double side : {1.0, -1.0}) {
      Device device = make_block(0, 0);
      const double m = device.mechanics.inertia;
      const double k = 4000;
      device.mechanics.stops =
          HardStops{.lower = -0.02, .upper = 0.02, .stiffness = k, .damping = d};
      SimulationOptions options = make_options(GetParam(), Rational(1, 20));
      options.initial_velocity = side * 1.0;
      const TimeRun r = run(device, options);
      // q = v/wd e^(-a t) sin(wd t); e = 0 first where tan(wd t) = -d wd/(k - d a), 0 < wd t < pi.
      const double a = d / (2 * m);
      const double wd = std::sqrt(k / m - a * a);
      const double t = std::atan2(d * wd, -(k - d * a)) / wd;
      const double q = std::exp(-a * t) * std::sin(wd * t) / wd;
      const double v = std::exp(-a * t) * (std::cos(wd * t) - a / wd * std::sin(wd * t));
      EXPECT_NEAR(k * q + d * v, 0, 1e-10);
      ASSERT_LT(v, 0);
      EXPECT_NEAR(r.trace.column("velocity").back(), side * v, accuracy_of(GetParam()));
      EXPECT_NEAR(r.trace.column("position").back(), side * (0.02 + q + v * (0.05 - 0.02 - t)),
                  accuracy_of(GetParam()));
      EXPECT_EQ(r.events.impacts, 1);
      EXPECT_NEAR(r.energy.dissipated, m / 2 * (1 - v * v), accuracy_of(GetParam()) * m);
      expect_closed_ledger(r, GetParam());
      const double most = *std::max_element(
          r.trace.column("stop_effort").begin(), r.trace.column("stop_effort").end(),
          [](double x, double y) { return std::abs(x) < std::abs(y); });
      EXPECT_LT(most * side, 0);  // pushes back
    }
  }
}

TEST_P(Contact, a_port_pressed_against_a_stop_rests_at_its_deflection) {
  Device device = make_block(0, 0);
  device.mechanics.damping = 2;
  device.mechanics.stops = HardStops{.lower = {}, .upper = 0.01, .stiffness = 500, .damping = 3};
  SimulationOptions options = make_options(GetParam(), Rational(2));
  options.external_effort = 1;
  const TimeRun r = run(device, options);
  EXPECT_NEAR(r.trace.column("position").back(), 0.01 + 1.0 / 500, integrated * 0.01);
  EXPECT_NEAR(r.trace.column("stop_effort").back(), -1, integrated);
  EXPECT_NEAR(r.energy.stored, 250 * std::pow(1.0 / 500, 2), integrated * 1e-3);
  expect_closed_ledger(r, GetParam());
}

TEST_P(Contact, dry_friction_ends_an_oscillation_with_even_losses) {
  // A spring wall without damping on the block: each half cycle loses 2 f_c/k of amplitude.
  const Device device = make_block(0.05, 0.05);
  const MassSpringDamper hand{.inertia = 0, .damping = 0, .stiffness = 100, .resonators = {}};
  SimulationOptions options = make_options(GetParam(), Rational(1));
  options.initial_position = 0.0103;
  const TimeRun r = run(device, options, hand);
  // 10.3, -9.3 … in steps of 1 mm: rests at the first turning point within f_s/k = 0.5 mm.
  EXPECT_NEAR(r.trace.column("position").back(), 0.0003, 0.0103 * accuracy_of(GetParam()));
  EXPECT_EQ(r.trace.column("velocity").back(), 0);
  expect_closed_ledger(r, GetParam());
}

std::string name_engine(const ::testing::TestParamInfo<EngineKind>& engine) {
  return engine.param == EngineKind::cvode ? "cvode" : "exact";
}
INSTANTIATE_TEST_SUITE_P(All, Contact, ::testing::Values(EngineKind::exact, EngineKind::cvode),
                         name_engine);

}  // namespace
}  // namespace gyrator
