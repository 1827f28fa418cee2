#include "gyrator/tuning/measured_verdict.hpp"

#include "gyrator/core/error.hpp"
#include "gyrator/passivity/port_response.hpp"
#include "gyrator/passivity/stiffness_limit.hpp"

#include <gtest/gtest.h>

#include "unit/tuning/drive_example.hpp"

namespace gyrator {
namespace {

using namespace tuning_example;

MotorDrive rc() {
  return {};
}

MotorDrive cancelled() {
  MotorDrive drive;
  drive.cancelled = 0.85 * drive.R;
  return drive;
}

double limit_of(const PassivityModel& model, double damping) {
  return StiffnessLimits(model.device, model.sampling, model.controller, FreeOperator{})
      .find_on_grid(damping)
      .stiffness;
}

TEST(DriveResponse, SinesGiveImpedanceAndActuationOfTheNetwork) {
  for (const DriveMode mode : {DriveMode::current, DriveMode::voltage}) {
    const MotorDrive drive = mode == DriveMode::current ? rc() : cancelled();
    const PassivityModel model = make_model(drive, mode, 0.01, 0);
    PortModel port(model.device);
    const double gain = find_amplifier_gain(model.device);
    const DriveMeasurement m = measure(drive, mode);
    for (std::size_t i = 0; i < m.bare.size(); ++i) {
      const DrivePoint point =
          find_drive_point(mode, *model.device.drive.motor, m.bare[i], m.damped[i]);
      const DrivePort found = find_drive_port(mode, drive.K, gain, point);
      const double omega = 2 * std::numbers::pi * found.frequency_hz;
      const PortResponse expected = port.at(omega);
      const std::complex<double> mechanics(drive.b, omega * drive.J);
      EXPECT_LT(std::abs(found.actuation - expected.actuation), 1e-9) << found.frequency_hz;
      EXPECT_LT(std::abs(mechanics + found.impedance - expected.impedance),
                1e-9 * std::abs(expected.impedance))
          << found.frequency_hz;
      EXPECT_NEAR(point.winding.real(), drive.R, 1e-9);
      EXPECT_NEAR(point.winding.imag(), omega * drive.L, 1e-9 * (drive.R + omega * drive.L));
    }
  }
}

TEST(MeasuredVerdict, WithoutNoiseTheLimitIsTheModels) {
  for (const DriveMode mode : {DriveMode::current, DriveMode::voltage}) {
    const MotorDrive drive = mode == DriveMode::current ? rc() : cancelled();
    PassivityModel model = make_model(drive, mode, 0, 1e-4);
    const double limit = limit_of(model, 1e-4);
    for (const double share : {0.98, 1.02}) {
      std::get<VirtualWall>(model.controller.law).stiffness = share * limit;
      const MeasuredVerdict verdict = judge_measured(model, measure(drive, mode), 1, 0);
      EXPECT_EQ(verdict.passive, share < 1) << share;
      EXPECT_NEAR(verdict.max_stiffness, limit, 2e-3 * limit);
      EXPECT_NEAR(verdict.modelled_max_stiffness, limit, 2e-3 * limit);
    }
  }
}

TEST(MeasuredVerdict, TheMeasurementDecidesWhereTheModelIsWrong) {
  for (const DriveMode mode : {DriveMode::current, DriveMode::voltage}) {
    MotorDrive assumed = mode == DriveMode::current ? rc() : cancelled();
    MotorDrive real = assumed;
    real.C *= 1.4;
    real.cancelled *= 0.9;
    real.bandwidth_hz *= 0.8;
    PassivityModel model = make_model(assumed, mode, 0.01, 1e-4);
    const double modelled = limit_of(model, 1e-4);
    PassivityModel truth = make_model(real, mode, 0.01, 1e-4);
    truth.device.gain = find_amplifier_gain(model.device);  // set once, by what was assumed
    const double limit = limit_of(truth, 1e-4);
    ASSERT_GT(std::abs(limit / modelled - 1), 0.1);
    const MeasuredVerdict verdict = judge_measured(model, measure(real, mode), 1, 0);
    // Between the sines the ratio of the two is interpolated.
    EXPECT_NEAR(verdict.max_stiffness, limit, 0.03 * limit);
  }
}

TEST(MeasuredVerdict, TheAmplifiersDelayIsNotCountedTwice) {
  const MotorDrive drive = rc();
  PassivityModel model = make_model(drive, DriveMode::current, 0.01, 1e-4);
  model.sampling.delay = Rational{1, 5000};
  const double limit = limit_of(model, 1e-4);
  const MeasuredVerdict verdict =
      judge_measured(model, measure(drive, DriveMode::current, 2e-4), 1, 0);
  EXPECT_NEAR(verdict.max_stiffness, limit, 3e-3 * limit);
}

TEST(MeasuredVerdict, TheBoundsHoldTheTrueLimitUnderNoise) {
  const MotorDrive drive = rc();
  PassivityModel model = make_model(drive, DriveMode::current, 0.01, 1e-4);
  const double limit = limit_of(model, 1e-4);
  int below = 0;
  constexpr int repetitions = 40;
  for (int k = 0; k < repetitions; ++k) {
    const auto m = with_noise(measure(drive, DriveMode::current), 1e-3, 100 + k);
    const MeasuredVerdict verdict = judge_measured(model, m, 1, 60);
    below += verdict.max_stiffness_low <= limit;
    EXPECT_GT(verdict.max_stiffness_low, 0.5 * limit);
    for (const MeasuredPoint& point : verdict.points)
      EXPECT_LT(point.damping_low, point.damping_high);
  }
  // 99 % nominally; 36 of 40 or fewer would come once in 2000 at 99 %.
  EXPECT_GE(below, 37);
}

TEST(MeasuredVerdict, WhatCannotBeJudgedIsRefused) {
  const MotorDrive drive = rc();
  const auto m = measure(drive, DriveMode::current);
  PassivityModel model = make_model(drive, DriveMode::current, 0.01, 1e-4);
  model.device.mechanics.transmission = Transmission{10, 0.01, 1e-5};
  EXPECT_THROW(judge_measured(model, m), Error);
  model = make_model(drive, DriveMode::current, 0.01, 1e-4);
  auto few = m;
  few.bare.resize(3);
  few.damped.resize(3);
  EXPECT_THROW(judge_measured(model, few), Error);
  few.damped.push_back(m.damped.back());
  EXPECT_THROW(judge_measured(model, few), Error);
}

}  // namespace
}  // namespace gyrator
