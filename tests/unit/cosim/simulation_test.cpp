#include "gyrator/cosim/simulation.hpp"

#include "gyrator/core/error.hpp"

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "support/device_list.hpp"

namespace gyrator {
namespace {

using testing::make_p3;
using testing::make_rc_display;

const Sampling one_ms{Rational(1, 1000), 0};

Plant build(const Device& device) {
  return build_plant(build_device_network(device, FreeOperator{}));
}

SimulationOptions run_for(Rational duration, double position, double velocity) {
  SimulationOptions options;
  options.duration = duration;
  options.initial_position = position;
  options.initial_velocity = velocity;
  return options;
}

TEST(Simulation, records_one_row_per_sample_instant_and_the_last) {
  const TimeRun run = simulate(build(make_p3()), {}, VirtualWall{.stiffness = 500}, one_ms,
                               run_for(Rational(1, 4), 0.01, 0));
  EXPECT_EQ(run.steps, 250);
  EXPECT_EQ(run.final_time_s, 0.25);
  ASSERT_EQ(run.trace.names.size(), run.trace.columns.size());
  for (const auto& column : run.trace.columns) ASSERT_EQ(column.size(), 251U);
  const auto& time = run.trace.column("time_s");
  for (int k = 0; k <= 250; ++k) ASSERT_EQ(time[static_cast<std::size_t>(k)], k / 1000.0);
  EXPECT_EQ(run.trace.column("position").front(), 0.01);
}

TEST(Simulation, runs_to_the_last_sample_instant_within_the_duration) {
  const Plant plant = build(make_p3());
  const auto steps = [&](Rational duration) {
    return simulate(plant, {}, NoController{}, {Rational(1, 60), 0}, run_for(duration, 0, 1)).steps;
  };
  EXPECT_EQ(steps(Rational(1, 60)), 1);
  EXPECT_EQ(steps(Rational(1)), 60);
  EXPECT_EQ(steps(Rational(1) - Rational(1, 1000000)), 59);
  try {
    steps(Rational(1, 61));
    FAIL() << "a run of no period was accepted";
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::bad_input);
    EXPECT_EQ(error.place(), "simulation/duration");
  }
}

TEST(Simulation, has_the_columns_of_the_interface_and_those_that_the_device_can_tell) {
  const auto names = [](const Device& device, bool ledger) {
    SimulationOptions options = run_for(Rational(1, 100), 0, 1);
    options.engine_options.ledger = ledger;
    return simulate(build(device), {}, NoController{}, one_ms, options).trace.names;
  };
  EXPECT_EQ(names(make_p3(), false),
            (std::vector<std::string>{"time_s", "position", "velocity", "effort", "command",
                                      "measured_position", "held_command", "held_command_after"}));
  const auto rc = names(make_rc_display(), true);
  for (const char* name : {"current", "voltage", "voltage_after", "energy_operator",
                           "energy_source", "energy_stored", "energy_dissipated"}) {
    EXPECT_NE(std::find(rc.begin(), rc.end(), name), rc.end()) << name;
  }
  EXPECT_EQ(std::find(rc.begin(), rc.end(), "current_after"), rc.end())
      << "the winding's current does not jump";
}

TEST(Simulation, an_unknown_column_is_an_error_that_lists_those_there_are) {
  const TimeRun run =
      simulate(build(make_p3()), {}, NoController{}, one_ms, run_for(Rational(1, 100), 0, 1));
  try {
    (void)run.trace.column("positon");
    FAIL() << "found";
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::bad_input);
    EXPECT_NE(error.message().find("positon"), std::string::npos);
    EXPECT_NE(error.message().find("held_command_after"), std::string::npos);
  }
}

