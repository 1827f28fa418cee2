#include "gyrator/controllers/virtual_wall.hpp"
#include "gyrator/passivity/aliased_disk.hpp"
#include "gyrator/passivity/virtual_damping.hpp"

#include <gtest/gtest.h>

#include "alias_sums.hpp"

namespace gyrator {
namespace {

using namespace passivity_tests;

constexpr double period = 1e-3;
constexpr double nyquist = pi / period;

// The series beyond 24 direct aliases is closed by Euler–Maclaurin to its f''' term; the next one,
// f^(5) 31/967680, is 1e-12 of the sum at 24 aliases. Quadrature and rounding add as much again.
constexpr double series = 1e-11;

std::vector<double> make_shares() {
  return {1e-5, 1e-3, 0.05, 0.3, 0.5, 0.7, 0.92, 1.0};
}

Complex law_at(const DiscreteStateSpace& law, double omega, const Sampling& sampling) {
  return law.response(std::polar(1.0, omega * sampling.period.to_double()));
}

TEST(DiskClosedForms, radius_and_center_of_a_constant_damping_are_the_cosecant_series) {
  // sum_n (w + n w_s)^-2 = (T/2)^2/sin^2(wT/2), hence r = T/(4 b sin(wT/2)), c = r at angle
  // of (e^(-jwT) - 1).
  const double b = 0.8;
  AliasedDisk disk(make_point_mass(0.04, b).device, {});
  for (const double share : make_shares()) {
    const double omega = share * nyquist;
    const DiskPoint point = disk.at(omega);
    const double radius = period / (4 * b * std::sin(omega * period / 2));
    const Complex center = radius * Complex(0, -1) * std::polar(1.0, -omega * period / 2);
    EXPECT_NEAR(point.radius, radius, series * radius) << share;
    EXPECT_LE(std::abs(point.center - center), series * radius) << share;
    EXPECT_DOUBLE_EQ(point.damping, b);
  }
}

TEST(DiskClosedForms, margin_of_a_constant_damping_is_it_plus_the_virtual_damping) {
  const double b = 0.8;
  Random random(2);
  for (const Rational& delay : {Rational(0), Rational(1, 1000), Rational(3, 1000)}) {
    const Sampling sampling{Rational(1, 1000), delay};
    AliasedDisk disk(make_point_mass(0.04, b).device, sampling);
    for (const double share : make_shares()) {
      const double omega = share * nyquist;
      const DiskPoint point = disk.at(omega);
      for (int i = 0; i < 20; ++i) {
        const VirtualWall wall{random.log_uniform(1, 1e4), random.uniform(-1, 1) * b};
        const Complex law = law_at(make_wall_law(wall, period), omega, sampling);
        const Complex late = std::polar(1.0, -omega * delay.to_double());
        const double textbook = b + compute_virtual_damping(omega, period, late * law);
        // An error e of c and r, relative to r, changes D by 2 |H| b r e + |H|^2 b r^2 e.
        const double loop = std::abs(law) * point.radius;
        EXPECT_NEAR(point.damping_margin(law), textbook, series * b * (1 + loop) * (1 + loop))
            << share << " K " << wall.stiffness << " B " << wall.damping;
      }
    }
  }
}

TEST(DiskClosedForms,
     margin_of_a_falling_damping_has_the_sign_of_the_alias_weighted_harmonic_mean) {
  // For A = 1 at one place |c| = r, so D = Re Z/b_eff (b_eff + b_v) with
  // b_eff = sum w_n / sum (w_n / Re Z(jw_n)), w_n = 1/w_n^2.
  const std::vector<KnownDevice> devices{make_rc_motor({}, true),
                                         make_high_pass(0.04, 0.1, {0.01, 1.0})};
  Random random(3);
  int positive = 0;
  int negative = 0;
  for (const KnownDevice& known : devices) {
    AliasedDisk disk(known.device, {});
    for (const double share : make_shares()) {
      const double omega = share * nyquist;
      double weights = 0;
      double over_damping = 0;
      for (int n = 40000; n >= -40000; --n) {
        const double at = omega + n * 2 * nyquist;
        weights += 1 / (at * at);
        over_damping += 1 / (at * at * known.at(Complex(0, at)).impedance.real());
      }
      const double sine = std::sin(omega * period / 2);
      const double all_weights = period * period / (4 * sine * sine);
      over_damping += (all_weights - weights) / known.at(Complex(0, 1e12)).impedance.real();
      const double b_eff = all_weights / over_damping;
      const DiskPoint point = disk.at(omega);
      // Beyond 4e4 aliases Re Z is within 1e-6 of its limit, and their weight is 5e-6 of all.
      const double left_out = 1e-10;
      for (int i = 0; i < 50; ++i) {
        const VirtualWall wall{random.log_uniform(10, 1e4) * b_eff, random.uniform(-1, 1) * b_eff};
        const Complex law = law_at(make_wall_law(wall, period), omega, {});
        const double mean = b_eff + compute_virtual_damping(omega, period, law);
        if (std::abs(mean) < left_out * b_eff) continue;
        ++(mean > 0 ? positive : negative);
        EXPECT_EQ(point.damping_margin(law) > 0, mean > 0) << share << ' ' << mean / b_eff;
        EXPECT_NEAR(point.damping_margin(law) * b_eff / point.damping, mean,
                    left_out * (b_eff + std::abs(mean)));
      }
    }
  }
  EXPECT_GT(positive, 100);
  EXPECT_GT(negative, 100);
}

TEST(DiskClosedForms, a_falling_damping_is_judged_below_its_value_at_the_base_frequency) {
  // [8.46] takes Re Z at the base frequency; where it falls, the aliases have less.
  AliasedDisk disk(make_rc_motor({}, true).device, {});
  const double K = 0.3;
  for (const double share : {0.3, 0.6, 1.0}) {
    const double omega = share * nyquist;
    const DiskPoint point = disk.at(omega);
    EXPECT_LT(point.damping_margin(K),
              0.98 * (point.damping + compute_virtual_damping(omega, period, K)))
        << share;
  }
}

TEST(DiskClosedForms, margin_is_the_distance_from_the_critical_point_multiplied_out) {
  // (disk-2) squared, |1 + H c|^2 - |H|^2 r^2, times Re Z.
  for (const KnownDevice& known :
       {make_rc_motor(), make_voltage_driven_motor(0.5),
        make_compliant(0.04, 0.8, {2e4, 0.3, 0.02}, SensorLocation::motor)}) {
    AliasedDisk disk(known.device, {Rational(1, 1000), Rational(1, 3000)});
    for (const double share : {0.05, 0.3, 0.5, 0.7, 0.92, 1.0}) {
      const DiskPoint point = disk.at(share * nyquist);
      for (const Complex law : {Complex(0.5), Complex(30, 10), Complex(-3, 200)}) {
        const double squared =
            std::norm(1.0 + law * point.center) - std::norm(law) * point.radius * point.radius;
        const double size = 1 + std::norm(law) * point.radius * point.radius;
        EXPECT_NEAR(point.damping_margin(law), point.damping * squared,
                    1e-14 * point.damping * size)
            << share;
      }
    }
  }
}

TEST(DiskClosedForms, extra_damping_at_the_port_adds_to_every_alias) {
  RcParameters more;
  more.b += 3e-4;
  AliasedDisk lighter(make_rc_motor().device, {});
  AliasedDisk heavier(make_rc_motor(more).device, {});
  for (const double share : make_shares()) {
    const DiskPoint added = lighter.at(share * nyquist, 3e-4);
    const DiskPoint built = heavier.at(share * nyquist);
    EXPECT_NEAR(added.radius, built.radius, series * built.radius) << share;
    EXPECT_LE(std::abs(added.center - built.center), series * built.radius) << share;
    EXPECT_NEAR(added.damping, built.damping, series * built.damping) << share;
  }
}

}  // namespace
}  // namespace gyrator
