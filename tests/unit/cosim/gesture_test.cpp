#include "gyrator/cosim/gesture.hpp"

#include "gyrator/cosim/simulation.hpp"

#include <algorithm>
#include <cmath>
#include <complex>
#include <ctime>
#include <functional>
#include <numbers>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "support/device_list.hpp"

namespace gyrator {
namespace {

using std::numbers::pi;
using testing::make_rc_display;

constexpr double period = 1e-3;

// Sum of the held impulses from 0 to `end`, over periods that divide no pulse evenly.
double sum_impulses(const HandGesture& gesture, double end, double step) {
  RunningGesture running(gesture, 1);
  double sum = 0;
  const auto n = static_cast<long>(std::round(end / step));
  for (long k = 0; k < n; ++k) {
    const auto at = [&](long i) { return static_cast<double>(i) * step; };
    sum += step * running.mean_effort(at(k), at(k + 1), step);
  }
  return sum;
}

// A bare mass with nothing but the hand at it.
Plant make_mass(double mass, const Operator& held_by = FreeOperator{}) {
  Device device;
  device.motion = Motion::linear;
  device.drive.amplifier = IdealDrive{};
  device.mechanics.inertia = mass;
  return build_plant(build_device_network(device, held_by));
}

TimeRun run_gesture(const Plant& plant, const HandGesture& gesture, Rational duration,
                    Rational sampling_period = Rational(1, 1000)) {
  SimulationOptions options;
  options.duration = duration;
  options.gesture = gesture;
  return simulate(plant, {}, NoController{}, {sampling_period, 0}, options);
}

TEST(Gesture, the_impulse_of_a_hit_is_that_of_its_law) {
  HitGesture hit{.effort = 3, .width = 7.3e-3, .times = {1.1e-3, 20e-3}};
  EXPECT_NEAR(sum_impulses({hit}, 0.1, period), 2 * 2 * 3 * 7.3e-3 / pi, 1e-16);  // hit-1
  hit.shape = HitGesture::Shape::raised_cosine;
  EXPECT_NEAR(sum_impulses({hit}, 0.1, period), 2 * 3 * 7.3e-3 / 2, 1e-16);  // hit-2
  hit.repeat = 25e-3;  // starts at 1.1, 20, 26.1, 45, 51.1, 70, 76.1, 95 ms; the last is cut off
  EXPECT_NEAR(sum_impulses({hit}, 0.095, period), 7 * 3 * 7.3e-3 / 2, 1e-15);
}

TEST(Gesture, a_hit_shorter_than_a_period_keeps_its_impulse) {
  const HitGesture hit{.effort = 3, .width = 1e-5, .times = {0.5035}};
  EXPECT_NEAR(sum_impulses({hit}, 1, period), 2 * 3 * 1e-5 / pi, 1e-18);
}

TEST(Gesture, each_mean_is_that_of_its_curve_by_quadrature) {
  const HitGesture sine{.effort = 2, .width = 8e-3, .times = {1e-3}};
  const HitGesture cosine{.effort = 2,
                          .width = 8e-3,
                          .times = {1e-3},
                          .repeat = {},
                          .shape = HitGesture::Shape::raised_cosine};
  const HoldGesture hold{.effort = 2, .start = 2.3e-3, .rise = 4.1e-3};
  const StrokeGesture stroke{.amplitude = 2, .frequency_hz = 40};
  const auto inside = [](double t) { return t > 1e-3 && t < 9e-3; };
  const std::vector<std::pair<Gesture, std::function<double(double)>>> cases{
      {sine, [&](double t) { return inside(t) ? 2 * std::sin(pi * (t - 1e-3) / 8e-3) : 0; }},
      {cosine, [&](double t) { return inside(t) ? 1 - std::cos(2 * pi * (t - 1e-3) / 8e-3) : 0; }},
      {hold, [](double t) { return 2 * std::clamp((t - 2.3e-3) / 4.1e-3, 0.0, 1.0); }},
      {stroke, [](double t) { return 2 * std::sin(2 * pi * 40 * t); }}};
  for (std::size_t c = 0; c < cases.size(); ++c) {
    RunningGesture running({cases[c].first}, 1);
    for (int k = 0; k < 12; ++k) {
      const double from = k * period;
      constexpr int parts = 2000;
      double sum = 0;
      for (int i = 0; i < parts; ++i) sum += cases[c].second(from + (i + 0.5) / parts * period);
      // Midpoint rule: h^2/24 times the largest second derivative, 2 (pi/4e-3)^2, and where the
      // slope breaks, h^2/8 times 2 pi/8e-3 over the period.
      ASSERT_NEAR(running.mean_effort(from, from + period, period), sum / parts, 1e-6)
          << c << " " << k;
    }
  }
}

TEST(Gesture, a_hit_gives_a_free_mass_its_impulse_as_momentum) {
  const double m = 0.3;
  for (const auto shape : {HitGesture::Shape::half_sine, HitGesture::Shape::raised_cosine}) {
    const HitGesture hit{
        .effort = 5, .width = 4.7e-3, .times = {3.1e-3}, .repeat = {}, .shape = shape};
    const double impulse =
        shape == HitGesture::Shape::half_sine ? 2 * 5 * 4.7e-3 / pi : 5 * 4.7e-3 / 2;
    const TimeRun run = run_gesture(make_mass(m), {hit}, Rational(1, 10));
    EXPECT_NEAR(run.trace.column("velocity").back() * m, impulse, 1e-12 * impulse);
    // What the hand did is the mass's kinetic energy.
    EXPECT_NEAR(run.energy.operator_work, impulse * impulse / (2 * m),
                1e-12 * impulse * impulse / m);
    EXPECT_NEAR(run.energy.residual, 0, 1e-14);
  }
}

TEST(Gesture, a_hit_keeps_its_impulse_under_a_jittering_clock) {
  SimulationOptions options;
  options.duration = Rational(1, 10);
  options.gesture = HandGesture{HitGesture{.effort = 5, .width = 4.7e-3, .times = {3.1e-3}}};
  const TimeRun run = simulate(make_mass(0.3), {}, NoController{},
                               {Rational(1, 1000), 0, Rational(4, 10000)}, options);
  const double impulse = 2 * 5 * 4.7e-3 / pi;
  EXPECT_NEAR(run.trace.column("velocity").back() * 0.3, impulse, 1e-12 * impulse);
}

TEST(Gesture, the_position_of_a_free_mass_converges_with_the_square_of_the_period) {
  // Off by T^2/12m times the change of the force (gesture.hpp): of a ramp that ends at F.
  const double m = 0.5;
  const double F = 2;
  const HoldGesture hold{.effort = F, .start = 0, .rise = 0.1};
  const double exact = F * 0.1 * 0.1 / (6 * m);
  for (const Rational& T : {Rational(1, 100), Rational(1, 200), Rational(1, 1000)}) {
    const TimeRun run = run_gesture(make_mass(m), {hold}, Rational(1, 10), T);
    const double error = run.trace.column("position").back() - exact;
    const double expected = T.to_double() * T.to_double() / (12 * m) * F;
    EXPECT_NEAR(error, expected, 1e-12) << T.to_string();
  }
}

TEST(Gesture, a_recording_of_a_curve_is_that_curve) {
  // Of straight pieces exactly; of a sine up to its curvature, h^2/8 A w^2 for samples h apart.
  const HoldGesture hold{.effort = 2, .start = 0.02, .rise = 0.03};
  const RecordedGesture ramp{{10, 10.02, 10.05, 11}, {0, 0, 2, 2}, false, {}};
  RunningGesture a({hold}, 1);
  RunningGesture b({ramp}, 1);
  for (int k = 0; k < 990; ++k) {
    const double from = k * period;
    ASSERT_NEAR(a.mean_effort(from, from + period, period),
                b.mean_effort(from, from + period, period), 1e-11);
  }
  const double h = 1e-4;
  const double w = 2 * pi * 5;
  RecordedGesture recorded;
  for (int i = 0; i <= 10000; ++i) {
    recorded.time.push_back(i * h);
    recorded.value.push_back(3 * std::sin(w * i * h));
  }
  const Plant plant = make_mass(0.4);
  const TimeRun analytic = run_gesture(plant, {StrokeGesture{3, 5, false}}, Rational(1));
  const TimeRun read = run_gesture(plant, {recorded}, Rational(1));
  const double bound = h * h / 8 * 3 * w * w;
  for (std::size_t k = 0; k < analytic.trace.column("time_s").size(); ++k) {
    ASSERT_NEAR(analytic.trace.column("external_effort")[k],
                read.trace.column("external_effort")[k], bound);
    ASSERT_NEAR(analytic.trace.column("position")[k], read.trace.column("position")[k],
                bound / 0.4 / 2);
  }
}

// x = t^2 in straight pieces `h` long.
HandGesture make_recording(std::size_t rows, double h, bool is_motion) {
  RecordedGesture recorded;
  recorded.is_motion = is_motion;
  for (std::size_t i = 0; i < rows; ++i) {
    const double t = static_cast<double>(i) * h;
    recorded.time.push_back(t);
    recorded.value.push_back(t * t);
  }
  return {recorded, 400, 6};
}

TEST(Gesture, a_recorded_motion_is_the_same_in_whatever_order_it_is_asked_for) {
  // Of pieces of 1 ms, from sample a to b: k times the trapezoids, and b times the rise.
  RunningGesture running(make_recording(1000, 1e-3, true), 1);
  for (const auto& [a, b] :
       {std::pair{500, 502}, {10, 11}, {997, 999}, {0, 3}, {998, 999}, {499, 500}, {500, 501}}) {
    double trapezoids = 0;
    for (int i = a; i < b; ++i) trapezoids += (i * i + (i + 1) * (i + 1)) / 2.0 * 1e-9;
    const double rise = (b * b - a * a) * 1e-6;
    const double length = (b - a) * 1e-3;
    // Rounding of t, 1e-16 s, beside a piece of 1e-3 s.
    EXPECT_NEAR(running.mean_effort(a * 1e-3, b * 1e-3, length),
                (400 * trapezoids + 6 * rise) / length, 1e-9)
        << a << " " << b;
  }
}

TEST(Gesture, a_recorded_motion_takes_about_as_long_as_a_recorded_force) {
  // Both ends of each period are looked up; from the start each time, 50000 rows would take
  // hundreds of times as long. Processor time: other programs do not count.
  constexpr std::size_t rows = 50000;
  constexpr double h = 1e-3;
  const auto clocks = [&](bool is_motion) {
    RunningGesture running(make_recording(rows, h, is_motion), 1);
    const std::clock_t start = std::clock();
    double sum = 0;
    for (std::size_t k = 0; k + 1 < rows; ++k) {
      const double t = static_cast<double>(k) * h;
      sum += running.mean_effort(t, t + h, h);
    }
    EXPECT_GT(sum, 0);
    return static_cast<double>(std::clock() - start);
  };
  EXPECT_LT(clocks(true), 50 * std::max(clocks(false), 1e-3 * CLOCKS_PER_SEC));
}

TEST(Gesture, an_intended_motion_moves_the_port_through_the_hands_spring_and_damper) {
  // m x'' + b x' + k x = k x_h + b x_h': in the steady state |x/x_h| is the transmissibility of a
  // base-excited oscillator.
  const double m = 0.2;
  const MassSpringDamper hand{.inertia = 0, .damping = 6, .stiffness = 400, .resonators = {}};
  const double A = 0.01;
  const double f = 4;
  const TimeRun run =
      run_gesture(make_mass(m, hand), {StrokeGesture{A, f, true}, 400, 6}, Rational(3));
  const double w = 2 * pi * f;
  const std::complex<double> base(400, 6 * w);
  const double expected = A * std::abs(base / (base - m * w * w));
  double largest = 0;
  const auto& x = run.trace.column("position");
  for (std::size_t k = x.size() - 500; k < x.size(); ++k)
    largest = std::max(largest, std::abs(x[k]));
  // The transient is down by exp(-15 · 2.5), the peak between two samples by (w T)^2/8, and holding
  // the mean is of second order too: (w T)^2/24.
  EXPECT_NEAR(largest, expected, expected * (w * period) * (w * period) / 6);
  EXPECT_NEAR(run.energy.residual, 0, 1e-12 * std::abs(run.energy.operator_work));
}

TEST(Gesture, the_ledger_closes_for_every_gesture_on_every_engine) {
  RecordedGesture recorded{{0, 0.013, 0.05, 0.2}, {0, 0.02, -0.03, 0.01}, false, {}};
  const std::vector<Gesture> gestures{
      HitGesture{.effort = 0.05, .width = 4e-3, .times = {0.01}, .repeat = 0.03},
      HoldGesture{0.02, 0.01, 0.02}, StrokeGesture{0.03, 12, false}, RandomGesture{0.03, 100},
      recorded};
  const Plant plant = build_plant(build_device_network(make_rc_display(), FreeOperator{}));
  for (const EngineKind engine : {EngineKind::exact, EngineKind::cvode, EngineKind::odeint}) {
    for (std::size_t g = 0; g < gestures.size(); ++g) {
      SimulationOptions options;
      options.duration = Rational(1, 10);
      options.engine = engine;
      options.gesture = HandGesture{gestures[g]};
      const TimeRun run =
          simulate(plant, {}, VirtualWall{.stiffness = 0.05},
                   {Rational(1, 1000), Rational(1, 3000), Rational(1, 5000)}, options);
      const double moved = std::abs(run.energy.operator_work) + run.energy.dissipated;
      ASSERT_GT(moved, 0);
      // Rounding of 100 periods; the integrators' own tolerance of 1e-9 a segment.
      const double tolerance = engine == EngineKind::exact ? 1e-12 : 1e-6;
      EXPECT_NEAR(run.energy.residual, 0, tolerance * moved) << g;
    }
  }
}

TEST(Gesture, a_random_force_has_its_size_its_band_and_its_seed) {
  const RandomGesture random{.effort = 2, .bandwidth_hz = 50};
  const auto sample = [&](std::uint64_t seed) {
    RunningGesture running({random}, seed);
    std::vector<double> force;
    for (int k = 0; k < 100000; ++k) {  // 100 s: the slowest beat, 50 Hz/64 apart, 78 times
      const double from = k * period;
      force.push_back(running.mean_effort(from, from + period, period));
    }
    return force;
  };
  const auto force = sample(3);
  double squares = 0;
  double steps = 0;
  for (std::size_t k = 1; k < force.size(); ++k) {
    squares += force[k] * force[k];
    steps += std::pow((force[k] - force[k - 1]) / period, 2);
  }
  // 64 sines of power 1/32 each; their products fade as 1/(spacing · time), to a few percent.
  EXPECT_NEAR(squares / 1e5, 4, 4 * 0.05);
  // Power of the derivative of an even band: (2 pi B)^2/3; the frequencies are even to 1/64.
  const double derivative = 4 * std::pow(2 * pi * 50, 2) / 3;
  EXPECT_NEAR(steps / 1e5, derivative, derivative * 0.08);
  EXPECT_EQ(sample(3), force);
  EXPECT_NE(sample(4), force);
}

TEST(Gesture, adds_to_the_constant_effort_and_has_a_column) {
  const Plant plant = make_mass(1);
  SimulationOptions options;
  options.duration = Rational(1, 10);
  options.external_effort = 0.5;
  const TimeRun without = simulate(plant, {}, NoController{}, {Rational(1, 1000), 0}, options);
  EXPECT_EQ(std::find(without.trace.names.begin(), without.trace.names.end(), "external_effort"),
            without.trace.names.end());
  options.gesture = HandGesture{HoldGesture{.effort = 1}};
  const TimeRun with = simulate(plant, {}, NoController{}, {Rational(1, 1000), 0}, options);
  // Both ends of a period are rounded by half an ulp of 0.1 s, 7e-18 s, beside 1 ms.
  for (const double effort : with.trace.column("external_effort"))
    ASSERT_NEAR(effort, 1.5, 1.5 * 2 * 7e-15);
  EXPECT_NEAR(with.trace.column("velocity").back(), 0.15, 1e-14);
}

}  // namespace
}  // namespace gyrator