TEST(Simulation, the_sensor_gives_the_nearest_multiple_halves_up_plus_the_offset) {
  // A device at rest, so that the measured position is that of the start. Powers of two: exact.
  const Plant plant = build(make_p3());
  const auto measure = [&](double position, const Sensor& sensor) {
    return simulate(plant, sensor, NoController{}, one_ms, run_for(Rational(1, 1000), position, 0))
        .trace.column("measured_position")
        .front();
  };
  const Sensor quarter{.quantum = 0.25};
  EXPECT_EQ(measure(0.3, quarter), 0.25);
  EXPECT_EQ(measure(0.375, quarter), 0.5) << "half up";
  EXPECT_EQ(measure(-0.375, quarter), -0.25) << "half up, below zero too";
  EXPECT_EQ(measure(-0.3, quarter), -0.25);
  EXPECT_EQ(measure(0.3, (Sensor{.quantum = 0.25, .offset = 2})), 2.25);
  EXPECT_EQ(measure(0.3, (Sensor{.quantum = 0, .offset = 2})), 2.3);
}

TEST(Simulation, a_command_is_held_from_its_delay_on) {
  // Held command in force just after instant k: with a delay of m periods u[k-m], with a fraction
  // still u[k-m-1] until the edge, and zero before the first has arrived.
  const Plant plant = build(make_p3());
  const VirtualWall wall{.stiffness = 500, .damping = 1};
  for (const auto& [delay_ms, age] : std::vector<std::pair<Rational, int>>{
           {0, 0}, {Rational(3, 10), 1}, {1, 1}, {Rational(3, 2), 2}, {3, 3}}) {
    const TimeRun run = simulate(plant, {}, wall, {Rational(1, 1000), delay_ms / 1000},
                                 run_for(Rational(1, 20), 0.01, 0.3));
    const auto& command = run.trace.column("command");
    const auto& held = run.trace.column("held_command");
    const auto& after = run.trace.column("held_command_after");
    for (int k = 0; k <= 50; ++k) {
      const double expected = k >= age ? command[static_cast<std::size_t>(k - age)] : 0;
      ASSERT_EQ(after[static_cast<std::size_t>(k)], expected) << delay_ms.to_string() << " " << k;
      // With a fraction the change comes between two rows, at the edge.
      const bool fraction = delay_ms.den() != 1;
      const int held_age = fraction ? age : age + 1;
      const double held_then = k >= held_age ? command[static_cast<std::size_t>(k - held_age)] : 0;
      ASSERT_EQ(held[static_cast<std::size_t>(k)], held_then) << delay_ms.to_string() << " " << k;
    }
  }
}

// Rows of `run` whose time is a sample instant, first of each.
std::vector<std::size_t> find_sample_rows(const TimeRun& run, double period) {
  std::vector<std::size_t> rows;
  const auto& time = run.trace.column("time_s");
  for (std::size_t i = 0; i < time.size(); ++i) {
    if (time[i] >= static_cast<double>(rows.size()) * period * (1 - 1e-12)) rows.push_back(i);
  }
  return rows;
}

TEST(Simulation, a_trace_step_adds_rows_and_changes_none) {
  const Plant plant = build(make_rc_display());
  const VirtualWall wall{.stiffness = 0.3, .damping = 1e-4};
  for (const Rational& delay : {Rational(0), Rational(1, 4000), Rational(17, 10000)}) {
    SimulationOptions options = run_for(Rational(1, 10), 0.01, 1);
    const Sampling sampling{Rational(1, 1000), delay};
    const TimeRun plain = simulate(plant, {}, wall, sampling, options);
    // 0.4 ms divides neither the period nor the delays; 2 ms is longer than a period.
    for (const Rational& step : {Rational(4, 10000), Rational(1, 8000), Rational(1, 500)}) {
      options.trace_step = step;
      const TimeRun fine = simulate(plant, {}, wall, sampling, options);
      const auto rows = find_sample_rows(fine, 1e-3);
      ASSERT_EQ(rows.size(), 101U);
      ASSERT_EQ(fine.trace.names, plain.trace.names);
      for (std::size_t c = 0; c < plain.trace.columns.size(); ++c) {
        double largest = 0;
        for (const double value : plain.trace.columns[c]) {
          largest = std::max(largest, std::abs(value));
        }
        for (std::size_t k = 0; k < rows.size(); ++k) {
          // Products of other exponentials: rounding of each over 100 periods.
          ASSERT_NEAR(fine.trace.columns[c][rows[k]], plain.trace.columns[c][k], 1e-11 * largest)
              << plain.trace.names[c] << " at row " << k << ", step " << step.to_string();
        }
      }
      EXPECT_EQ(fine.classification.outcome, plain.classification.outcome);
      EXPECT_NEAR(fine.energy.dissipated, plain.energy.dissipated, 1e-11 * plain.energy.dissipated);
    }
  }
}

