#include "gyrator/passivity/aliased_disk.hpp"

#include <gtest/gtest.h>

#include "alias_sums.hpp"

namespace gyrator {
namespace {

using namespace passivity_tests;

const Sampling no_delay{Rational(1, 1000), Rational(0)};
const Sampling two_periods{Rational(1, 1000), Rational(2, 1000)};
const Sampling part_of_a_period{Rational(1, 1000), Rational(37, 100000)};

struct Summed {
  std::string name;
  KnownDevice known;
  FarTerms far;  // limit of the terms at high frequency
};

// Nyquist is at 500 Hz; resonances of the compliant devices lie at 195 Hz, 1.95 kHz and 20 kHz.
std::vector<Summed> make_summed() {
  const double b = RcParameters{}.b;
  const auto compliant = [](double stiffness, double damping, SensorLocation sensor) {
    return make_compliant(0.04, 0.8, {stiffness, damping, 0.02}, sensor);
  };
  return {{"point mass", make_p3(), {1 / 1.6, 1 / 1.6}},
          {"rc motor, current", make_rc_motor(), {}},
          {"rc motor, ideal drive", make_rc_motor({}, true), {1 / (2 * b), 1 / (2 * b)}},
          {"rc motor, slow amplifier", make_slow_rc_motor(300), {}},
          {"voltage drive", make_voltage_driven_motor(0.5), {}},
          // The wave's source is in it: M tends to the volts per command.
          {"wave drive", make_wave_motor(), {WaveParameters{}.volts_per_command(), 0}},
          {"high-pass damper", make_high_pass(0.04, 0.8, {0.01, 2}), {1 / 5.6, 1 / 5.6}},
          {"compliant, sensor at port", compliant(2e4, 0.3, SensorLocation::port), {}},
          {"compliant, sensor at motor", compliant(2e4, 0.3, SensorLocation::motor), {}},
          {"resonance at 4 Nyquist", compliant(2e6, 1.0, SensorLocation::motor), {}},
          {"resonance at 40 Nyquist", compliant(2e8, 3.0, SensorLocation::port), {}}};
}

std::string describe(const Summed& summed, double omega) {
  return summed.name + " at " + std::to_string(omega / (pi * 1000)) + " of Nyquist";
}

std::vector<double> make_base_frequencies() {
  const double nyquist = pi * 1000;
  std::vector<double> omega;
  for (const double share : {1e-6, 1e-3, 0.03, 0.2, 0.39, 0.5, 0.77, 0.95, 1.0}) {
    omega.push_back(share * nyquist);
  }
  return omega;
}

// 6e4 aliases on either side, to 4e8 rad/s; what lies beyond weighs 3e-6 of the sum at Nyquist and
// less below. There a term that tends to a constant is within (w_c/w)^2 = 3e-7 of it (w_c <= 2e5
// rad/s the fastest corner), and one that falls as w_c/w is 5e-4 of its size at w_c: 1e-12 and 1e-9
// at most.
constexpr int plain_terms = 60000;
constexpr double agreement = 1e-9;

TEST(AliasedDisk,
     is_the_sum_of_a_hundred_thousand_plain_terms_without_a_delay_and_with_a_whole_one) {
  for (const Summed& summed : make_summed()) {
    AliasedDisk prompt(summed.known.device, no_delay);
    AliasedDisk late(summed.known.device, two_periods);
    for (const double omega : make_base_frequencies()) {
      const PlainDisk plain = sum_plainly(summed.known, no_delay, omega, plain_terms, summed.far);
      const std::string where = describe(summed, omega);
      const DiskPoint at_once = prompt.at(omega);
      EXPECT_LE(std::abs(at_once.center - plain.center), agreement * plain.radius) << where;
      EXPECT_NEAR(at_once.radius, plain.radius, agreement * plain.radius) << where;
      // A whole delay turns every alias by the same angle.
      const DiskPoint later = late.at(omega);
      const Complex turned = plain.center * std::polar(1.0, -omega * 2e-3);
      EXPECT_LE(std::abs(later.center - turned), agreement * plain.radius) << where;
      EXPECT_NEAR(later.radius, plain.radius, agreement * plain.radius) << where;
    }
  }
}

TEST(AliasedDisk, encloses_the_plain_sum_for_a_fractional_delay_without_much_room_to_spare) {
  // Between 200 and infinity the centre's terms turn with the delay; the disk is larger by their
  // sizes instead: at Nyquist 2/(200 pi^2) = 0.1 % of the radius for a constant damping, and more
  // where the damping falls with frequency, to 0.4 % for the RC motor with an ideal drive.
  for (const Summed& summed : make_summed()) {
    AliasedDisk disk(summed.known.device, part_of_a_period);
    for (const double omega : make_base_frequencies()) {
      const PlainDisk plain = sum_plainly(summed.known, part_of_a_period, omega, 20000);
      const double left_out =
          plain.left_out * std::max(summed.far.size, std::abs(summed.far.reach));
      const DiskPoint point = disk.at(omega);
      const std::string where = describe(summed, omega);
      const double off = std::abs(point.center - plain.center);
      EXPECT_LE(off + plain.radius, point.radius * (1 + agreement) + left_out) << where;
      EXPECT_LE(point.radius, plain.radius * 1.005) << where;
    }
  }
}

}  // namespace
}  // namespace gyrator
