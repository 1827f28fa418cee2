// The checker's own parts against closed forms, for a point mass with viscous friction under an
// ideal drive, where everything is known: D = b + b_v exactly.

#include "gyrator/verification/alias_bands.hpp"
#include "gyrator/verification/margin_enclosure.hpp"
#include "gyrator/verification/sampled_disk.hpp"
#include "gyrator/verification/sampled_loop.hpp"

#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

namespace gyrator {
namespace {

using std::numbers::pi;
using Complex = std::complex<double>;

constexpr double mass = 2e-5;
constexpr double friction = 3e-4;
const Sampling sampling{Rational(1, 1000), Rational(0), Rational(0)};
constexpr double period = 1e-3;

HeldDevice make_point_mass() {
  HeldDevice device;
  device.system = {Eigen::MatrixXd(0, 0), Eigen::MatrixXd(0, 2), Eigen::MatrixXd(1, 0),
                   Eigen::MatrixXd(1, 2)};
  device.system.D << -1, friction;
  device.port_inertia = mass;
  return device;
}

// The same behind a low-pass in the command path, A = 1/(1 + s lag), so that D has no closed form.
HeldDevice make_lagging_mass(double lag) {
  HeldDevice device;
  device.system = {Eigen::MatrixXd::Constant(1, 1, -1 / lag), Eigen::MatrixXd(1, 2),
                   Eigen::MatrixXd::Constant(1, 1, -1), Eigen::MatrixXd(1, 2)};
  device.system.B << 1 / lag, 0;
  device.system.D << 0, friction;
  device.port_inertia = mass;
  return device;
}

DiscreteStateSpace make_wall(double stiffness, double damping) {
  return {Eigen::MatrixXd::Zero(1, 1), Eigen::VectorXd::Ones(1),
          Eigen::RowVectorXd::Constant(1, -damping / period), stiffness + damping / period};
}

// T/(2(1 - cos wT)) Re{(e^(-jwT) - 1) H z^-m}
double virtual_damping(const DiscreteStateSpace& law, double omega, int delay = 0) {
  using Long = long double;
  const Long angle = static_cast<Long>(omega) / 1000;
  const std::complex<Long> back = std::polar<Long>(1, -angle);
  const std::complex<Long> late = std::polar<Long>(1, -angle * delay);
  const Long half = std::sin(angle / 2);  // 1 - cos = 2 sin^2 of the half
  return static_cast<double>(
      ((back - std::complex<Long>(1)) * compute_law(law, angle) * late).real() /
      (1000 * 4 * half * half));
}

TEST(SampledDisk, IsThePhysicalAndTheVirtualDampingOfAPointMass) {
  const auto wall = make_wall(0.4, 1e-4);
  for (const int delay : {0, 1, 3}) {
    Sampling delayed = sampling;
    delayed.delay = Rational(delay, 1000);
    const SampledDisk disk(make_point_mass(), delayed);
    for (const double share : {1e-4, 0.01, 0.3, 0.77, 1.0}) {
      const double omega = share * pi / period;
      const double exact = friction + virtual_damping(wall, omega, delay);
      const auto margin = static_cast<double>(
          disk.at(omega).margin(compute_law(wall, static_cast<long double>(omega) / 1000)));
      // Both in extended precision, as differences of terms of size K/w.
      EXPECT_NEAR(margin, exact, 1e-15 * (std::abs(exact) + 0.4 / omega)) << share << delay;
    }
  }
}

TEST(SampledDisk, SumsAFractionalDelayAsALongDirectSumDoes) {
  Sampling delayed = sampling;
  delayed.delay = Rational(3, 10000);
  const HeldDevice device = make_lagging_mass(2e-4);
  const double omega = 900;
  const SampledDiskPoint point = SampledDisk(device, delayed).at(omega);
  std::complex<long double> sum = 0;
  constexpr int terms = 30000;
  for (int n = terms; n >= -terms; --n) {
    const double w = omega + 2 * pi * n / period;
    const HeldResponse r = compute_held_response(device, w);
    sum += std::polar<long double>(1, -w * 3e-4) *
           (r.blocked + r.actuation / (2 * r.impedance.real())) / std::complex<long double>(-w * w);
  }
  sum *= (std::complex<long double>(1) - std::polar<long double>(1, -omega * period)) / 1e-3L;
  // Left out: less than the first term beyond, 1/(2 b) lag^-1 (rate terms)^-3 and its like.
  EXPECT_LT(std::abs(sum - point.center) / point.radius, 1e-9L);
}

TEST(Zeta, IsTheSumOfInverseSquaresAndCubes) {
  long double squares = 0;
  for (int n = 1; n < 33; ++n) squares += 1.0L / (n * n);
  constexpr long double all = std::numbers::pi_v<long double> * std::numbers::pi_v<long double> / 6;
  EXPECT_LT(std::abs(compute_zeta<long double>(2, 33) - (all - squares)), 1e-17L);
  constexpr long double apery = 1.2020569031595942853997L;
  long double cubes = 0;
  for (int n = 1; n < 33; ++n) cubes += 1.0L / (1.0L * n * n * n);
  EXPECT_LT(std::abs(compute_zeta<long double>(3, 33) - (apery - cubes)), 1e-17L);
}

TEST(SlopeForm, HoldsWhatItEncloses) {
  constexpr double omega = 3;
  constexpr double reach = 0.4;
  const SlopeForm w = frequency_form(omega, reach);
  const SlopeForm turn = delay_form(omega, 0.7, reach);
  const SlopeForm form = magnitude(turn * invert(w) + SlopeForm::constant({0.3, -0.2})) *
                         real_part(conjugate(turn) * w) * sinc_form(omega, 0.5, reach);
  for (int i = -20; i <= 20; ++i) {
    const double t = reach * i / 20;
    const double x = omega + t;
    const Complex e = std::polar(1.0, -0.7 * x);
    const double exact = std::abs(e / x + Complex(0.3, -0.2)) * (std::conj(e) * x).real() *
                         std::sin(x / 2) / (x / 2);
    const double off = std::abs(exact - form.value - t * form.slope.middle);
    EXPECT_LE(off, std::abs(t) * form.slope.radius + 1e-14);
  }
  // And is exact to second order: a tenth of the reach leaves a tenth of the slope's width.
  const SlopeForm narrow = invert(frequency_form(omega, reach / 10));
  EXPECT_LT(narrow.slope.radius, 0.12 * invert(w).slope.radius);
}

TEST(MarginEnclosure, HoldsTheMarginAtEveryPointAndIsSharp) {
  for (const Rational delay : {Rational(0), Rational(1, 4000)}) {
    Sampling delayed = sampling;
    delayed.delay = delay;
    const HeldDevice device = make_lagging_mass(1e-4);
    const auto wall = make_wall(0.2, 5e-5);
    const SampledDisk disk(device, delayed);
    const MarginEnclosure enclosure(device, delayed, wall);
    for (const double omega : {0.3, 30.0, 700.0, 3000.0}) {
      const double reach = 0.02 * omega;
      const MarginBound bound = enclosure.over(omega, reach);
      double least = 1;
      for (int i = -8; i <= 8; ++i) {
        const double w = omega + reach * i / 8;
        least =
            std::min(least, static_cast<double>(disk.at(w).margin(compute_law(wall, w * period))));
      }
      EXPECT_LE(bound.lowest, least);
      EXPECT_GT(bound.lowest, least - 0.05 * friction) << omega;
    }
  }
}

TEST(MarginEnclosure, ReachesZeroFrequency) {
  const auto wall = make_wall(0.2, 5e-5);
  const MarginEnclosure enclosure(make_point_mass(), sampling, wall);
  const auto lowest = enclosure.lowest_below(0.01);
  ASSERT_TRUE(lowest);
  const double limit = friction - 0.2 * period / 2 + 5e-5;  // b - K T/2 + B
  EXPECT_LE(*lowest, limit);
  EXPECT_NEAR(*lowest, limit, 1e-4 * limit);
}

TEST(LoopPole, OfAHeldMassIsThatOfItsOscillation) {
  const auto nothing = make_wall(0, 0);
  MassSpringDamper hand{3e-5, 0, 2.0, {}};
  const LoopPole pole = find_loop_pole(make_point_mass(), sampling, nothing, hand);
  // The position is the hand's spring's too, and no pole at one of its own.
  EXPECT_NEAR(pole.magnitude, std::exp(-friction * period / (2 * (mass + 3e-5))), 1e-12);
  HeldDevice lossless = make_point_mass();
  lossless.system.D(0, 1) = -1e-4;  // supplies energy: grows as e^(1e-4 T/(2 (m + m_o)))
  const LoopPole growing = find_loop_pole(lossless, sampling, nothing, hand);
  const double total = mass + 3e-5;
  EXPECT_NEAR(growing.magnitude, std::exp(1e-4 * period / (2 * total)), 1e-12);
  const double turn = std::sqrt(2.0 / total - std::pow(1e-4 / (2 * total), 2));
  EXPECT_NEAR(growing.frequency_hz, turn / (2 * pi), 1e-8 * turn);
}

TEST(LoopPole, CountsEveryCommandUnderWay) {
  // A spring of the controller's on a mass without friction, through any delay, pumps: the growth
  // per period is K (T/2 + delay) T/(2 m) to first order.
  HeldDevice device = make_point_mass();
  device.system.D(0, 1) = 0;
  const double stiffness = 1e-4;
  for (const Rational delay :
       {Rational(0), Rational(1, 2500), Rational(1, 1000), Rational(7, 2000)}) {
    Sampling delayed = sampling;
    delayed.delay = delay;
    const double growth =
        find_loop_pole(device, delayed, make_wall(stiffness, 0), {}).magnitude - 1;
    const double expected = stiffness * (period / 2 + delay.to_double()) * period / (2 * mass);
    EXPECT_NEAR(growth, expected, 1e-3 * expected) << delay.to_string();
  }
}

}  // namespace
}  // namespace gyrator
