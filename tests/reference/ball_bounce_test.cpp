// Case 13: a ball on a sampled floor, after Gillespie and Cutkosky 1996. 0.35 kg and a handle of
// 0.006 kg, floor 5000 N/m, 10 ms. What the paper draws is derived here in numbers.
#include "gyrator/controllers/predictive_wall.hpp"
#include "gyrator/cosim/sampled_plant.hpp"
#include "gyrator/cosim/simulation.hpp"
#include "gyrator/mechanics/plant.hpp"

#include <cmath>
#include <numbers>
#include <vector>

#include <gtest/gtest.h>

namespace gyrator {
namespace {

constexpr double mass = 0.356, K = 5000, T = 0.01, weight = mass * 9.81;
constexpr double height = 0.08;  // dropped from, as the figure shows it
const Sampling ten_ms{Rational(1, 100), 0};

Plant make_ball() {
  Device ball;
  ball.motion = Motion::linear;
  ball.mechanics.inertia = mass;
  return build_plant(build_device_network(ball, FreeOperator{}));
}

PredictiveWall make_floor(PredictiveWall::Prediction prediction, bool dead_beat) {
  return {.stiffness = K,
          .device = {mass, 0, weight},
          .prediction = prediction,
          .dead_beat = dead_beat};
}
const Controller plain = VirtualWall{.stiffness = K, .unilateral = true};
const Controller half_sample = make_floor(PredictiveWall::Prediction::half_sample, false);
const Controller dead_beat = make_floor(PredictiveWall::Prediction::half_sample, true);

TimeRun drop(const Controller& controller, Rational duration = Rational(3, 2)) {
  SimulationOptions options;
  options.duration = duration;
  options.initial_position = -height;
  options.external_effort = weight;
  return simulate(make_ball(), {}, controller, ten_ms, options);
}

// Height of each bounce that ends in the run, from the energy of the flight behind it.
std::vector<double> find_bounces(const TimeRun& run) {
  const auto& x = run.trace.column("position");
  const auto& v = run.trace.column("velocity");
  const auto& u = run.trace.column("held_command_after");
  std::vector<double> heights;
  for (std::size_t k = 1; k + 1 < x.size(); ++k) {
    const bool flies = x[k] <= 0 && u[k] == 0 && v[k] < 0;
    if (flies && (x[k - 1] > 0 || u[k - 1] != 0))
      heights.push_back(-x[k] + v[k] * v[k] / (2 * 9.81));
  }
  return heights;
}

// The ball on a spring in continuous time.
MotionState bounce(MotionState s, double time) {
  const LinearMotion flight(mass, 0, 0, weight), contact(mass, 0, K, weight);
  for (bool inside = s.position > 0;; inside = !inside) {
    const LinearMotion& motion = inside ? contact : flight;
    const auto at = motion.find_crossing(s, time, inside);
    if (!at) return motion.after(s, time);
    s = {0, motion.after(s, *at).velocity};
    time -= *at;
  }
}

DominantPole find_contact_pole(const Controller& controller) {
  const auto law = make_contact_law(keep_in_contact(controller), T);
  return find_dominant_pole(build_loop_matrix(sample_plant(make_ball(), ten_ms), law), T);
}

TEST(BallBounce, poles_in_contact_are_where_the_reference_cases_say) {
  // z^2 - (2 - a/2) z + 1 + a/2 with a = K T^2/m = 1.404: |z| = sqrt(1 + a/2).
  const DominantPole sampled = find_contact_pole(plain);
  EXPECT_NEAR(sampled.magnitude, std::sqrt(1 + K * T * T / mass / 2), 1e-12);
  EXPECT_NEAR(sampled.magnitude, 1.30, 0.005);  // published to two digits
  EXPECT_NEAR(sampled.frequency_hz, 17, 0.5);   // "about"
  // Seen at mid-period, 1 + l T^2/2m ... cancels: no growth at all, at any stiffness that
  // oscillates.
  EXPECT_NEAR(find_contact_pole(half_sample).magnitude, 1, 1e-9);
  PredictiveWall without = std::get<PredictiveWall>(half_sample.law);
  without.prediction = PredictiveWall::Prediction::none;
  EXPECT_NEAR(find_contact_pole(without).magnitude, sampled.magnitude, 1e-9);
  for (const double share : {0.01, 0.5, 0.99}) {
    without.prediction = PredictiveWall::Prediction::half_sample;
    without.stiffness = share * 8 * mass / (T * T);
    EXPECT_NEAR(find_contact_pole(without).magnitude, 1, 1e-8) << share;
  }
  without.stiffness = 1.01 * 8 * mass / (T * T);
  EXPECT_GT(find_contact_pole(without).magnitude, 1.01);
}

TEST(BallBounce, grows_on_the_plain_sampled_floor) {
  const auto heights = find_bounces(drop(plain));
  ASSERT_GE(heights.size(), 2U);
  EXPECT_GT(heights[0], 1.5 * height);
  EXPECT_GT(heights.back(), 3 * height);
}

TEST(BallBounce, no_longer_grows_in_contact_but_leaves_wrong_with_the_half_sample_alone) {
  const auto heights = find_bounces(drop(half_sample));
  ASSERT_GE(heights.size(), 3U);
  for (const double h : heights) EXPECT_LT(h, find_bounces(drop(plain)).back());
  EXPECT_GT(std::abs(heights[0] / height - 1), 0.05);
}

TEST(BallBounce, is_the_ball_of_continuous_time_with_dead_beat_entry_and_exit) {
  // Ten seconds and thirty bounces. Positions of 0.08 m are known to 1e-17 and velocities from them
  // to 1e-15 m/s; an error of velocity moves the next landing by dv/g, and after n bounces the
  // position by some n^2 of them: 1e3 x 1e-15/9.81 x 1.25 m/s, with a factor of a hundred to spare.
  const TimeRun run = drop(dead_beat, Rational(10));
  const auto& x = run.trace.column("position");
  const auto& u = run.trace.column("command");
  MotionState reference{-height, 0};
  int compared = 0;
  for (std::size_t k = 0; k + 1 < x.size(); ++k) {
    if (k > 0) reference = bounce(reference, T);
    // Between the two samples of a correction the ball is on its way to the reference.
    if (u[k] == 0 && (k == 0 || u[k - 1] == 0)) {
      EXPECT_NEAR(x[k], reference.position, 1e-11) << k;
      ++compared;
    }
  }
  EXPECT_GT(compared, 600);
  const auto heights = find_bounces(run);
  EXPECT_GE(heights.size(), 30U);
  for (const double h : heights) EXPECT_NEAR(h, height, 1e-11);
}

}  // namespace
}  // namespace gyrator