TEST(Simulation, a_trace_step_has_a_row_at_each_multiple_and_two_at_each_edge_of_the_hold) {
  // T 1 ms, delay 0.25 ms, step 0.5 ms: rows at 0, 0.25 (before), 0.25 (after), 0.5 ms in each.
  SimulationOptions options = run_for(Rational(1, 100), 0.01, 1);
  options.trace_step = Rational(1, 2000);
  const TimeRun run = simulate(build(make_p3()), {}, VirtualWall{.stiffness = 300},
                               {Rational(1, 1000), Rational(1, 4000)}, options);
  const auto& time = run.trace.column("time_s");
  const auto& held = run.trace.column("held_command");
  ASSERT_EQ(time.size(), 4U * 10 + 1);
  for (std::size_t k = 0; k < 10; ++k) {
    const double start = static_cast<double>(k) / 1000;
    EXPECT_NEAR(time[4 * k], start, 1e-15);
    EXPECT_NEAR(time[4 * k + 1], start + 0.25e-3, 1e-15);
    EXPECT_EQ(time[4 * k + 2], time[4 * k + 1]);
    EXPECT_NEAR(time[4 * k + 3], start + 0.5e-3, 1e-15);
    EXPECT_NE(held[4 * k + 2], held[4 * k + 1]) << "the jump lies between the two";
    EXPECT_EQ(held[4 * k + 1], held[4 * k]);
    EXPECT_EQ(held[4 * k + 3], held[4 * k + 2]);
    EXPECT_EQ(run.trace.column("position")[4 * k + 2], run.trace.column("position")[4 * k + 1]);
  }
}

TEST(Simulation, without_a_record_keeps_no_row_but_the_same_energies) {
  const Plant plant = build(make_rc_display());
  const VirtualWall wall{.stiffness = 0.3};
  const Sampling sampling{Rational(1, 1000), Rational(1, 4000)};
  SimulationOptions options = run_for(Rational(1, 20), 0, 1);
  const TimeRun recorded = simulate(plant, {}, wall, sampling, options);
  options.record = false;
  for (const bool in_between : {false, true}) {
    if (in_between) options.trace_step = Rational(1, 4000);
    const TimeRun run = simulate(plant, {}, wall, sampling, options);
    for (const auto& column : run.trace.columns) EXPECT_TRUE(column.empty()) << in_between;
    EXPECT_EQ(run.steps, recorded.steps);
    EXPECT_NEAR(run.energy.dissipated, recorded.energy.dissipated,
                1e-12 * recorded.energy.dissipated);
  }
}

TEST(Simulation, a_diverging_run_stops_early_and_keeps_its_trace) {
  // Three times the critical stiffness, 1605 N/m: it grows by 1e9 within some hundred periods.
  const TimeRun run = simulate(build(make_p3()), {}, VirtualWall{.stiffness = 5000}, one_ms,
                               run_for(Rational(100), 0, 0.1));
  EXPECT_TRUE(run.stopped_early);
  EXPECT_EQ(run.classification.outcome, Outcome::diverges);
  EXPECT_LT(run.steps, 20000);
  const auto& position = run.trace.column("position");
  EXPECT_EQ(position.size(), static_cast<std::size_t>(run.steps) + 1);
  EXPECT_EQ(run.final_time_s, static_cast<double>(run.steps) / 1000);
  double fastest = 0;
  for (const double v : run.trace.column("velocity")) {
    ASSERT_TRUE(std::isfinite(v));
    fastest = std::max(fastest, std::abs(v));
  }
  // The size at the start is that of the first sixteen periods, 0.1 m/s and a little more; from
  // then on it looks every sixteen periods, in which this loop grows by less than half.
  EXPECT_GT(fastest, 1e9 * 0.1);
  EXPECT_LT(fastest, 1e9 * 0.1 * 3) << "stopped long after it should have been";
}

