#include "gyrator/amplifiers/experiment.hpp"

#include "gyrator/core/error.hpp"

#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

namespace gyrator {
namespace {

TEST(Experiment, NothingIsCommandedBeforeAndAfter) {
  for (const ExcitationKind kind : {ExcitationKind::dc, ExcitationKind::step, ExcitationKind::sine,
                                    ExcitationKind::chirp, ExcitationKind::prbs}) {
    const Excitation excitation{kind, DriveMode::voltage, 1, 0.5, 10, 20, 2};
    EXPECT_EQ(compute_command(excitation, -1e-9), 0);
    EXPECT_EQ(compute_command(excitation, 2), 0);
  }
}

TEST(Experiment, TheStepComesAtAQuarter) {
  const Excitation step{ExcitationKind::step, DriveMode::current, 0.2, 0.1, 0, 0, 1};
  EXPECT_EQ(compute_command(step, 0.2499), 0.1);
  EXPECT_DOUBLE_EQ(compute_command(step, 0.25), 0.3);
}

TEST(Experiment, TheChirpsFrequencyGoesFromOneEndToTheOther) {
  const Excitation chirp{ExcitationKind::chirp, DriveMode::current, 1, 0, 5, 50, 10};
  // u = sin(phi), phi'/(2 pi) = f + (f' - f) t/d: zeros of u counted in a quarter second.
  const auto zeros = [&](double from) {
    int count = 0;
    for (double t = from; t < from + 0.25; t += 1e-5)
      count += compute_command(chirp, t) * compute_command(chirp, t + 1e-5) < 0;
    return count;
  };
  EXPECT_NEAR(zeros(0), 2 * 0.25 * 5.6, 1.5);
  EXPECT_NEAR(zeros(9.7), 2 * 0.25 * 49.2, 1.5);
}

TEST(Experiment, ThePrbsIsMaximalAndBalanced) {
  const Excitation prbs{ExcitationKind::prbs, DriveMode::current, 1, 0, 1000, 0, 100};
  const int length = (1 << 15) - 1;
  int sum = 0;
  for (int k = 0; k < length; ++k) {
    const double u = compute_command(prbs, k * 1e-3);
    EXPECT_EQ(std::abs(u), 1);
    EXPECT_EQ(u, compute_command(prbs, (k + length) * 1e-3));
    sum += u > 0 ? 1 : -1;
  }
  EXPECT_EQ(sum, 1);  // one more 1 than 0
  // Of a maximal sequence the autocorrelation at any shift is -1.
  int correlation = 0;
  for (int k = 0; k < length; ++k)
    correlation +=
        compute_command(prbs, k * 1e-3) * compute_command(prbs, (k + 77) * 1e-3) > 0 ? 1 : -1;
  EXPECT_EQ(correlation, -1);
}

TEST(Experiment, WhatHasNoFrequencyOrDurationIsRefused) {
  Excitation sine{ExcitationKind::sine, DriveMode::current, 1, 0, 10, 0, 1};
  EXPECT_NO_THROW(check_excitation(sine));
  sine.frequency_hz = 0;
  EXPECT_THROW(check_excitation(sine), Error);
  sine.frequency_hz = 10;
  sine.duration = 0;
  EXPECT_THROW(check_excitation(sine), Error);
  sine.duration = std::nan("");
  EXPECT_THROW(check_excitation(sine), Error);
}

}  // namespace
}  // namespace gyrator
