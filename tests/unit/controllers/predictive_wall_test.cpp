#include "gyrator/controllers/predictive_wall.hpp"

#include "gyrator/controllers/controller.hpp"
#include "gyrator/controllers/law_family.hpp"
#include "gyrator/core/error.hpp"

#include <cmath>
#include <complex>
#include <random>

#include <gtest/gtest.h>

namespace gyrator {
namespace {

using Complex = std::complex<double>;

constexpr double T = 0.01;
const PredictiveWall floor_wall{.stiffness = 5000, .device = {0.356, 0, 3.49}};

// The device of the model under the law, sampled exactly; `hand` is not in the model.
struct Bench {
  Bench(const PredictiveWall& wall, MotionState start)
      : law(wall, T), device(wall.device), s(start) {}

  double step(double hand = 0) {
    const double u = law.step(s.position);
    s = LinearMotion(device.inertia, device.damping, 0, device.constant_effort + u + hand)
            .after(s, T);
    return u;
  }

  RunningController law;
  DeviceModel device;
  MotionState s;
};

// The same device at a wall in continuous time.
MotionState bounce(const PredictiveWall& wall, MotionState s, double time) {
  const DeviceModel& d = wall.device;
  const LinearMotion free(d.inertia, d.damping, 0, d.constant_effort);
  const LinearMotion contact(d.inertia, d.damping + wall.damping, wall.stiffness,
                             d.constant_effort);
  bool inside = s.position > 0;
  for (;;) {
    const LinearMotion& motion = inside ? contact : free;
    const auto at = motion.find_crossing(s, time, inside);
    if (!at) return motion.after(s, time);
    s = {0, motion.after(s, *at).velocity};
    time -= *at;
    inside = !inside;
  }
}

TEST(PredictiveWall, observes_the_velocity_of_its_model_from_the_second_sample_on) {
  PredictiveWall wall = floor_wall;
  wall.device.damping = 0.8;
  RunningPredictiveWall law(wall, T);
  MotionState s{-0.03, 0.4};
  EXPECT_EQ((law.step(s.position), law.velocity()), 0);
  for (int k = 0; k < 30; ++k) {
    const double u = k == 0 ? 0 : law.step(s.position);
    if (k > 0) {
      EXPECT_NEAR(law.velocity(), s.velocity, 1e-12) << k;  // 2e-16 of 0.03 m over 10 ms
    }
    s = LinearMotion(0.356, 0.8, 0, 3.49 + u).after(s, T);
  }
}

TEST(PredictiveWall, renders_the_wall_in_the_middle_of_the_held_period) {
  PredictiveWall wall = floor_wall;
  wall.dead_beat = false;
  wall.damping = 20;
  wall.device.damping = 0.8;
  Bench bench(wall, {0.004, 0});
  for (int k = 0; k < 3; ++k) {  // 20 ms of contact
    const MotionState now = bench.s;
    const double u = bench.step();
    if (now.position <= 0) continue;
    const MotionState middle = LinearMotion(0.356, 0.8, 0, 3.49 + u).after(now, T / 2);
    EXPECT_NEAR(-u, 5000 * middle.position + 20 * middle.velocity, 1e-9) << k;
  }
}

TEST(PredictiveWall, runs_the_law_that_its_transfer_function_tells) {
  PredictiveWall wall{.stiffness = 3000, .damping = 12, .device = {0.356, 0.8, 0}};
  wall.unilateral = false;
  for (const auto prediction :
       {PredictiveWall::Prediction::none, PredictiveWall::Prediction::half_sample}) {
    wall.prediction = prediction;
    const Complex z = std::polar(1.0, 0.6);
    const Complex H = find_linear_law(wall, T)->response(z);
    RunningController cosine(wall, T), sine(wall, T);
    for (int k = 0; k < 400; ++k) {
      const Complex y = std::polar(1.0, 0.6 * k);
      const Complex command(cosine.step(y.real()), sine.step(y.imag()));
      if (k < 200) continue;
      ASSERT_LE(std::abs(command + H * y), 1e-9) << k;  // of efforts of about 3e3
    }
  }
  wall.unilateral = true;
  EXPECT_FALSE(find_linear_law(wall, T).has_value());
  EXPECT_TRUE(find_linear_law(keep_in_contact(wall), T).has_value());
}

TEST(PredictiveWall, is_one_family_over_stiffness) {
  const PredictiveWall wall{.device = {0.356, 0.8, 0}};
  const LawFamily family(wall, T);
  for (const double omega : {1.0, 60.0, 300.0}) {
    const auto point = family.prepare(omega);
    const Complex z = std::polar(1.0, omega * T);
    for (const double K : {0.0, 700.0, 9000.0}) {
      const Complex H = family.at(point, 12).at(K);
      EXPECT_LE(std::abs(H - family.make(K, 12).response(z)), 1e-9 * (1 + std::abs(H)));
    }
  }
  EXPECT_FALSE(family.has(-1));
}

TEST(PredictiveWall, leaves_a_short_contact_exactly_where_the_continuous_wall_would) {
  std::mt19937 random(7);
  const auto between = [&](double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random);
  };
  int bounces = 0;
  for (int trial = 0; trial < 200; ++trial) {
    PredictiveWall wall{.stiffness = 1, .damping = 0, .device = {between(0.1, 1), 0, 0}};
    const double samples = between(0.5, 2.9);  // in contact
    wall.stiffness = wall.device.inertia * std::pow(3.14159 / (samples * T), 2);
    wall.damping = between(0, 0.3) * std::sqrt(wall.stiffness * wall.device.inertia);
    wall.device.damping = between(0, 2);
    const MotionState start{-between(0.05, 0.2), between(0.5, 2)};
    // The first sample knows no velocity: let it fall onto the second.
    Bench bench(wall, start);
    MotionState reference = start;
    for (int k = 0; k < 60; ++k) {
      bench.step();
      reference = bounce(wall, reference, T);
    }
    if (reference.velocity < 0) ++bounces;
    // Positions of 0.2 m to 2e-16, over 10 ms a velocity to 4e-15, times up to 60 samples.
    EXPECT_NEAR(bench.s.position, reference.position, 1e-12) << trial;
    EXPECT_NEAR(bench.s.velocity, reference.velocity, 1e-11) << trial;
  }
  EXPECT_GT(bounces, 150);
}

TEST(PredictiveWall, keeps_a_resting_hand_at_rest) {
  // A hand that the model knows nothing of presses with 0.5 N through 0.2 N.s/m and 4 N/m; half an
  // oscillation of the device at the wall lasts 27 samples.
  PredictiveWall wall = floor_wall;
  wall.stiffness = 50;
  wall.damping = 1;
  wall.device.constant_effort = 0;
  Bench bench(wall, {-0.01, 0});
  for (int k = 0; k < 3000; ++k) bench.step(0.5 - 4 * bench.s.position - 0.2 * bench.s.velocity);
  EXPECT_NEAR(bench.s.velocity, 0, 1e-6);
  // At rest the observer takes F for a motion of -F T/2m out of the wall: softer than K, by what
  // the transfer function says of a constant position.
  const double stiffness = make_predictive_law(wall, T).response(1).real();
  EXPECT_LT(stiffness, 50);
  EXPECT_NEAR(bench.s.position, 0.5 / (4 + stiffness), 1e-9);
}

TEST(PredictiveWall, refuses_a_device_without_inertia) {
  for (const PredictiveWall& wall :
       {PredictiveWall{.stiffness = 1, .device = {}},
        PredictiveWall{.stiffness = -1, .device = {1, 0, 0}},
        PredictiveWall{.damping = -1, .device = {1, 0, 0}}, PredictiveWall{.device = {1, -1, 0}}}) {
    EXPECT_THROW(RunningController(wall, T), Error);
    EXPECT_THROW(make_predictive_law(wall, T), Error);
  }
}

}  // namespace
}  // namespace gyrator
