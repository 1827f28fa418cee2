#include "gyrator/circuits/spice_subcircuit.hpp"
#include "gyrator/core/error.hpp"
#include "gyrator/cosim/simulation.hpp"

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "support/nonlinear_devices.hpp"

// Motion beyond what is linear, against closed forms; and the ledger of every nonlinear drive.

namespace gyrator {
namespace {

using testing::make_nonlinear_devices;
using testing::make_p3;
using testing::make_rc_display;

const Sampling one_ms{Rational(1, 1000), 0};

// cvode's tolerance of 1e-9 a step, over some hundred steps that each add to the error.
constexpr double integrated = 1e-6;

TimeRun run(const Device& device, const Operator& held_by, const Controller& controller,
            const SimulationOptions& given, const Sensor& sensor = {}) {
  const Plant plant = build_moving_plant(build_device_network(device, held_by));
  SimulationOptions options = given;
  options.engine = choose_engine(plant);
  return simulate(plant, sensor, controller, one_ms, options);
}

TEST(Nonlinear, a_friction_brake_holds_back_evenly_and_then_like_a_damper) {
  Device device = make_p3();
  device.mechanics.damping = 0;
  const double m = device.mechanics.inertia;
  const FrictionBrake brake{.damping = 2, .effort = 0.5};
  device.drive.damping = {brake};
  SimulationOptions options;
  options.duration = Rational(1, 5);
  options.initial_velocity = 1.5;
  const TimeRun r = run(device, FreeOperator{}, NoController{}, options);
  // m dv/dt = -f_c down to v_1 = f_c/b at t_1, then -b v
  const double v1 = brake.effort / brake.damping;
  const double t1 = m * (options.initial_velocity - v1) / brake.effort;
  EXPECT_GT(t1, 0.05);
  EXPECT_LT(t1, 0.15);
  const auto& time = r.trace.column("time_s");
  const auto& velocity = r.trace.column("velocity");
  for (std::size_t k = 0; k < time.size(); ++k) {
    const double t = time[k];
    const double v = t < t1 ? options.initial_velocity - brake.effort / m * t
                            : v1 * std::exp(-brake.damping / m * (t - t1));
    EXPECT_NEAR(velocity[k], v, integrated * options.initial_velocity) << t;
  }
  EXPECT_NEAR(r.energy.dissipated, m / 2 * (1.5 * 1.5 - std::pow(velocity.back(), 2)), 1e-6 * m);
}

TEST(Nonlinear, a_clamp_bounds_the_voltage_of_a_motor_that_is_driven_from_behind) {
  Device device = make_rc_display();
  device.drive.motor->inductance = 0;
  device.drive.amplifier = IdealDrive{};
  device.drive.damping = {ClampDamping{.voltage = 2, .resistance = 0.5}};
  device.mechanics.damping = 0;
  SimulationOptions options;
  options.duration = Rational(1, 10);
  options.initial_velocity = 100;  // 5 V of back-EMF
  const TimeRun r = run(device, FreeOperator{}, NoController{}, options);
  // J dv/dt = -K (K v - V)/(R + r) for K v > V: down to V/K and no further.
  const double K = 0.05;
  const double rate = K * K / ((1.5 + 0.5) * device.mechanics.inertia);
  const auto& time = r.trace.column("time_s");
  for (std::size_t k = 0; k < time.size(); ++k) {
    const double v = 2 / K + (100 - 2 / K) * std::exp(-rate * time[k]);
    EXPECT_NEAR(r.trace.column("velocity")[k], v, integrated * 100) << time[k];
    const double voltage = 2 + 0.5 * (K * v - 2) / 2;
    EXPECT_NEAR(r.trace.column("voltage")[k], voltage, integrated * 5) << time[k];
  }
}

TEST(Nonlinear, antiparallel_diodes_of_a_netlist_bound_a_motors_voltage) {
  Device device = make_rc_display();
  device.drive.motor->inductance = 0;
  device.drive.amplifier = IdealDrive{};
  device.drive.damping = {NetlistDamping{parse_subcircuit(
      "* clamp\n.model X D(Is=1n N=1.5)\n.subckt c a b\nD1 a b X\nD2 b a X\n.ends\n", "c.cir",
      "c")}};
  device.mechanics.damping = 0;
  const double K = 0.05;
  const double R = 1.5;
  const double Is = 1e-9;
  const double Ve = 1.5 * 1.380649e-23 * 300.15 / 1.602176634e-19;
  for (const double start : {100.0, -100.0}) {  // 5 V of back-EMF
    SimulationOptions options;
    options.duration = Rational(1, 20);
    options.initial_velocity = start;
    const TimeRun r = run(device, FreeOperator{}, NoController{}, options);
    const auto& voltage = r.trace.column("voltage");
    const auto& velocity = r.trace.column("velocity");
    // K |v| / R is more than ever flows.
    const double most = Ve * std::log1p(K * 100 / R / Is);
    EXPECT_LT(most, 0.9);
    for (std::size_t k = 0; k < voltage.size(); ++k) {
      EXPECT_LT(std::abs(voltage[k]), most);
      // What the winding feeds is what both diodes take: 2 Is sinh(v/Ve).
      const double i = (K * velocity[k] - voltage[k]) / R;
      EXPECT_NEAR(voltage[k], Ve * std::asinh(i / (2 * Is)), integrated * most) << k;
    }
    EXPECT_GT(std::abs(voltage.front()), 0.7);
    const double moved = r.energy.dissipated;
    EXPECT_NEAR(moved, device.mechanics.inertia / 2 * (1e4 - std::pow(velocity.back(), 2)),
                1e-6 * moved);
    EXPECT_LT(std::abs(r.energy.residual), 1e-6 * moved);
  }
}

TEST(Nonlinear, a_saturated_current_amplifier_accelerates_evenly) {
  Device device = make_rc_display();
  device.drive.damping.clear();
  device.mechanics.damping = 0;
  device.drive.amplifier = CurrentAmplifier{.bandwidth_hz = {}, .current_limit = 2};
  SimulationOptions options;
  options.duration = Rational(1, 50);
  options.initial_position = 10;
  const TimeRun r = run(device, FreeOperator{}, VirtualWall{.stiffness = 1}, options);
  const double a = 2 * 0.05 / device.mechanics.inertia;
  const auto& time = r.trace.column("time_s");
  for (std::size_t k = 0; k < time.size(); ++k) {
    ASSERT_GT(r.trace.column("position")[k], 0.1);  // 10 N.m asked for, 0.1 N.m given
    EXPECT_NEAR(r.trace.column("velocity")[k], -a * time[k], integrated * a * 0.02);
    EXPECT_NEAR(r.trace.column("current")[k], k == 0 ? 0 : -2, 1e-9);
  }
}

// A wall that sees a clamped port one unit outside asks for an even effort, its stiffness.
TimeRun push(const Device& device, double effort, const Rational& duration) {
  SimulationOptions options;
  options.duration = duration;
  return run(device, ClampedOperator{}, VirtualWall{.stiffness = effort}, options,
             {.quantum = 0, .offset = -1});
}

TEST(Nonlinear, the_supply_bounds_how_fast_the_current_rises) {
  Device device = make_rc_display();
  device.drive.damping.clear();
  device.drive.amplifier = CurrentAmplifier{.bandwidth_hz = {}, .voltage_limit = 6};
  const TimeRun r = push(device, 3 * 0.05, Rational(1, 250));
  // 3 A wanted; L di/dt + R i = V + r (3 - i) until they flow
  const double L = 0.5e-3;
  const double R = 1.5 + rail_resistance;
  const double end = (6 + rail_resistance * 3) / R;
  const auto& time = r.trace.column("time_s");
  for (std::size_t k = 0; k < time.size(); ++k) {
    const double i = std::min(3.0, end * (1 - std::exp(-R / L * time[k])));
    // Once the rails are off, their leak of 1e-9 / r draws 4.5 V of them.
    EXPECT_NEAR(r.trace.column("current")[k], i, integrated * 3) << time[k];
  }
  EXPECT_NEAR(r.trace.column("current").back(), 3, integrated * 3);
}

TEST(Nonlinear, a_winding_warms_to_its_steady_rise_or_runs_away) {
  const double R = 1.5;
  const double a = copper_temperature_coefficient;
  const WindingThermal thermal{.resistance = 5, .capacity = 0.02};
  // a R_0 i^2 R_th is 1 at 5.8 A: below, near and above it.
  const double limit = 1 / std::sqrt(a * R * thermal.resistance);
  for (const double part : {0.3, 0.95, 1.05, 1.5}) {
    Device device = make_rc_display();
    device.drive.damping.clear();
    device.drive.motor->thermal = thermal;
    device.drive.motor->temperature_rise = 10;
    const double i = part * limit;
    const TimeRun r = push(device, 0.05 * i, Rational(1, 5));
    // C dh/dt = R i^2 + (a R i^2 - 1/R_th) h
    const double rate = (a * R * i * i - 1 / thermal.resistance) / thermal.capacity;
    const double gain = R * i * i / thermal.capacity;
    const auto& time = r.trace.column("time_s");
    const auto& rise = r.trace.column("winding_temperature_rise");
    for (std::size_t k = 0; k < time.size(); ++k) {
      const double h = 10 * std::exp(rate * time[k]) + gain / rate * std::expm1(rate * time[k]);
      EXPECT_NEAR(rise[k] / h, 1, integrated) << part << " at " << time[k];
      // The scale of the amplifier does not follow the winding.
      EXPECT_NEAR(r.trace.column("current")[k], k == 0 ? 0 : i, 1e-9 * i);
    }
    EXPECT_EQ(rate > 0, part > 1);
    EXPECT_NEAR(r.energy.residual, 0, integrated * r.energy.source);
  }
}

// The same device by linear means: exactly, with limits out of reach and brakes as dampers.
TEST(Nonlinear, equals_the_exact_linear_run_where_no_law_bends) {
  Device linear = make_rc_display();
  linear.drive.damping.emplace_back(EddyCurrentBrake{.damping = 1e-4});
  linear.drive.damping.emplace_back(ResistorDamping{1 / ClampDamping::leakage});
  Device limited = make_rc_display();
  limited.drive.damping.emplace_back(FrictionBrake{.damping = 1e-4, .effort = 1});
  limited.drive.damping.emplace_back(ClampDamping{.voltage = 24});
  const std::vector<std::pair<Amplifier, Amplifier>> amplifiers{
      {CurrentAmplifier{},
       CurrentAmplifier{.bandwidth_hz = {}, .current_limit = 5, .voltage_limit = 24}},
      {CurrentAmplifier{.bandwidth_hz = 300},
       CurrentAmplifier{.bandwidth_hz = 300, .current_limit = 5, .voltage_limit = 24}},
      {CurrentAmplifier{.bandwidth_hz = 100, .sense = CurrentSense::motor},
       CurrentAmplifier{.bandwidth_hz = 100,
                        .sense = CurrentSense::motor,
                        .current_limit = 5,
                        .voltage_limit = 24}},
      {VoltageAmplifier{.bandwidth_hz = 800, .output_resistance = 0.5},
       VoltageAmplifier{
           .bandwidth_hz = 800, .output_resistance = 0.5, .current_limit = 5, .voltage_limit = 24}},
  };
  for (const auto& [plain, bounded] : amplifiers) {
    linear.drive.amplifier = plain;
    limited.drive.amplifier = bounded;
    SimulationOptions options;
    options.duration = Rational(1, 20);
    options.initial_velocity = 1;
    const VirtualWall wall{.stiffness = 0.05, .damping = 1e-4};
    const TimeRun expected = run(linear, FreeOperator{}, wall, options);
    const TimeRun found = run(limited, FreeOperator{}, wall, options);
    for (const char* name : {"position", "velocity", "current"}) {
      double worst = 0;
      double largest = 0;
      for (std::size_t k = 0; k < expected.trace.column(name).size(); ++k) {
        const double value = expected.trace.column(name)[k];
        worst = std::max(worst, std::abs(found.trace.column(name)[k] - value));
        largest = std::max(largest, std::abs(value));
      }
      EXPECT_LE(worst, 1e-6 * largest) << plain.index() << ' ' << name;
    }
    EXPECT_NEAR(found.energy.dissipated, expected.energy.dissipated,
                2e-6 * expected.energy.stored_initially);
    EXPECT_NEAR(found.energy.source, expected.energy.source,
                2e-6 * expected.energy.stored_initially);
  }
}

TEST(Nonlinear, the_ledger_closes_for_every_nonlinear_drive) {
  const MassSpringDamper hand{.inertia = 3e-5, .damping = 2e-4, .stiffness = 0.3, .resonators = {}};
  for (const auto& [name, device] : make_nonlinear_devices()) {
    for (const Operator& held_by : {Operator{FreeOperator{}}, Operator{hand}}) {
      SimulationOptions options;
      options.duration = Rational(1, 20);
      options.initial_velocity = 1;
      options.external_effort = 2e-4;
      const TimeRun r =
          run(device, held_by, VirtualWall{.stiffness = 0.08, .damping = 1e-4}, options);
      const EnergyLedger& e = r.energy;
      const double moved = std::abs(e.operator_work) + std::abs(e.source) + e.dissipated;
      EXPECT_GT(moved, 1e-6) << name;
      EXPECT_NEAR(e.residual, 0, integrated * moved) << name;
      EXPECT_GE(e.dissipated, 0) << name;
      for (const auto& column : r.trace.columns) {
        for (const double value : column) ASSERT_TRUE(std::isfinite(value)) << name;
      }
    }
  }
}

TEST(Nonlinear, differs_from_the_linear_run_where_laws_bend) {
  // The devices of the list really leave their linear region.
  for (const auto& [name, device] : make_nonlinear_devices()) {
    SimulationOptions options;
    options.duration = Rational(1, 20);
    options.initial_velocity = 1;
    const VirtualWall wall{.stiffness = 0.08};
    const DeviceNetwork network = build_device_network(device, FreeOperator{});
    options.engine = EngineKind::exact;
    const TimeRun tangent = simulate(build_plant(network), {}, wall, one_ms, options);
    const TimeRun found = run(device, FreeOperator{}, wall, options);
    double worst = 0;
    for (std::size_t k = 0; k < found.trace.column("velocity").size(); ++k) {
      worst = std::max(
          worst, std::abs(found.trace.column("velocity")[k] - tangent.trace.column("velocity")[k]));
    }
    EXPECT_GT(worst, 1e-4) << name;
  }
}

TEST(Nonlinear, cvode_comes_closer_as_its_tolerance_shrinks) {
  Device device = make_p3();
  device.mechanics.damping = 0;
  device.drive.damping = {FrictionBrake{.damping = 2, .effort = 0.5}};
  const Plant plant = build_moving_plant(build_device_network(device, FreeOperator{}));
  const double v1 = 0.25;
  const double t1 = 0.04 * (1.5 - v1) / 0.5;
  const double expected = v1 * std::exp(-2 / 0.04 * (0.2 - t1));
  double before = INFINITY;
  for (const double tolerance : {1e-4, 1e-6, 1e-8, 1e-10}) {
    SimulationOptions options;
    options.duration = Rational(1, 5);
    options.initial_velocity = 1.5;
    options.engine = EngineKind::cvode;
    options.engine_options.relative_tolerance = tolerance;
    const TimeRun r = simulate(plant, {}, NoController{}, one_ms, options);
    const double error = std::abs(r.trace.column("velocity").back() - expected);
    EXPECT_LE(error, 100 * tolerance) << tolerance;  // what some hundred steps may add up to
    EXPECT_LE(error, std::max(before, 1e-12)) << tolerance;
    before = error;
  }
}

TEST(Nonlinear, odeint_and_cvode_move_and_book_alike) {
  for (const auto& [name, device] : make_nonlinear_devices()) {
    const auto* current = std::get_if<CurrentAmplifier>(&device.drive.amplifier);
    // Rails on an inductive node are stiff as their leak: not for an explicit method.
    if (name == "clamp" || (current && current->voltage_limit)) continue;
    const Plant plant = build_moving_plant(build_device_network(device, FreeOperator{}));
    SimulationOptions options;
    options.duration = Rational(1, 50);
    options.initial_velocity = 1;
    const VirtualWall wall{.stiffness = 0.08};
    options.engine = EngineKind::odeint;
    const TimeRun one = simulate(plant, {}, wall, one_ms, options);
    options.engine = EngineKind::cvode;
    const TimeRun other = simulate(plant, {}, wall, one_ms, options);
    for (std::size_t k = 0; k < one.trace.column("velocity").size(); ++k) {
      EXPECT_NEAR(one.trace.column("velocity")[k], other.trace.column("velocity")[k], integrated)
          << name;
    }
    EXPECT_NEAR(one.energy.dissipated, other.energy.dissipated, integrated * 1e-5) << name;
    EXPECT_NEAR(one.energy.source, other.energy.source, integrated * 1e-5) << name;
  }
}

TEST(Nonlinear, the_exact_engine_refuses_what_is_not_linear_in_pieces_and_names_it) {
  for (const auto& [name, device] : make_nonlinear_devices()) {
    const Plant plant = build_moving_plant(build_device_network(device, FreeOperator{}));
    std::string smooth;
    for (const NonlinearPort& port : plant.nonlinear->ports) {
      if (smooth.empty() && !is_piecewise_linear(port.law)) smooth = port.element;
    }
    EXPECT_EQ(choose_engine(plant), smooth.empty() ? EngineKind::exact : EngineKind::cvode) << name;
    if (smooth.empty()) continue;
    try {
      (void)make_engine(EngineKind::exact, plant, {});
      ADD_FAILURE() << name;
    } catch (const Error& error) {
      EXPECT_EQ(error.code(), ErrorCode::bad_input) << name;
      EXPECT_NE(error.message().find(smooth), std::string::npos) << name;
    }
  }
  EXPECT_EQ(choose_engine(build_moving_plant(build_device_network(make_rc_display(), {}))),
            EngineKind::exact);
}

TEST(Nonlinear, a_constant_source_holds_its_steady_state_from_the_start) {
  DeviceNetwork network = build_device_network(make_rc_display(), ClampedOperator{});
  network.network.add("bias", ground, *network.drive.terminal, ConstantCurrentSource{0.5});
  const Plant plant = build_moving_plant(network);
  SimulationOptions options;
  options.duration = Rational(1, 50);
  options.engine = choose_engine(plant);
  const TimeRun r = simulate(plant, {}, NoController{}, one_ms, options);
  for (std::size_t k = 0; k < r.trace.column("time_s").size(); ++k) {
    EXPECT_NEAR(r.trace.column("current")[k], 0.5, integrated);
    EXPECT_NEAR(r.trace.column("voltage")[k], 0.75, integrated);
  }
  EXPECT_NEAR(r.energy.source / (0.5 * 0.75 * 0.02), 1, integrated);
  EXPECT_NEAR(r.energy.residual / r.energy.source, 0, integrated);
}

TEST(Nonlinear, a_cancellation_diverges_once_its_winding_has_cooled_below_it) {
  Device device = make_rc_display();
  device.drive.damping = {ResistanceCancellation{.resistance = 1.02 * 1.5, .bandwidth_hz = {}}};
  device.drive.amplifier = VoltageAmplifier{};
  device.drive.motor->temperature_rise = 30;  // R = 1.118 R_0
  const auto current_of = [&](double capacity) {
    device.drive.motor->thermal = WindingThermal{.resistance = 1, .capacity = capacity};
    return push(device, 1e-10, Rational(1));
  };
  // Time constants of 0.2 s and of 200 s: it cools across 5.1 K, where R = 1.02 R_0, or hardly.
  const TimeRun cooled = current_of(0.2);
  const TimeRun warm = current_of(200);
  const double wanted = std::abs(warm.trace.column("current").back());
  EXPECT_LT(warm.trace.column("winding_temperature_rise").back(), 30);
  EXPECT_GT(warm.trace.column("winding_temperature_rise").back(), 29);
  EXPECT_LT(cooled.trace.column("winding_temperature_rise").back(), 5);
  EXPECT_GT(std::abs(cooled.trace.column("current").back()), 1000 * wanted);
  // and still grows: L di/dt = (R_c - R) i
  const auto& current = cooled.trace.column("current");
  const double growth = std::abs(current.back() / current[current.size() - 11]);
  const double rise = cooled.trace.column("winding_temperature_rise").back();
  const double rate = 1.5 * (0.02 - copper_temperature_coefficient * rise) / 0.5e-3;
  EXPECT_GT(rate, 10);
  EXPECT_NEAR(std::log(growth) / (rate * 0.01), 1, 0.2);  // the rise falls on the way
}

}  // namespace
}  // namespace gyrator
