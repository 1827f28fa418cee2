#include "gyrator/controllers/controller.hpp"
#include "gyrator/cosim/sampled_plant.hpp"
#include "gyrator/cosim/simulation.hpp"

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "support/device_list.hpp"

// Time against frequency domain: what a run does and what the loop's exact eigenvalues say.

namespace gyrator {
namespace {

using testing::make_device_list;
using testing::make_p3;
using testing::make_rc_display;

const Rational T(1, 1000);

struct Loop {
  Plant plant;
  Sampling sampling;
  VirtualWall wall;
  SampledPlant sampled;
  DiscreteStateSpace law;
  Eigen::MatrixXd matrix;

  Loop(const Device& device, const Operator& held_by, const Rational& delay, const VirtualWall& w)
      : plant(build_plant(build_device_network(device, held_by))),
        sampling{T, delay},
        wall(w),
        sampled(sample_plant(plant, sampling)),
        law(make_wall_law(w, T.to_double())),
        matrix(build_loop_matrix(sampled, law)) {}

  double radius() const { return compute_spectral_radius(matrix); }

  TimeRun run(const Rational& duration, double position, double velocity) const {
    SimulationOptions options;
    options.duration = duration;
    options.initial_position = position;
    options.initial_velocity = velocity;
    return simulate(plant, {}, wall, sampling, options);
  }
};

TEST(LoopEigenvalues, powers_of_the_loop_matrix_are_the_simulated_run) {
  // y[k] = sense M^k z[0], z[0] the start with the estimator at rest there and no command under
  // way.
  for (const auto& [name, device] : make_device_list()) {
    const double K = 4000 * device.mechanics.inertia;
    const VirtualWall wall{
        .stiffness = K, .damping = K / 800, .velocity = FilteredDifferenceEstimator{150}};
    for (const Rational& delay : {Rational(0), Rational(3, 10) * T, T, Rational(5, 2) * T}) {
      const Loop loop(device, FreeOperator{}, delay, wall);
      const TimeRun run = loop.run(Rational(60) * T, 0.01, 0.8);
      Eigen::VectorXd z = Eigen::VectorXd::Zero(loop.matrix.rows());
      const Eigen::Index n = loop.plant.states();
      z.head(n) = loop.plant.initial_state(0.01, 0.8);
      const auto& measured = run.trace.column("measured_position");
      z.segment(n, loop.law.states()) = loop.law.settled_state(measured.front());
      double largest = 0;
      for (const double y : measured) largest = std::max(largest, std::abs(y));
      for (const double y : measured) {
        // Two orders of the same exact steps, sixty times.
        ASSERT_NEAR(loop.sampled.sense * z.head(n), y, 1e-11 * largest)
            << name << ", delay " << delay.to_string();
        z = loop.matrix * z;
      }
    }
  }
}

TEST(LoopEigenvalues, a_run_decays_or_grows_by_the_spectral_radius) {
  // Of a lone oscillation x_k = a r^k cos(k theta + phi), x_{k+1}^2 - x_k x_{k+2} =
  // a^2 r^{2k+2} sin^2 theta: one number per sample that grows by r^2 exactly.
  for (const double stiffness : {300.0, 1500.0, 1605.351, 1700.0}) {
    for (const Rational& delay : {Rational(0), Rational(7, 10) * T}) {
      const Loop loop(make_p3(), FreeOperator{}, delay, VirtualWall{.stiffness = stiffness});
      const auto x = loop.run(Rational(300) * T, 0, 1).trace.column("position");
      const auto square = [&](std::size_t k) { return x[k + 1] * x[k + 1] - x[k] * x[k + 2]; };
      // The fast pole that a delay adds is far inside the circle: gone after 100 samples.
      for (std::size_t k = 100; k + 103 < x.size(); k += 40) {
        const double rate = std::pow(square(k + 100) / square(k), 1.0 / 200);
        EXPECT_NEAR(rate, loop.radius(), 1e-9) << stiffness << ", " << delay.to_string();
      }
    }
  }
}

TEST(LoopEigenvalues, a_run_oscillates_at_the_dominant_poles_frequency) {
  for (const double stiffness : {800.0, 1600.0, 1640.0}) {
    const Loop loop(make_p3(), FreeOperator{}, 0, VirtualWall{.stiffness = stiffness});
    const TimeRun run = loop.run(2, 0, 1);
    const double expected = find_dominant_pole(loop.matrix, T.to_double()).frequency_hz;
    // Crossings of a decaying swing's middle shift a little: 2 s hold some fifteen cycles a third.
    EXPECT_NEAR(run.classification.frequency_hz / expected, 1, 0.02) << stiffness;
  }
}

// The stiffness at which the radius passes one, between a stable and an unstable one.
double find_critical(const Device& device, const Operator& held_by, const Rational& delay,
                     double damping, double stable, double unstable) {
  for (int i = 0; i < 60; ++i) {
    const double middle = (stable + unstable) / 2;
    const Loop loop(device, held_by, delay, {.stiffness = middle, .damping = damping});
    (loop.radius() <= 1 ? stable : unstable) = middle;
  }
  return stable;
}

TEST(LoopEigenvalues, runs_on_both_sides_of_a_stability_limit_end_as_the_radius_says) {
  struct Case {
    const char* name;
    Device device;
    Operator held_by;
    Rational delay;
    double damping, stable, unstable;
  };
  const MassSpringDamper hand{.inertia = 0, .damping = 2, .stiffness = 400, .resonators = {}};
  Device compliant = make_rc_display();
  compliant.mechanics.transmission =
      Transmission{.stiffness = 20, .damping = 1e-3, .load_inertia = 1e-5};
  compliant.sensor = SensorLocation::motor;
  Device voltage = make_rc_display();
  voltage.drive.amplifier = VoltageAmplifier{.bandwidth_hz = 800, .output_resistance = 0.7};
  const std::vector<Case> cases{
      {"P3", make_p3(), hand, 0, 0, 100, 1e5},
      {"P3 and B, 1.5 periods late", make_p3(), hand, Rational(3, 2) * T, 0.4, 100, 1e5},
      {"RC display", make_rc_display(), FreeOperator{}, 0, 1.5e-4, 0.01, 10},
      {"RC display, 0.3 periods late", make_rc_display(), FreeOperator{}, Rational(3, 10) * T,
       1.5e-4, 0.01, 10},
      {"voltage drive", voltage, FreeOperator{}, 0, 0, 0.01, 100},
      {"compliant, sensed at the motor", compliant, FreeOperator{}, 0, 1e-4, 0.01, 10},
  };
  for (const Case& c : cases) {
    const double K = find_critical(c.device, c.held_by, c.delay, c.damping, c.stable, c.unstable);
    ASSERT_GT(K, 1.01 * c.stable) << c.name;
    ASSERT_LT(K, 0.99 * c.unstable) << c.name;
    for (const double side : {0.95, 1.05}) {
      const Loop loop(c.device, c.held_by, c.delay, {.stiffness = side * K, .damping = c.damping});
      // Long enough for the growth from half to half of the last third to pass the 2 % that the
      // classification wants: T/6 of log growth.
      const double samples = 6 * std::log(1.1) / std::abs(std::log(loop.radius()));
      const auto count = static_cast<std::int64_t>(std::clamp(samples, 600.0, 60000.0));
      const TimeRun run = loop.run(Rational(count) * T, 0, 1);
      EXPECT_EQ(run.classification.outcome, side > 1 ? Outcome::diverges : Outcome::settles)
          << c.name << " at " << side << " of " << K << ", radius " << loop.radius() << ", growth "
          << run.classification.growth;
    }
  }
}

TEST(LoopEigenvalues, at_the_limit_itself_the_run_is_a_cycle_for_ever) {
  const double K = find_critical(make_p3(), FreeOperator{}, 0, 0, 100, 1e4);
  EXPECT_NEAR(K, 1605.351, 1e-3);  // case 7
  const Loop loop(make_p3(), FreeOperator{}, 0, VirtualWall{.stiffness = K});
  const TimeRun run = loop.run(3, 0, 1);
  EXPECT_EQ(run.classification.outcome, Outcome::limit_cycle);
  EXPECT_NEAR(run.classification.growth, 1, 1e-3);  // extremes fall between samples
  EXPECT_NEAR(run.classification.frequency_hz,
              find_dominant_pole(loop.matrix, T.to_double()).frequency_hz, 0.03);
}

}  // namespace
}  // namespace gyrator
