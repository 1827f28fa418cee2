#include "gyrator/identification/sine_fit.hpp"

#include "gyrator/core/error.hpp"
#include "gyrator/core/random_stream.hpp"
#include "gyrator/identification/estimate.hpp"

#include <cmath>
#include <complex>
#include <numbers>
#include <vector>

#include <gtest/gtest.h>

namespace gyrator {
namespace {

constexpr double period = 1e-4, start = 0.05, frequency = 135;
constexpr int samples = 2000;
const std::complex<double> truth(0.3, -0.7);

std::vector<double> make_signal(double noise, double quantum, RandomStream& random) {
  std::vector<double> signal;
  for (int k = 0; k < samples; ++k) {
    const double t = start + k * period, w = 2 * std::numbers::pi * frequency;
    const double x = (truth * std::polar(1.0, w * t)).real() + 0.1 * std::cos(3 * w * t + 1) + 2 +
                     5 * t - 7 * t * t + noise * random.normal();
    signal.push_back(quantum > 0 ? quantum * std::round(x / quantum) : x);
  }
  return signal;
}

TEST(SineFit, FindsTheSineBesideHarmonicsAndDrift) {
  RandomStream random(1, 1);
  const SineFit fit = fit_sine(make_signal(0, 0, random), start, period, frequency, {3, 2});
  EXPECT_NEAR(std::abs(fit.coefficient - truth), 0, 1e-9);
  EXPECT_LT(fit.residual, 1e-9);
}

// Of 400 parts, 4 and 40 lie outside of 99 % and 90 % intervals, with deviations of 2 and 6; the
// bounds are about four of these away.
struct Misses {
  int at_99 = 0, at_90 = 0;
};
Misses count_misses(double noise, double quantum) {
  RandomStream random(2, 1);
  Misses misses;
  for (int repetition = 0; repetition < 200; ++repetition) {
    const SineFit fit =
        fit_sine(make_signal(noise, quantum, random), start, period, frequency, {3, 2});
    const std::complex<double> off = (fit.coefficient - truth) / fit.deviation;
    for (const double part : {off.real(), off.imag()}) {
      misses.at_99 += std::abs(part) > find_student_quantile(0.995, 18);
      misses.at_90 += std::abs(part) > find_student_quantile(0.95, 18);
    }
  }
  return misses;
}

TEST(SineFit, ItsDeviationIsThatOfWhiteNoise) {
  const Misses misses = count_misses(0.05, 0);
  EXPECT_LE(misses.at_99, 13);
  EXPECT_GE(misses.at_90, 16);
  EXPECT_LE(misses.at_90, 66);
}

TEST(SineFit, ItsDeviationHoldsForCoarseSteps) {
  const Misses misses = count_misses(0.02, 0.05);
  EXPECT_LE(misses.at_99, 13);
  EXPECT_LE(misses.at_90, 66);
}

TEST(SineFit, RefusesTooFewSamples) {
  const std::vector<double> few(7, 1.0);
  EXPECT_THROW(fit_sine(few, 0, period, frequency), Error);
}

}  // namespace
}  // namespace gyrator