TEST(Simulation, goes_on_to_the_end_where_growth_is_slow) {
  const TimeRun run = simulate(build(make_p3()), {}, VirtualWall{.stiffness = 1700}, one_ms,
                               run_for(Rational(1), 0, 0.1));
  EXPECT_FALSE(run.stopped_early);
  EXPECT_EQ(run.steps, 1000);
  EXPECT_EQ(run.classification.outcome, Outcome::diverges);
}

TEST(Simulation, a_stable_wall_does_not_diverge_in_a_run_too_short_for_its_cycles) {
  // 300 N/m on P3: a decaying swing of 73 ms. What a sixth of the run does is its phase, not
  // growth.
  const Plant plant = build(make_p3());
  for (int duration_ms = 20; duration_ms <= 300; duration_ms += 20) {
    const TimeRun run = simulate(plant, {}, VirtualWall{.stiffness = 300}, one_ms,
                                 run_for(Rational(duration_ms, 1000), 0, 1));
    EXPECT_NE(run.classification.outcome, Outcome::diverges) << duration_ms << " ms";
  }
}

TEST(Simulation, an_engine_that_gives_up_is_a_numerical_error_with_the_time) {
  const Plant plant = build(make_rc_display());
  for (const EngineKind kind : {EngineKind::cvode, EngineKind::odeint}) {
    SimulationOptions options = run_for(Rational(1, 10), 0, 1);
    options.engine = kind;
    options.engine_options.max_steps = 2;
    try {
      simulate(plant, {}, VirtualWall{.stiffness = 0.3}, one_ms, options);
      FAIL() << "two steps were enough for a millisecond of a winding with 0.08 ms";
    } catch (const Error& error) {
      EXPECT_EQ(error.code(), ErrorCode::numerical);
      EXPECT_TRUE(error.place().starts_with("t = ")) << error.place();
      EXPECT_NE(error.message().find("engine gave up"), std::string::npos) << error.message();
    }
  }
}

TEST(Simulation, keeps_every_nth_row_for_long_runs) {
  const Plant plant = build(make_p3());
  SimulationOptions options = run_for(Rational(1, 10), 0, 1);
  const TimeRun all = simulate(plant, {}, VirtualWall{.stiffness = 500}, one_ms, options);
  options.record_every = 10;
  const TimeRun thinned = simulate(plant, {}, VirtualWall{.stiffness = 500}, one_ms, options);
  const auto& position = thinned.trace.column("position");
  ASSERT_EQ(position.size(), 11U);
  for (std::size_t i = 0; i < position.size(); ++i) {
    EXPECT_EQ(position[i], all.trace.column("position")[10 * i]);
  }
}

TEST(Simulation, is_deterministic_to_the_last_bit) {
  const Plant plant = build(make_rc_display());
  for (const EngineKind kind : {EngineKind::exact, EngineKind::cvode, EngineKind::odeint}) {
    SimulationOptions options = run_for(Rational(1, 20), 0.01, 1);
    options.engine = kind;
    const VirtualWall wall{.stiffness = 0.3, .damping = 1e-4};
    const TimeRun first = simulate(plant, {.quantum = 1e-4}, wall, one_ms, options);
    const TimeRun second = simulate(plant, {.quantum = 1e-4}, wall, one_ms, options);
    EXPECT_EQ(first.trace.columns, second.trace.columns);
  }
}

}  // namespace
}  // namespace gyrator
