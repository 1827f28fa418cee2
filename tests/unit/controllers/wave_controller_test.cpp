#include "gyrator/controllers/wave_controller.hpp"

#include "gyrator/controllers/law_family.hpp"
#include "gyrator/core/error.hpp"

#include <algorithm>
#include <cmath>
#include <complex>
#include <random>
#include <vector>

#include <gtest/gtest.h>

namespace gyrator {
namespace {

using Complex = std::complex<double>;

constexpr double T = 1e-3, b_w = 1e-3, K_t = 23.5e-3, per_command = 55;
constexpr double rounding = 1e-12;

WaveController make(const WaveEnvironment& environment) {
  return {b_w, K_t, per_command, environment};
}

// Gamma = (b_w - Z)/(b_w + Z), Z = B + K T/2 (z + 1)/(z - 1), of (wave-3).
Complex reflect(const WaveWall& wall, Complex z) {
  const Complex Z = wall.damping + wall.stiffness * T / 2 * (z + 1.0) / (z - 1.0);
  return (b_w - Z) / (b_w + Z);
}

std::vector<WaveWall> make_walls() {
  std::vector<WaveWall> walls;
  for (const double K : {0.0, 1e-3, 0.3, 2.0, 50.0, 1e6}) {
    for (const double B : {0.0, 1e-5, 1e-3, 0.4, -3e-4}) walls.push_back({K, B});
  }
  return walls;
}

TEST(WaveController, law_is_the_reflection_of_the_averaged_wave) {
  for (const WaveWall& wall : make_walls()) {
    const DiscreteStateSpace law = make_wave_law(make(wall), T);
    for (const double angle : {1e-3, 0.1, 0.7, 1.9, 3.0, 3.14159}) {
      const Complex z = std::polar(1.0, angle);
      const Complex H = -reflect(wall, z) * (1.0 - 1.0 / z) / (T * per_command);
      // Differences of numbers of size 1/(T per_command) at most.
      EXPECT_LE(std::abs(law.response(z) - H), 1e3 * rounding / (T * per_command))
          << wall.stiffness << ' ' << wall.damping << ' ' << angle;
    }
  }
}

TEST(WaveController, reflects_no_more_than_comes_for_every_stiffness_and_damping) {
  for (const WaveWall& wall : make_walls()) {
    const DiscreteStateSpace law = make_wave_law(make(wall), T);
    double most = 0;
    for (double angle = 0.01; angle < 3.14; angle += 0.01) {
      const Complex z = std::polar(1.0, angle);
      const Complex gamma = -law.response(z) * T * per_command / (1.0 - 1.0 / z);
      most = std::max(most, std::abs(gamma));
    }
    // A spring alone reflects all of it; a negative damper more.
    if (wall.damping < 0) {
      EXPECT_GT(most, wall.stiffness < 100 ? 1.5 : 1) << wall.stiffness;
    } else {
      EXPECT_LE(most, 1 + 1e4 * rounding) << wall.stiffness << ' ' << wall.damping;
    }
    if (wall.damping == 0) {
      EXPECT_GT(most, 1 - 1e4 * rounding) << wall.stiffness;
    }
  }
}

TEST(WaveController, runs_the_law_that_its_state_space_tells) {
  std::mt19937_64 random(3);
  std::uniform_real_distribution<double> wave(-2, 2);
  for (const WaveWall& wall : make_walls()) {
    RunningWaveController running(make(wall), T);
    const DiscreteStateSpace law = make_wave_law(make(wall), T);
    DiscreteLawState state(law);
    double y = 0;
    for (int k = 0; k < 400; ++k) {
      const double opposing = state.step(law, y);
      // Commands of 2 V; y and its difference lose what 400 samples add up to.
      ASSERT_NEAR(running.step(y), -opposing, 1e3 * rounding) << wall.stiffness << ' ' << k;
      y += T * wave(random);
    }
  }
}

TEST(WaveController, family_is_the_law_over_the_stiffness) {
  const LawFamily behind_line(make(MatchedEnvironment{}), T);
  const LawFamily plain(VirtualWall{.velocity = FilteredDifferenceEstimator{80}}, T);
  for (const LawFamily* family : {&behind_line, &plain}) {
    for (const double B : {0.0, 4e-4, -4e-4}) {
      for (const double omega : {0.3, 40.0, 900.0, 3141.0}) {
        const MobiusLaw law = family->at(family->prepare(omega), B);
        for (const double K : {0.0, 0.02, 3.0, 1e5}) {
          const Complex direct = family->make(K, B).response(std::polar(1.0, omega * T));
          EXPECT_LE(std::abs(law.at(K) - direct), 1e3 * rounding * (std::abs(direct) + 20))
              << omega << ' ' << K << ' ' << B;
        }
      }
    }
  }
  EXPECT_TRUE(behind_line.has(-0.99 * b_w));
  EXPECT_FALSE(behind_line.has(-b_w));
  EXPECT_TRUE(plain.has(-1e9));
}

TEST(WaveController, a_matched_environment_keeps_still) {
  RunningWaveController running(make(MatchedEnvironment{}), T);
  for (const double y : {0.0, 1.0, -3.0}) EXPECT_EQ(running.step(y), 0);
  EXPECT_EQ(make_wave_law(make(MatchedEnvironment{}), T).D, 0);
}

TEST(WaveController, takes_the_first_sample_as_no_wave) {
  RunningWaveController running(make(WaveWall{0, 0}), T);
  EXPECT_EQ(running.step(0.7), 0);
  // Z = 0 sends back what comes: U = W = 2e-3 V.s / 1 ms.
  EXPECT_NEAR(running.step(0.702), 2 / per_command, 1e3 * rounding);
}

TEST(WaveController, a_wall_entered_at_the_start_pushes_its_environment_out) {
  RunningWaveController running(make(WaveWall{2, 0, true}), T, 0.01);
  EXPECT_LT(running.step(0), 0) << "opposes a positive position";
  EXPECT_LT(running.position(), 0.01);
}

// One step by what (wave-5) says, for whatever displacement the controller found.
double effort_of(const WaveWall& wall, double from, double to) {
  const double outer = std::max(to, 0.0), inner = std::max(from, 0.0);
  if (to == from) return from > 0 ? wall.stiffness * from : 0;
  return wall.stiffness / 2 * (outer * outer - inner * inner) / (to - from) +
         wall.damping * (outer - inner) / T;
}

TEST(WaveController, unilateral_finds_the_one_answer_to_every_wave) {
  for (const WaveWall& values : make_walls()) {
    WaveWall wall = values;
    wall.unilateral = true;
    for (const double from : {-0.3, -1e-3, -1e-9, 0.0, 1e-9, 1e-3, 0.3}) {
      double last = -INFINITY;
      for (double w = -400; w <= 400; w += 0.37) {
        RunningWaveController running(make(wall), T, from);
        running.step(0);
        const double start = running.position();
        const double command = running.step(K_t * T * w);
        const double v = (running.position() - start) / T;
        const double f = effort_of(wall, start, running.position());
        const double size = std::abs(w) + std::abs(v) + std::abs(f / b_w);
        // The position's own rounding makes that of v, and with K of f.
        const double known =
            1e3 * 0x1p-52 *
            (size + (1 + (wall.stiffness * T + wall.damping) / b_w) * std::abs(start) / T);
        ASSERT_NEAR(v + f / b_w, w, known) << wall.stiffness << ' ' << wall.damping << ' ' << from;
        ASSERT_NEAR(command * per_command / K_t, v - f / b_w, 2 * known);
        ASSERT_GE(running.position(), last - 1e-12) << "not monotone";
        last = running.position();
      }
    }
  }
}

TEST(WaveController, unilateral_never_gives_back_more_than_it_took) {
  // Energy taken, T K_t^2-free: sum of (W^2 - U^2) over any run from outside is stored or lost.
  std::mt19937_64 random(11);
  std::normal_distribution<double> wave(0, 1);
  for (const WaveWall& values : make_walls()) {
    if (values.damping < 0) continue;
    WaveWall wall = values;
    wall.unilateral = true;
    RunningWaveController running(make(wall), T, -2e-3);
    double y = 0, previous = 0, balance = 0, moved = 0;
    for (int k = 0; k < 3000; ++k) {
      const double W = (y - previous) / T;
      const double U = per_command * running.step(y);
      previous = y;
      balance += (W * W - U * U) / (4 * K_t * K_t) * b_w * T;
      moved += W * W / (4 * K_t * K_t) * b_w * T;
      const double p = std::max(0.0, running.position());
      ASSERT_GE(balance, wall.stiffness / 2 * p * p - 1e-9 * moved) << wall.stiffness << ' ' << k;
      y += T * K_t * wave(random);
    }
    if (wall.damping == 0) {  // lossless: all of it is there
      const double p = std::max(0.0, running.position());
      EXPECT_NEAR(balance, wall.stiffness / 2 * p * p, 1e-9 * moved) << wall.stiffness;
    }
  }
}

TEST(WaveController, refuses_a_damper_that_no_wave_can_answer) {
  EXPECT_NO_THROW(make_wave_law(make(WaveWall{1, -0.99 * b_w}), T));
  for (const WaveController& bad :
       {make(WaveWall{1, -b_w}), WaveController{0, K_t, 1, MatchedEnvironment{}},
        WaveController{b_w, K_t, 0, MatchedEnvironment{}}}) {
    EXPECT_THROW(make_wave_law(bad, T), Error);
    EXPECT_THROW(RunningWaveController(bad, T), Error);
  }
}

}  // namespace
}  // namespace gyrator
