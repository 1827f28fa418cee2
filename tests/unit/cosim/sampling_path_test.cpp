#include "gyrator/core/error.hpp"
#include "gyrator/cosim/simulation.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include <gtest/gtest.h>

#include "support/device_list.hpp"

namespace gyrator {
namespace {

using testing::make_p3;
using testing::make_rc_display;

// A mean of n independent numbers lies within five of its standard deviations but for one seed in
// two million; the seeds are fixed.
constexpr double deviations = 5;

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

TEST(Dac, rounds_to_the_nearest_multiple_halves_up_then_saturates) {
  const Dac dac{.quantum = 0.25, .limit = 1};
  EXPECT_EQ(dac.convert(0.3), 0.25);
  EXPECT_EQ(dac.convert(0.375), 0.5);
  EXPECT_EQ(dac.convert(-0.375), -0.25);
  EXPECT_EQ(dac.convert(0.99), 1);
  EXPECT_EQ(dac.convert(1.1), 1);
  EXPECT_EQ(dac.convert(-7), -1);
  EXPECT_EQ((Dac{.quantum = 0.25, .limit = 0.6}.convert(3)), 0.6) << "saturation comes last";
  EXPECT_EQ(Dac{}.convert(0.3), 0.3);
  EXPECT_EQ((Dac{.quantum = 0.25, .limit = {}}.convert(100.1)), 100);
}

TEST(Dac, the_trace_has_what_was_asked_for_and_what_was_applied) {
  SimulationOptions options = run_for(Rational(1, 20), 0.01, 0.3);
  options.dac = {.quantum = 0.5, .limit = 4};
  const TimeRun run = simulate(build(make_p3()), {}, VirtualWall{.stiffness = 500},
                               {Rational(1, 1000), 0}, options);
  const auto& command = run.trace.column("command");
  const auto& applied = run.trace.column("held_command_after");
  for (std::size_t k = 0; k < command.size(); ++k)
    ASSERT_EQ(applied[k], options.dac.convert(command[k])) << k;
  EXPECT_LT(*std::min_element(command.begin(), command.end()), -4.5) << "nothing saturates";
}

TEST(Sensor, noise_has_its_standard_deviation_no_mean_and_no_memory) {
  // A device at rest without a controller: what is measured is noise alone.
  const double sigma = 2e-5;
  const TimeRun run = simulate(build(make_p3()), {.noise = sigma}, NoController{},
                               {Rational(1, 1000), 0}, run_for(Rational(20), 0, 0));
  const auto& y = run.trace.column("measured_position");
  const auto n = static_cast<double>(y.size());
  double sum = 0;
  double squares = 0;
  double neighbours = 0;
  for (std::size_t k = 0; k < y.size(); ++k) {
    sum += y[k];
    squares += y[k] * y[k];
    if (k > 0) neighbours += y[k] * y[k - 1];
  }
  EXPECT_NEAR(sum / n, 0, deviations * sigma / std::sqrt(n));
  EXPECT_NEAR(squares / n, sigma * sigma, deviations * sigma * sigma * std::sqrt(2 / n));
  EXPECT_NEAR(neighbours / n, 0, deviations * sigma * sigma / std::sqrt(n));
}

TEST(Sensor, noise_comes_before_rounding_and_follows_the_seed) {
  const auto measure = [&](const Sensor& sensor, std::uint64_t seed) {
    SimulationOptions options = run_for(Rational(1), 0, 0);
    options.seed = seed;
    return simulate(build(make_p3()), sensor, NoController{}, {Rational(1, 1000), 0}, options)
        .trace.column("measured_position");
  };
  const auto plain = measure({.noise = 1}, 5);
  const auto rounded = measure({.quantum = 0.5, .offset = 0.125, .noise = 1}, 5);
  for (std::size_t k = 0; k < plain.size(); ++k)
    ASSERT_EQ(rounded[k], round_to_multiple(plain[k], 0.5) + 0.125);
  EXPECT_EQ(measure({.noise = 1}, 5), plain);
  EXPECT_NE(measure({.noise = 1}, 6), plain);
}

TEST(SampleClock, jitter_is_uniform_within_its_bounds_and_time_is_not_accumulated) {
  const Sampling sampling{Rational(1, 1000), 0, Rational(3, 10000)};
  const TimeRun run =
      simulate(build(make_p3()), {}, NoController{}, sampling, run_for(Rational(20), 0, 0));
  const auto& time = run.trace.column("time_s");
  ASSERT_EQ(time.size(), 20001U);
  EXPECT_EQ(time.front(), 0) << "the run begins at the first sample";
  double sum = 0;
  double squares = 0;
  for (std::size_t k = 1; k < time.size(); ++k) {
    // Bounds hold around k T itself, however late.
    const double J = time[k] - static_cast<double>(k) / 1000;
    ASSERT_LE(std::abs(J), 3e-4 * (1 + 1e-9));
    ASSERT_GT(time[k], time[k - 1]);
    sum += J;
    squares += J * J;
  }
  // Of a uniform number in +-a: variance a^2/3, of its square 4 a^4/45.
  const double n = 20000;
  EXPECT_NEAR(sum / n, 0, deviations * 3e-4 / std::sqrt(3 * n));
  EXPECT_NEAR(squares / n, 3e-8, deviations * 9e-8 * std::sqrt(4.0 / 45 / n));
}

TEST(SampleClock, a_jitter_of_zero_is_the_even_clock_bit_for_bit_whatever_the_seed) {
  const Plant plant = build(make_rc_display());
  const VirtualWall wall{.stiffness = 0.3, .damping = 1e-4};
  SimulationOptions options = run_for(Rational(1, 10), 0.01, 1);
  const TimeRun even = simulate(plant, {}, wall, {Rational(1, 1000), Rational(1, 4000)}, options);
  options.seed = 99;
  const TimeRun none =
      simulate(plant, {}, wall, {Rational(1, 1000), Rational(1, 4000), Rational(0)}, options);
  EXPECT_EQ(even.trace.columns, none.trace.columns);
}

TEST(SampleClock, a_vanishing_jitter_tends_to_the_even_clock) {
  // The jittering loop goes from event to event, the even one over prepared segments: for a jitter
  // of 1e-12 s both must agree to what 1e-12 s a sample make of signals of some 100 rad/s.
  const Plant plant = build(make_rc_display());
  const VirtualWall wall{.stiffness = 0.05, .damping = 1e-4};
  for (const Rational& delay : {Rational(0), Rational(1, 4000), Rational(17, 10000)}) {
    const SimulationOptions options = run_for(Rational(1, 10), 0.01, 1);
    const TimeRun even = simulate(plant, {}, wall, {Rational(1, 1000), delay}, options);
    const TimeRun close = simulate(
        plant, {}, wall, {Rational(1, 1000), delay, Rational(1, 1'000'000'000'000)}, options);
    const auto& a = even.trace.column("position");
    const auto& b = close.trace.column("position");
    double largest = 0;
    for (const double x : a) largest = std::max(largest, std::abs(x));
    ASSERT_EQ(a.size(), b.size());
    for (std::size_t k = 0; k < a.size(); ++k)
      ASSERT_NEAR(a[k], b[k], 1e-9 * largest) << delay.to_string() << " " << k;
  }
}

TEST(SampleClock, a_command_takes_effect_its_delay_after_the_sample_it_was_computed_at) {
  // An inertia without damping: between edges its acceleration is the held command over m, so that
  // velocity at each instant follows from the edges, s_j + delay, alone.
  Device device;
  device.motion = Motion::linear;
  device.drive.amplifier = IdealDrive{};
  device.mechanics.inertia = 2;
  const Plant plant = build(device);
  for (const Rational& delay :
       {Rational(0), Rational(1, 2000), Rational(1, 1000), Rational(27, 10000)}) {
    const Sampling sampling{Rational(1, 1000), delay, Rational(4, 10000)};
    const TimeRun run = simulate(plant, {}, VirtualWall{.stiffness = 2000}, sampling,
                                 run_for(Rational(1, 10), 0.01, 0));
    const auto& t = run.trace.column("time_s");
    const auto& u = run.trace.column("command");
    const auto& v = run.trace.column("velocity");
    for (std::size_t k = 0; k < t.size(); ++k) {
      double impulse = 0;
      for (std::size_t j = 0; j < k; ++j) {
        const double from = t[j] + delay.to_double();
        const double to = std::min(t[k], t[j + 1] + delay.to_double());
        if (to > from) impulse += u[j] * (to - from);
      }
      // Rounding of 100 products.
      ASSERT_NEAR(v[k], impulse / 2, 1e-13) << delay.to_string() << " " << k;
    }
  }
}

TEST(SampleClock, a_trace_step_adds_rows_under_jitter_and_changes_none) {
  const Plant plant = build(make_rc_display());
  const VirtualWall wall{.stiffness = 0.05, .damping = 1e-4};
  SimulationOptions options = run_for(Rational(1, 20), 0.01, 1);
  const Sampling sampling{Rational(1, 1000), Rational(1, 4000), Rational(1, 5000)};
  const TimeRun plain = simulate(plant, {}, wall, sampling, options);
  options.trace_step = Rational(3, 10000);
  const TimeRun fine = simulate(plant, {}, wall, sampling, options);
  const auto& times = fine.trace.column("time_s");
  EXPECT_TRUE(std::is_sorted(times.begin(), times.end()));
  const auto& coarse = plain.trace.column("time_s");
  for (std::size_t k = 0; k < coarse.size(); ++k) {
    const auto at = std::find(times.begin(), times.end(), coarse[k]);
    ASSERT_NE(at, times.end()) << k;
    const auto row = static_cast<std::size_t>(at - times.begin());
    ASSERT_NEAR(fine.trace.column("position")[row], plain.trace.column("position")[k], 1e-12) << k;
  }
  EXPECT_EQ(fine.classification.outcome, plain.classification.outcome);
}

TEST(Simulation, a_command_that_is_no_number_ends_the_run_and_names_step_and_time) {
  // K x overflows at once; with a trace kept, it ends with the row that shows it.
  SimulationOptions options = run_for(Rational(1, 10), 1e10, 0);
  const Plant plant = build(make_p3());
  const VirtualWall wall{.stiffness = 1e300, .damping = 0};
  const auto run = [&] { return simulate(plant, {}, wall, {Rational(1, 1000), 0}, options); };
  EXPECT_THROW(run(), Error);
  options.keep_failed = true;
  const TimeRun kept = run();
  ASSERT_TRUE(kept.failure);
  EXPECT_EQ(kept.failure->code(), ErrorCode::numerical);
  EXPECT_EQ(kept.failure->place(), "t = 0 s");
  EXPECT_NE(kept.failure->message().find("step 0"), std::string::npos);
  ASSERT_EQ(kept.trace.column("command").size(), 1U);
  EXPECT_FALSE(std::isfinite(kept.trace.column("command")[0]));
}

TEST(Simulation, a_run_that_fails_on_the_way_keeps_its_rows_and_a_closed_ledger) {
  // 1e5 m/s: K x passes the largest double, 1.8e308 N, at 180 m, between the samples at 1 and 2 ms.
  // No command takes effect before.
  SimulationOptions options = run_for(Rational(1, 10), 0, 1e5);
  options.keep_failed = true;
  const TimeRun run = simulate(build(make_p3()), {}, VirtualWall{.stiffness = 1e306},
                               {Rational(1, 1000), Rational(1)}, options);
  ASSERT_TRUE(run.failure);
  EXPECT_EQ(run.failure->place(), "t = 0.002 s");
  EXPECT_NE(run.failure->message().find("step 2"), std::string::npos) << run.failure->message();
  EXPECT_EQ(run.steps, 2);
  EXPECT_EQ(run.final_time_s, 0.002);
  for (const auto& column : run.trace.columns) EXPECT_EQ(column.size(), 3U);
  EXPECT_GT(run.energy.dissipated, 0);
  EXPECT_NEAR(run.energy.residual, 0, 1e-14 * run.energy.stored_initially);
}

TEST(Simulation, a_run_that_an_engine_gives_up_ends_at_the_last_sample_before) {
  // The microsecond up to the edge of the hold is passed, the rest of the period is not.
  SimulationOptions options = run_for(Rational(1, 10), 0, 1);
  options.engine = EngineKind::cvode;
  options.engine_options.max_steps = 25;
  options.keep_failed = true;
  const TimeRun run = simulate(build(make_rc_display()), {}, VirtualWall{.stiffness = 0.05},
                               {Rational(1, 1000), Rational(1, 1000000)}, options);
  ASSERT_TRUE(run.failure);
  EXPECT_NE(run.failure->message().find("engine gave up"), std::string::npos);
  EXPECT_EQ(run.trace.column("time_s"), std::vector<double>{0});
  EXPECT_EQ(run.final_time_s, 0);
  EXPECT_EQ(run.energy.stored, run.energy.stored_initially);
  EXPECT_EQ(run.energy.dissipated, 0);
}

}  // namespace
}  // namespace gyrator
