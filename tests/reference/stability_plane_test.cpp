// Quantization, dry friction and sampling: cases 11 and 12, and the border of limit cycles.

#include "gyrator/passivity/verdict.hpp"
#include "gyrator/studies/stability_map.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>
#include <vector>

#include <gtest/gtest.h>

namespace gyrator {
namespace {

constexpr double T = 1e-3;  // s

// A mass on a quantized bilateral spring wall, between two quanta by a constant hand effort.
struct Display {
  double mass = 0.1, damping = 2, friction = 0.05;  // kg, N.s/m, N
  double quantum = 1e-5;                            // m
  Rational delay{0};                                // s

  Device device() const {
    Device d;
    d.motion = Motion::linear;
    d.mechanics.inertia = mass;
    d.mechanics.damping = damping;
    d.mechanics.coulomb_friction = friction;
    return d;
  }

  // Whether the mass comes to rest for good, after a kick of this many quanta per period.
  bool rests(double stiffness, double kick, Rational duration = Rational(2)) const {
    const Plant plant = build_moving_plant(build_device_network(device(), FreeOperator{}));
    SimulationOptions options;
    options.duration = duration;
    options.initial_position = quantum / 2;
    options.initial_velocity = kick * quantum / T;
    options.external_effort = stiffness * quantum / 2;
    const TimeRun run = simulate(plant, {.quantum = quantum}, VirtualWall{.stiffness = stiffness},
                                 {Rational(1, 1000), delay}, options);
    if (run.stopped_early) return false;
    const auto& velocity = run.trace.column("velocity");
    return std::all_of(velocity.end() - 200, velocity.end(), [](double v) { return v == 0; });
  }

  double find_border(double kick) const {
    double low = 0.1 * friction / quantum;
    double high = 20 * friction / quantum;
    EXPECT_TRUE(rests(low, kick));
    EXPECT_FALSE(rests(high, kick));
    for (int i = 0; i < 14; ++i) {
      const double middle = std::sqrt(low * high);
      (rests(middle, kick) ? low : high) = middle;
    }
    return low;
  }
};

TEST(Case11, criterion_is_the_smaller_of_sampling_and_quantization) {
  // K <= min(2 b/T, 2 f_c/Delta)                                              [8.5]
  const auto limit = [](double damping, double friction, double quantum) {
    Display display{.damping = damping, .friction = friction, .quantum = quantum};
    const Verdict verdict = judge_passivity({display.device(), VirtualWall{100}, {}, quantum});
    for (const auto& criterion : verdict.criteria) {
      if (criterion.name == "quantized_coulomb") return criterion.max_stiffness.value_or(-1);
    }
    return -1.0;
  };
  EXPECT_NEAR(limit(0.8, 0.05, 1e-5), 1600, 1e-6);
  EXPECT_NEAR(limit(8, 0.05, 1e-5), 10000, 1e-6);
  EXPECT_NEAR(limit(8, 0.05, 1e-4), 1000, 1e-6);
}

TEST(Case11, below_both_limits_the_mass_rests_after_any_kick_and_above_the_second_it_does_not) {
  const Display display;  // 2 b/T = 4000, 2 f_c/Delta = 10000 N/m
  for (const double kick : {0.2, 1.0, 5.0, 50.0}) EXPECT_TRUE(display.rests(3900, kick)) << kick;
  Display damped;
  damped.damping = 20;  // 2 b/T = 40000
  for (const double kick : {0.2, 1.0, 5.0}) {
    EXPECT_TRUE(damped.rests(9900, kick)) << kick;
    EXPECT_FALSE(damped.rests(10100, kick)) << kick;
  }
}

TEST(LimitCycles, begin_at_twice_the_friction_per_quantum_over_two_decades_of_quanta) {
  // The effort of half a quantum, K Delta/2, is what friction must hold. The damper is strong
  // enough for every K of the search: what is left is quantization.
  for (const double quantum : {1e-6, 3.2e-6, 1e-5, 3.2e-5, 1e-4}) {
    Display display;
    display.quantum = quantum;
    display.damping = 2 * T * 2 * display.friction / quantum;
    const double expected = 2 * display.friction / quantum;
    for (const double kick : {0.1, 2.0})
      EXPECT_NEAR(display.find_border(kick), expected, 0.01 * expected) << quantum << " " << kick;
  }
}

TEST(Case12, the_plane_is_passive_where_both_coordinates_reach_one_half) {
  EXPECT_EQ(judge_stability_region(0.51, 0.51, 0, 4), StabilityRegion::passive);
  EXPECT_EQ(judge_stability_region(0.51, 0.49, 0, 4), StabilityRegion::limit_cycle);
  EXPECT_EQ(judge_stability_region(0.49, 0.49, 0, 4), StabilityRegion::unstable);
  // The largest velocity that is still damped: sigma = 1/2 + 4 (1/2 - beta).
  EXPECT_EQ(judge_stability_region(0.4, 0.91, 0, 4), StabilityRegion::locally_stable);
  EXPECT_EQ(judge_stability_region(0.4, 0.89, 0, 4), StabilityRegion::unstable);
  // With delay beta >= 1/2 + T_d/T.
  EXPECT_EQ(judge_stability_region(1.4, 0.6, 1, 4), StabilityRegion::unstable);
  EXPECT_EQ(judge_stability_region(1.6, 0.6, 1, 4), StabilityRegion::passive);
}

Model make_plane_model(const Rational& delay) {
  Model model;
  model.file = "plane.json";
  model.device = Display{}.device();
  model.sensor.quantum = 1e-5;
  model.sampling = {Rational(1, 1000), delay};
  model.controller = VirtualWall{.stiffness = 1000};
  return model;
}

TEST(Case12, simulated_regions_are_never_worse_than_the_analysis) {
  for (const Rational& delay : {Rational(0), Rational(1, 1000)}) {
    StabilityMapRequest request;
    const double enough = 0.5 + 1000 * delay.to_double();
    request.beta = {0.2 * enough, 0.6 * enough, 1.04 * enough, 1.5 * enough};
    request.sigma = {0.2, 0.48, 0.52, 1.0};
    const auto result = make_stability_map_result(make_plane_model(delay), request);
    EXPECT_EQ(result["passive_points_that_do_not_rest"], 0);
    for (std::size_t i = 0; i < 4; ++i) {
      for (std::size_t j = 0; j < 4; ++j) {
        const std::string found = result["region"][i][j];
        const std::string analytic = result["analytic_region"][i][j];
        if (analytic == "passive" || analytic == "limit_cycle") {
          EXPECT_EQ(found, analytic) << request.beta[j] << " " << request.sigma[i];
        }
        // Below one half friction cannot hold the step of the spring: nothing ever rests.
        if (request.sigma[i] < 0.5) {
          EXPECT_NE(found, "passive");
        }
      }
    }
  }
}

TEST(Case12, a_kick_dies_out_where_friction_balances_the_energy_of_a_sinusoid) {
  // sigma = pi/4 xi' (1/2 - beta)                                               (plane-2)
  const double kick = 40;
  for (const double beta : {0.1, 0.3}) {
    Display display;
    const double stiffness = 1000;
    display.damping = beta * stiffness * T;
    const double sigma = std::numbers::pi / 4 * kick * (0.5 - beta);
    display.friction = 1.1 * sigma * stiffness * display.quantum;
    EXPECT_TRUE(display.rests(stiffness, kick, Rational(10))) << beta;
    display.friction = 0.9 * sigma * stiffness * display.quantum;
    EXPECT_FALSE(display.rests(stiffness, kick, Rational(10))) << beta;
  }
}

}  // namespace
}  // namespace gyrator
