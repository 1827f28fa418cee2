#include "gyrator/cosim/simulation.hpp"

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "support/device_list.hpp"

// What the ledger books: it closes for every device and engine, and each entry is what it says.

namespace gyrator {
namespace {

using testing::make_device_list;
using testing::make_p3;
using testing::make_rc_display;
using testing::make_re25;

const Sampling one_ms{Rational(1, 1000), 0};

// The largest amount of energy that any entry of the ledger ever held.
double find_largest_flow(const TimeRun& run) {
  double largest = 0;
  for (const char* name :
       {"energy_operator", "energy_source", "energy_stored", "energy_dissipated"}) {
    for (const double energy : run.trace.column(name)) {
      largest = std::max(largest, std::abs(energy));
    }
  }
  return largest;
}

void expect_closed(const Device& device, const Operator& held_by, EngineKind engine,
                   double tolerance, const std::string& where) {
  const double J = device.mechanics.inertia;
  const VirtualWall wall{.stiffness = 4000 * J, .damping = 5 * J};
  SimulationOptions options;
  options.duration = Rational(1, 20);
  options.initial_velocity = 1;
  options.initial_position = 0.005;
  options.external_effort = 10 * J;
  options.engine = engine;
  const TimeRun run = simulate(build_plant(build_device_network(device, held_by)), {}, wall,
                               {Rational(1, 1000), Rational(3, 10000)}, options);
  const EnergyLedger& e = run.energy;
  EXPECT_EQ(e.residual,
            e.operator_work + e.source - (e.stored - e.stored_initially) - e.dissipated);
  EXPECT_NEAR(e.residual, 0, tolerance * find_largest_flow(run)) << where;
}

TEST(EnergyLedger, closes_to_rounding_under_the_exact_engine) {
  const MassSpringDamper hand{
      .inertia = 3e-5, .damping = 2e-4, .stiffness = 0.3, .resonators = {{1e-5, 0.2}}};
  for (const auto& [name, device] : make_device_list()) {
    // Some hundred quadratic forms, each known to rounding of its terms.
    expect_closed(device, FreeOperator{}, EngineKind::exact, 1e-12, name + ", free");
    expect_closed(device, hand, EngineKind::exact, 1e-12, name + ", held");
  }
}

TEST(EnergyLedger, closes_to_the_tolerance_of_the_integrating_engines) {
  for (const auto& [name, device] : make_device_list()) {
    // 1e-9 of the largest energy each step, over 100 segments of some ten steps.
    expect_closed(device, FreeOperator{}, EngineKind::cvode, 1e-6, name + ", cvode");
    expect_closed(device, FreeOperator{}, EngineKind::odeint, 1e-6, name + ", odeint");
  }
}

TEST(EnergyLedger, closes_around_an_analog_loop_that_works_without_a_command) {
  // Started off the centre at rest: what the loop gives is booked as the source's work.
  const MassSpringDamper hand{.inertia = 3e-5, .damping = 2e-4, .stiffness = 0.3, .resonators = {}};
  for (const auto& [name, device] : testing::make_held_devices()) {
    for (const Operator& held_by : {Operator{FreeOperator{}}, Operator{hand}}) {
      for (const auto& [engine, tolerance] :
           {std::pair{EngineKind::exact, 1e-12}, std::pair{EngineKind::cvode, 1e-6}}) {
        SimulationOptions options;
        options.duration = Rational(1, 20);
        options.initial_position = 0.02;
        options.engine = engine;
        const TimeRun run = simulate(build_plant(build_device_network(device, held_by)), {},
                                     NoController{}, one_ms, options);
        EXPECT_DOUBLE_EQ(run.trace.column("position").front(), 0.02) << name;
        EXPECT_GT(std::abs(run.energy.source), 1e-8) << name;
        EXPECT_NEAR(run.energy.residual, 0, tolerance * find_largest_flow(run)) << name;
      }
    }
  }
}

TEST(EnergyLedger, closes_where_an_ideal_loop_around_the_motor_current_meets_a_damping_branch) {
  // A step of the command is an impulse of voltage at the branch; the motion knows nothing of it.
  for (const Damping& damping : {Damping{ResistorDamping{10}},
                                 Damping{RcDamping{.resistance = 5, .capacitance = 2200e-6}}}) {
    Device device = make_rc_display();
    device.drive.amplifier = CurrentAmplifier{.bandwidth_hz = {}, .sense = CurrentSense::motor};
    device.drive.damping = {damping};
    expect_closed(device, FreeOperator{}, EngineKind::exact, 1e-12,
                  std::holds_alternative<ResistorDamping>(damping) ? "resistor" : "rc");
  }
}

TEST(EnergyLedger, a_coasting_mass_turns_its_motion_into_heat) {
  constexpr double m = 0.04, b = 0.8;
  SimulationOptions options;
  options.duration = Rational(1, 10);
  options.initial_velocity = 1.5;
  const TimeRun run = simulate(build_plant(build_device_network(make_p3(), FreeOperator{})), {},
                               NoController{}, one_ms, options);
  const double start = m * 1.5 * 1.5 / 2;
  EXPECT_NEAR(run.energy.stored_initially / start, 1, 1e-14);
  for (const double t : {0.01, 0.05, 0.1}) {
    const auto row = static_cast<std::size_t>(std::lround(t * 1000));
    const double lost = -start * std::expm1(-2 * b / m * t);
    EXPECT_NEAR(run.trace.column("energy_dissipated")[row] / lost, 1, 1e-12) << t;
    EXPECT_NEAR(run.trace.column("energy_stored")[row] / (start - lost), 1, 1e-12) << t;
  }
  EXPECT_EQ(run.energy.source, 0);
  EXPECT_EQ(run.energy.operator_work, 0);
}

TEST(EnergyLedger, a_steady_push_works_by_effort_times_path) {
  for (const auto& [name, device] : make_device_list()) {
    const double F = 50 * device.mechanics.inertia;
    SimulationOptions options;
    options.duration = Rational(1, 10);
    options.external_effort = F;
    options.initial_position = 0.003;
    const TimeRun run = simulate(build_plant(build_device_network(device, FreeOperator{})), {},
                                 NoController{}, one_ms, options);
    const double path = run.trace.column("position").back() - 0.003;
    // The path is a difference of positions of the same size: some digits less than rounding.
    EXPECT_NEAR(run.energy.operator_work / (F * path), 1, 1e-10) << name;
  }
}

TEST(EnergyLedger, a_lossless_hand_gives_and_takes_back_what_its_spring_and_mass_hold) {
  const MassSpringDamper hand{.inertia = 0.06, .damping = 0, .stiffness = 250, .resonators = {}};
  SimulationOptions options;
  options.initial_position = 0.02;
  const TimeRun run = simulate(build_plant(build_device_network(make_p3(), hand)), {},
                               NoController{}, one_ms, options);
  for (std::size_t k = 0; k < run.trace.column("position").size(); k += 25) {
    const double x = run.trace.column("position")[k], v = run.trace.column("velocity")[k];
    const double holds = 0.06 * v * v / 2 + 250 * x * x / 2;
    const double given = run.trace.column("energy_operator")[k];
    EXPECT_NEAR(given + holds, 250 * 0.02 * 0.02 / 2, 1e-13) << k;
  }
}

TEST(EnergyLedger, the_source_pays_for_what_a_jump_of_current_puts_into_the_winding) {
  // Ideal current into a winding without damping (index 2): at each jump L (i_2^2 - i_1^2)/2, and
  // in between R i^2 of heat and K_t i of effort at the shaft.
  const Device device = make_re25();
  constexpr double K_t = 23.5e-3, R = 2.06, L = 0.238e-3, J = 1.07e-6;
  SimulationOptions options;
  options.duration = Rational(1, 20);
  options.initial_velocity = 1;
  const TimeRun run = simulate(build_plant(build_device_network(device, FreeOperator{})), {},
                               VirtualWall{.stiffness = 4000 * J}, one_ms, options);
  const auto& command = run.trace.column("command");
  const auto& x = run.trace.column("position");
  const auto& source = run.trace.column("energy_source");
  const auto& stored = run.trace.column("energy_stored");
  double paid = 0;
  double jumps = 0;
  for (std::size_t k = 0; k + 1 < command.size(); ++k) {
    const double i_1 = k > 0 ? command[k - 1] / K_t : 0;
    const double i_2 = command[k] / K_t;
    jumps += std::abs(L * (i_2 * i_2 - i_1 * i_1) / 2);
    paid += L * (i_2 * i_2 - i_1 * i_1) / 2 + R * i_2 * i_2 * 1e-3 + K_t * i_2 * (x[k + 1] - x[k]);
    ASSERT_NEAR(source[k + 1], paid, 1e-11 * find_largest_flow(run)) << k;
    // The row is before the jump: the winding still holds the old current.
    const double v = run.trace.column("velocity")[k];
    ASSERT_NEAR(stored[k], J * v * v / 2 + L * i_1 * i_1 / 2, 1e-12 * find_largest_flow(run)) << k;
  }
  EXPECT_GT(jumps, 1e-4 * find_largest_flow(run)) << "jumps too small for this test to see";
  EXPECT_NEAR(run.energy.residual, 0, 1e-12 * find_largest_flow(run));
}

TEST(EnergyLedger, a_sampled_wall_beyond_its_limit_is_a_source) {
  // The drive delivers energy on the whole above 1605 N/m (case 7), and takes some below.
  const Plant plant = build_plant(build_device_network(make_p3(), FreeOperator{}));
  SimulationOptions options;
  options.duration = 1;
  options.initial_velocity = 1;
  const auto deliver = [&](double K, double B) {
    return simulate(plant, {}, VirtualWall{.stiffness = K, .damping = B}, one_ms, options)
        .energy.source;
  };
  EXPECT_GT(deliver(1700, 0), 0.1);
  EXPECT_LT(deliver(200, 0.5), -1e-3);
}

}  // namespace
}  // namespace gyrator
