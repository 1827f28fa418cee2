#include "gyrator/passivity/displayed_impedance.hpp"

#include "gyrator/cosim/simulation.hpp"

#include <cmath>
#include <complex>
#include <numbers>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "support/device_list.hpp"

// The impedance that a sampled wall displays: the law (displayed-1) against a run in which a
// flywheel of a million times the device's inertia swings the port, and no port can tell it from a
// motion that is imposed.

namespace gyrator {
namespace {

using Complex = std::complex<double>;
using std::numbers::pi;

constexpr double hertz = 40;  // a whole number of periods and of samples in the window
const Rational T(1, 1000);
const Rational settled(6, 10);  // dozens of the slowest time constant
const Rational window(1, 10);

struct Case {
  std::string name;
  Device device;
  Rational delay;
  VirtualWall wall;
};

std::vector<Case> make_cases() {
  const Device rc = testing::make_rc_display();
  Device compliant = rc;
  compliant.drive = {};
  compliant.mechanics.damping = 2e-3;  // settles with 55/s
  compliant.mechanics.transmission =
      Transmission{.stiffness = 0.8, .damping = 1e-4, .load_inertia = 1e-5};
  compliant.sensor = SensorLocation::motor;
  const VirtualWall wall{.stiffness = 0.4, .damping = 1.5e-4};
  VirtualWall filtered = wall;
  filtered.velocity = FilteredDifferenceEstimator{60};
  return {{"RC branch", rc, 0, wall},
          {"RC branch, late, filtered velocity", rc, Rational(14, 10000), filtered},
          {"sensor at the motor", compliant, 0, wall},
          {"sensor at the motor, late", compliant, Rational(4, 10000), wall}};
}

// Fundamental of a trace over the window by trapezoids; at a jump there are two rows of one time.
Complex find_fundamental(const Trace& trace, const std::string& name) {
  const auto& time = trace.column("time_s");
  const auto& value = trace.column(name);
  Complex sum = 0;
  for (std::size_t i = 1; i < time.size(); ++i) {
    if (time[i - 1] < settled.to_double() - 1e-9) continue;
    const auto at = [&](std::size_t k) {
      return value[k] * std::polar(1.0, -2 * pi * hertz * time[k]);
    };
    sum += (at(i) + at(i - 1)) * (time[i] - time[i - 1]) / 2.0;
  }
  return sum;
}

TEST(DisplayedImpedance, is_the_fundamental_of_the_effort_while_the_port_is_swung) {
  for (const Case& c : make_cases()) {
    const double heavy = 1e6 * c.device.mechanics.inertia;
    const MassSpringDamper flywheel{.inertia = heavy,
                                    .damping = 0,
                                    .stiffness = heavy * std::pow(2 * pi * hertz, 2),
                                    .resonators = {}};
    SimulationOptions options;
    options.duration = settled + window;
    options.initial_velocity = 1;
    options.trace_step = Rational(1, 200000);
    const TimeRun run = simulate(build_plant(build_device_network(c.device, flywheel)), {}, c.wall,
                                 {T, c.delay}, options);
    const Complex measured =
        find_fundamental(run.trace, "effort") / find_fundamental(run.trace, "velocity");

    DisplayedImpedance displayed(c.device, {T, c.delay});
    const DiscreteStateSpace law = make_wall_law(c.wall, T.to_double());
    const DisplayedLoop loop = displayed.at(2 * pi * hertz);
    const Complex H = law.response(std::polar(1.0, 2 * pi * hertz * T.to_double()));
    const Complex expected = loop.displayed(H);
    // Trapezoids of 5 us over the fastest transient, 77 us: (5/77)^2/12. The flywheel gives way by
    // a millionth, and over the window by its turns.
    constexpr double tolerance = 4e-4;
    EXPECT_LT(std::abs(measured - expected), tolerance * std::abs(expected)) << c.name;
    // It is the wall that is measured, and the held loop counts where there is one.
    EXPECT_GT(std::abs(expected - loop.bare), 100 * tolerance * std::abs(expected)) << c.name;
    if (c.device.sensor == SensorLocation::motor) {
      const Complex without = loop.bare + loop.path * H;
      EXPECT_GT(std::abs(expected - without), 10 * tolerance * std::abs(expected)) << c.name;
    }
  }
}

}  // namespace
}  // namespace gyrator
