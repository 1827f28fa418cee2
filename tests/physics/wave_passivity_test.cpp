#include "gyrator/controllers/wave_controller.hpp"
#include "gyrator/cosim/sampled_plant.hpp"
#include "gyrator/mechanics/stability.hpp"
#include "gyrator/passivity/verdict.hpp"

#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>

#include <gtest/gtest.h>

#include "support/wave_display.hpp"

// A wall behind a wave line against the same wall from the position, on the same hardware.

namespace gyrator {
namespace {

using Complex = std::complex<double>;
using std::numbers::pi;
using testing::make_wave_controller;
using testing::make_wave_display;
using testing::wave_impedance;

const Sampling one_ms{Rational(1, 1000), 0};
const Sampling late{Rational(1, 1000), Rational(7, 10000)};

Device sense_position(Device device) {
  device.sensor = SensorLocation::port;
  return device;
}

StiffnessLimits make_limits(const Device& device, const Sampling& sampling) {
  return {device, sampling, make_wave_controller(device, MatchedEnvironment{}), FreeOperator{}};
}

TEST(WavePassivity,
     no_stiffness_is_too_much_behind_a_wave_line_where_the_position_wall_has_a_limit) {
  for (const double cancelled : {0.0, 0.9}) {
    const Device device = make_wave_display(cancelled, 10e3);
    for (const Sampling& sampling : {one_ms, late}) {
      StiffnessLimits waves = make_limits(device, sampling);
      for (const double B : {0.0, 1e-6, 1e-3, 0.1}) {
        const StiffnessLimit limit = waves.find(Criterion::exact_disk, B);
        EXPECT_TRUE(limit.feasible) << B;
        EXPECT_TRUE(std::isinf(limit.stiffness)) << B << ' ' << limit.stiffness;
      }
      const Device plain = sense_position(device);
      StiffnessLimits position(plain, sampling, NoController{}, FreeOperator{});
      const double K = position.find(Criterion::exact_disk, 0).stiffness;
      ASSERT_TRUE(std::isfinite(K));
      EXPECT_FALSE(judge_passivity({plain, VirtualWall{1.01 * K}, sampling, 0}, false).passive);
      for (const double share : {1.01, 10.0, 1e4}) {
        const WaveController wave = make_wave_controller(device, WaveWall{share * K, 0});
        EXPECT_TRUE(judge_passivity({device, wave, sampling, 0}, false).passive) << share;
      }
    }
  }
}

TEST(WavePassivity, the_disk_is_no_stricter_than_the_norm_argument) {
  // In wave variables P = Wbar/U: the norms say |P| <= 1, and |1 + H y/u| > 0 for every |Gamma| <=
  // 1 asks |c| + r < 1. Sampling treats the aliases apart, but their weights sinc^2 sum to one.
  for (const double cancelled : {0.0, 0.9, 0.999999}) {
    Device device = make_wave_display(cancelled);
    if (cancelled > 0.99) device.mechanics.damping = 1e-12;
    const double scale = 1 / make_wave_controller(device, MatchedEnvironment{}).volts_per_command;
    for (const Sampling& sampling : {one_ms, late}) {
      AliasedDisk disk(device, sampling);
      double most = 0;
      for (double share = 1e-5; share <= 1; share *= 1.2) {
        const double omega = share * pi * 1e3;
        const DiskPoint point = disk.at(omega);
        const double difference = 2 * std::sin(omega * 1e-3 / 2);  // |1 - z^-1|
        most = std::max(most, scale * difference / 1e-3 * (std::abs(point.center) + point.radius));
      }
      // A fractional delay's tail is cut after 200 aliases and its bound added.
      const double cut = sampling.delay == Rational(0) ? 0 : 2 / (200 * pi * pi);
      EXPECT_LT(most, 1 + 1e-9 + cut);
      if (cancelled > 0.99) {
        EXPECT_GT(most, 1 - 1e-3) << "a lossless device reaches the bound";
      }
    }
  }
}

TEST(WavePassivity, a_line_that_amplifies_has_a_limit_and_both_of_its_sides_are_as_they_should_be) {
  // An amplifier 10 % stronger than the controller knows: |1.1 Gamma| > 1 for a stiff enough wall.
  for (const double cancelled : {0.0, 0.9}) {
    const Device device = make_wave_display(cancelled);
    WaveController wave = make_wave_controller(device, MatchedEnvironment{});
    wave.volts_per_command /= 1.1;
    for (const double B : {1e-4, 1e-3}) {
      StiffnessLimits limits(device, one_ms, wave, FreeOperator{});
      const StiffnessLimit limit = limits.find(Criterion::exact_disk, B);
      ASSERT_TRUE(limit.feasible && std::isfinite(limit.stiffness)) << B;
      wave.environment = WaveWall{0.99 * limit.stiffness, B};
      EXPECT_TRUE(judge_passivity({device, wave, one_ms, 0}, false).passive) << B;
      wave.environment = WaveWall{1.01 * limit.stiffness, B};
      const Verdict beyond = judge_passivity({device, wave, one_ms, 0}, true);
      EXPECT_FALSE(beyond.passive) << B;
      ASSERT_TRUE(beyond.counterexample) << B;
      EXPECT_GT(beyond.counterexample->spectral_radius, 1 + stability_tolerance) << B;
      EXPECT_NEAR(beyond.counterexample->frequency_hz, limit.worst_frequency_hz,
                  0.1 * limit.worst_frequency_hz);
    }
  }
}

TEST(WavePassivity,
     cancelling_more_than_the_winding_breaks_the_line_though_the_drive_alone_is_stable) {
  for (const double cancelled : {0.99, 1.02}) {
    const Device device = make_wave_display(cancelled);
    EXPECT_NO_THROW(require_stable_device(device));
    const WaveController wave = make_wave_controller(device, WaveWall{0.05, 0});
    const Verdict verdict = judge_passivity({device, wave, one_ms, 0}, false);
    EXPECT_TRUE(verdict.device_passive) << "Re Z > 0 at the port";
    EXPECT_EQ(verdict.passive, cancelled < 1);
    EXPECT_EQ(verdict.loops.front().uncoupled_spectral_radius > 1 + stability_tolerance,
              cancelled > 1);
  }
}

TEST(WavePassivity, the_textbook_speaks_of_the_wall_from_the_position_and_does_not_apply) {
  const Device device = make_wave_display(0.9, 10e3);
  const WaveController wave = make_wave_controller(device, WaveWall{1, 1e-5});
  const Verdict verdict = judge_passivity({device, wave, one_ms, 0}, false);
  const Verdict plain =
      judge_passivity({sense_position(device), VirtualWall{1, 1e-5}, one_ms, 0}, false);
  EXPECT_TRUE(verdict.passive);
  ASSERT_EQ(verdict.criteria.size(), plain.criteria.size());
  for (std::size_t i = 0; i < verdict.criteria.size(); ++i) {
    const CriterionResult& criterion = verdict.criteria[i];
    if (criterion.name == "exact_disk") continue;
    EXPECT_FALSE(criterion.applies);
    EXPECT_EQ(criterion.reason.find("the controller reads a wave, not the position"), 0U);
    EXPECT_EQ(criterion.margin, plain.criteria[i].margin) << criterion.name;
    EXPECT_EQ(criterion.max_stiffness, plain.criteria[i].max_stiffness) << criterion.name;
  }
  EXPECT_EQ(verdict.curves.total, plain.curves.total);
}

// The loop whose controller reads the wave itself at the instants of sampling, not its average.
double find_point_sampled_radius(const Plant& plant, const WaveController& controller,
                                 const Sampling& sampling) {
  const SampledPlant sampled = sample_plant(plant, sampling);
  const double period = sampling.period.to_double();
  const DiscreteStateSpace law = make_wave_law(controller, period);
  const Eigen::Index n = plant.states(), q = law.states();
  // States: plant, the held command, the sum T W of what was read, the law's.
  Eigen::RowVectorXd read = Eigen::RowVectorXd::Zero(n + 2 + q);
  read.head(n) = period * plant.sensor_position.state * plant.A;
  read(n) = period * (plant.sensor_position.state * plant.B.col(0))(0);
  read(n + 1) = 1;
  Eigen::RowVectorXd command = -law.D * read;
  command.tail(q) -= law.C;
  Eigen::MatrixXd loop = Eigen::MatrixXd::Zero(n + 2 + q, n + 2 + q);
  loop.topLeftCorner(n, n) = sampled.phi;
  loop.topRows(n) += sampled.recent * command;
  loop.row(n) = command;
  loop.row(n + 1) = read;
  loop.bottomRightCorner(q, q) = law.A;
  loop.bottomRows(q) += law.B * read;
  return compute_spectral_radius(loop);
}

TEST(WavePassivity, a_point_sampled_wave_is_not_passive_where_the_averaged_one_is) {
  // The operator's spring and the rotor ring near Nyquist and the sampling frequency, where
  // averaging hardly listens but a point sample does. Even a wall of no stiffness then drives them.
  struct Case {
    double impedance, stiffness, spring, growth;
  };
  for (const Case& c : {Case{1e-4, 0, 12.46, 1.14}, Case{1e-3, 1e3, 9.423, 1.02}}) {
    Device device = make_wave_display(0.9);
    device.drive.damping.front() = WaveDamping{c.impedance};
    const Plant plant =
        build_plant(build_device_network(device, MassSpringDamper{0, 0, c.spring, {}}));
    WaveController wave = make_wave_controller(device, WaveWall{c.stiffness, 0});
    wave.impedance = c.impedance;
    const double averaged = compute_spectral_radius(
        build_loop_matrix(sample_plant(plant, one_ms), make_wave_law(wave, 1e-3)));
    EXPECT_LE(averaged, 1 + stability_tolerance) << c.stiffness;
    EXPECT_GT(find_point_sampled_radius(plant, wave, one_ms), c.growth) << c.stiffness;
  }
}

}  // namespace
}  // namespace gyrator
