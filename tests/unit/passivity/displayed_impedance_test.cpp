#include "gyrator/passivity/displayed_impedance.hpp"

#include "gyrator/controllers/virtual_wall.hpp"
#include "gyrator/passivity/aliased_disk.hpp"
#include "gyrator/passivity/stiffness_limit.hpp"

#include <random>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "support/passivity_closed_forms.hpp"

namespace gyrator {
namespace {

using namespace passivity_tests;

const Rational T(1, 1000);

KnownDevice make_sensed_at_the_motor() {
  return make_compliant(2e-5, 2e-4, {0.8, 1e-4, 1e-5}, SensorLocation::motor);
}

TEST(DisplayedImpedance, of_a_wall_seen_at_the_port_is_its_held_effort_behind_the_drive) {
  for (const Rational& delay : {Rational(0), Rational(7, 10000), Rational(3, 1000)}) {
    const KnownDevice known = make_rc_motor();
    DisplayedImpedance displayed(known.device, {T, delay});
    for (const double hertz : {0.1, 3.0, 40.0, 250.0, 499.0}) {
      const double period = T.to_double();
      const Complex s(0, 2 * pi * hertz);
      const Complex z = std::exp(s * period);
      const Complex law = 0.05 + 1e-4 * (1.0 - 1.0 / z) / period;
      const PortForm port = known.at(s);
      // The position v/s is sampled, the command held: (1 - 1/z)/(s T) of it is the fundamental.
      const Complex hold = (1.0 - 1.0 / z) / (s * period) * std::exp(-s * delay.to_double());
      const Complex expected = port.impedance + port.actuation * hold * law / s;
      const DisplayedLoop loop = displayed.at(s.imag());
      // 1 - 1/z loses four digits at 0.1 Hz.
      EXPECT_LT(std::abs(loop.displayed(law) - expected), 1e-10 * std::abs(expected)) << hertz;
      EXPECT_EQ(loop.blocked, 0.0);
      EXPECT_LT(std::abs(loop.displayed(0) - port.impedance), 1e-10 * std::abs(port.impedance));
    }
  }
}

TEST(DisplayedImpedance, loop_of_the_held_port_is_the_sum_over_all_aliases) {
  // The disk's centre with endless damping at the port is sum k_n M_n, from the network's frequency
  // response; here it comes from the exact step of the held plant.
  constexpr double held = 1e12;
  for (const Rational& delay :
       {Rational(0), Rational(1, 1000), Rational(4, 10000), Rational(27, 10000)}) {
    const KnownDevice known = make_sensed_at_the_motor();
    DisplayedImpedance displayed(known.device, {T, delay});
    AliasedDisk disk(known.device, {T, delay});
    for (const double hertz : {1.0, 20.0, 130.0, 333.0, 490.0}) {
      const DiskPoint sum = disk.at(2 * pi * hertz, held);
      const Complex exact = displayed.at(2 * pi * hertz).blocked;
      // The radius is what the disk's cut tail may hold; whole delays have none.
      EXPECT_LT(std::abs(sum.center - exact), sum.radius + 1e-8 * std::abs(exact))
          << hertz << " Hz, delay " << delay.to_double();
      EXPECT_LT(sum.radius, 1e-3 * std::abs(exact));
      EXPECT_GT(std::abs(exact), 0);
    }
  }
}

TEST(DisplayedImpedance, of_every_passive_wall_has_a_positive_real_part) {
  std::mt19937 random(1);
  std::uniform_real_distribution<double> share(0, 1);
  for (const auto& known : {make_rc_motor(), make_p3(), make_sensed_at_the_motor()}) {
    for (const Rational& delay : {Rational(0), Rational(1, 1000)}) {
      const Sampling sampling{T, delay};
      StiffnessLimits limits(known.device, sampling, DifferenceEstimator{}, FreeOperator{});
      DisplayedImpedance displayed(known.device, sampling);
      const double b = limits.disk().model().at(1).impedance.real();
      int walls = 0;
      for (int i = 0; i < 8; ++i) {
        const double damping = b * (4 * share(random) - 1);
        const StiffnessLimit limit = limits.find(Criterion::exact_disk, damping);
        if (!limit.feasible) continue;
        ++walls;
        const double stiffness = share(random) * limit.stiffness;
        const DiscreteStateSpace law = make_wall_law({stiffness, damping}, T.to_double());
        for (const double omega : limits.grid()) {
          const Complex H = law.response(std::polar(1.0, omega * T.to_double()));
          EXPECT_GT(displayed.at(omega).displayed(H).real(), 0) << omega;
        }
      }
      EXPECT_GT(walls, 2);
    }
  }
}

}  // namespace
}  // namespace gyrator
