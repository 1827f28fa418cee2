#include "gyrator/passivity/held_limit.hpp"

#include "gyrator/cosim/simulation.hpp"
#include "gyrator/mechanics/stability.hpp"
#include "gyrator/passivity/verdict.hpp"

#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "support/device_list.hpp"

// How stiff the analog loop of a held impedance may be: closed forms, and both sides of the limit.

namespace gyrator {
namespace {

using testing::make_rc_display;

constexpr double pi = std::numbers::pi;
constexpr double J = 2e-5, b = 1e-4;      // make_rc_display()
constexpr double limit_tolerance = 1e-4;  // the grid's lowest frequency stands for zero

Device make_held(Device device, double stiffness, double damping, std::optional<double> hz) {
  std::erase_if(device.drive.damping,
                [](const Damping& d) { return std::holds_alternative<HeldImpedance>(d); });
  device.drive.damping.emplace_back(HeldImpedance{stiffness, damping, hz});
  return device;
}

Device make_ideal() {
  Device device = make_rc_display();
  device.drive = {};
  return device;
}

Device make_slow_current_drive(double hz) {
  Device device = make_rc_display();
  device.drive.damping.clear();
  device.drive.amplifier = CurrentAmplifier{.bandwidth_hz = hz};
  return device;
}

double limit_of(const Device& device, double damping, std::optional<double> hz) {
  const StiffnessLimit limit =
      find_held_stiffness_limit(make_held(device, 1, damping, hz), damping);
  EXPECT_TRUE(limit.feasible);
  return limit.stiffness;
}

TEST(HeldLimit, of_an_ideal_drive_is_none) {
  EXPECT_TRUE(std::isinf(limit_of(make_ideal(), 3e-4, {})));
}

TEST(HeldLimit, of_one_pole_is_all_damping_over_its_time_constant) {
  // Re{b + (k/s + d)/(1 + s tau)} = b + (d - k tau)/(1 + w^2 tau^2): k tau <= b + d, at w = 0.
  for (const double d : {0.0, 3e-4, 2e-3}) {
    for (const double hz : {200.0, 3e3}) {
      const double tau = 1 / (2 * pi * hz);
      EXPECT_NEAR(limit_of(make_ideal(), d, hz) / ((b + d) / tau), 1, limit_tolerance);
      EXPECT_NEAR(limit_of(make_slow_current_drive(hz), d, {}) / ((b + d) / tau), 1,
                  limit_tolerance)
          << "the amplifier's pole does the same";
    }
  }
}

TEST(HeldLimit, of_two_poles_binds_where_the_analog_damping_has_turned_round) {
  // With x = w^2, sum and product of the time constants: b (1 - x p)^2 + b x sigma^2 + d (1 - x p)
  // - k sigma >= 0, lowest at x = (d p - b (sigma^2 - 2 p))/(2 b p^2), or at zero.
  constexpr double amplifier_hz = 400, own_hz = 900;
  const double sigma = (1 / amplifier_hz + 1 / own_hz) / (2 * pi);
  const double p = 1 / (amplifier_hz * own_hz * 4 * pi * pi);
  const Device device = make_slow_current_drive(amplifier_hz);
  for (const double d : {0.0, 2e-4, 5e-4}) {
    const double slope = b * (sigma * sigma - 2 * p) - d * p;
    const double dip = slope < 0 ? slope * slope / (4 * b * p * p) : 0;
    const StiffnessLimit limit = find_held_stiffness_limit(make_held(device, 1, d, own_hz), d);
    EXPECT_NEAR(limit.stiffness / ((b + d - dip) / sigma), 1, limit_tolerance) << d;
    if (dip > 0) {
      const double x = -slope / (2 * b * p * p);
      EXPECT_NEAR(limit.worst_frequency_hz / (std::sqrt(x) / (2 * pi)), 1, 1e-3);
    }
  }
}

TEST(HeldLimit, is_not_feasible_where_the_analog_damping_alone_makes_the_device_active) {
  // Beyond p w^2 = 1 two lags turn d round: no stiffness is passive if b does not cover it.
  const Device device = make_held(make_slow_current_drive(400), 1, 5e-2, 900);
  const StiffnessLimit limit = find_held_stiffness_limit(device, 5e-2);
  EXPECT_FALSE(limit.feasible);
  EXPECT_EQ(limit.stiffness, 0);
}

struct NamedLoop {
  std::string name;
  Device device;
  double damping;
  std::optional<double> hz;
};

std::vector<NamedLoop> make_loops() {
  Device compliant = make_slow_current_drive(400);
  compliant.mechanics.transmission =
      Transmission{.stiffness = 20, .damping = 1e-3, .load_inertia = 1e-5};
  Device noncollocated = compliant;
  noncollocated.sensor = SensorLocation::motor;
  Device voltage = make_slow_current_drive(400);
  voltage.drive.amplifier = VoltageAmplifier{.bandwidth_hz = 2e3, .output_resistance = 0.5};
  return {{"one pole", make_ideal(), 3e-4, 900},
          {"two poles", make_slow_current_drive(400), 3e-4, 900},
          {"rc branch", make_rc_display(), 3e-4, {}},
          {"voltage", voltage, 3e-4, 900},
          {"compliant", compliant, 1e-4, 900},
          {"compliant, sensor at the motor", noncollocated, 1e-4, 900}};
}

// Where a lossless operator can make most of a negative Re Z: the growth of its oscillation is
// -Re Z/(2 M) with the inertia M = |Im Z|/w that it needs.
PortResponse find_most_active(const Device& device) {
  std::vector<double> hz;
  for (double f = 1e-3; f < 1e5; f *= 1.01) hz.push_back(f);
  const auto responses = compute_port_response(device, hz);
  return *std::min_element(responses.begin(), responses.end(), [](const auto& l, const auto& r) {
    const auto growth = [](const PortResponse& p) {
      return p.impedance.real() / std::abs(p.impedance.imag()) * p.omega;
    };
    return growth(l) < growth(r);
  });
}

MassSpringDamper cancel_reactance(const PortResponse& r) {
  const double reactance = -r.impedance.imag();
  MassSpringDamper held_by;
  (reactance > 0 ? held_by.inertia : held_by.stiffness) =
      reactance > 0 ? reactance / r.omega : -reactance * r.omega;
  return held_by;
}

TEST(HeldLimit, has_a_passive_device_below_and_a_lossless_hand_that_breaks_it_above) {
  for (const NamedLoop& loop : make_loops()) {
    const double limit = limit_of(loop.device, loop.damping, loop.hz);
    ASSERT_GT(limit, 0) << loop.name;
    ASSERT_TRUE(std::isfinite(limit)) << loop.name;
    const Device below = make_held(loop.device, 0.99 * limit, loop.damping, loop.hz);
    const Device above = make_held(loop.device, 1.01 * limit, loop.damping, loop.hz);
    EXPECT_GT(find_most_active(below).impedance.real(), 0) << loop.name;
    const PortResponse active = find_most_active(above);
    ASSERT_LT(active.impedance.real(), 0) << loop.name;

    // Its reactance cancelled by an inertia or a spring, Re Z is all that is left: negative.
    const MassSpringDamper held_by = cancel_reactance(active);
    const auto pole = find_unstable_pole(build_device_network(above, held_by));
    ASSERT_TRUE(pole.has_value()) << loop.name;
    EXPECT_NEAR(pole->imag / active.omega, 1, 0.2) << loop.name;
    EXPECT_FALSE(find_unstable_pole(build_device_network(below, held_by))) << loop.name;

    // And so does the run, as long as the growth needs it to.
    const auto run = [&](const Device& device) {
      SimulationOptions options;
      // Nothing is sampled: twenty points a cycle show the growth.
      const double cycle = 2 * pi / active.omega;
      const Rational period(std::max<std::int64_t>(std::llround(cycle / 20 * 1e6), 1), 1'000'000);
      const double cycles = std::max(12.0 / pole->real / cycle, 100.0);
      EXPECT_LT(cycles, 1e5) << loop.name;
      options.duration = period * Rational(std::llround(20 * cycles));
      options.initial_velocity = 1;
      options.engine_options.ledger = false;
      return simulate(build_plant(build_device_network(device, held_by)), {}, NoController{},
                      {period, 0}, options)
          .classification.outcome;
    };
    EXPECT_EQ(run(above), Outcome::diverges) << loop.name;
    EXPECT_NE(run(below), Outcome::diverges) << loop.name;
  }
}

TEST(HeldLimit, is_where_the_verdict_turns) {
  for (const NamedLoop& loop : make_loops()) {
    const double limit = limit_of(loop.device, loop.damping, loop.hz);
    for (const double share : {0.99, 1.01}) {
      const Verdict verdict =
          judge_passivity({make_held(loop.device, share * limit, loop.damping, loop.hz),
                           NoController{},
                           {Rational(1, 1000), 0},
                           0},
                          false);
      EXPECT_EQ(verdict.passive, share < 1) << loop.name << " at " << share;
      for (const CriterionResult& criterion : verdict.criteria) {
        if (criterion.name != "exact_disk") continue;
        EXPECT_NEAR(criterion.max_stiffness.value_or(0) / limit, 1, 1e-9) << loop.name;
      }
    }
  }
}

TEST(HeldLimit, is_the_stiffer_wall_than_the_sampled_one) {
  // What the loop is for: 1 ms of hold costs (b + d)/(T/2), its own 50 us of lag twenty times less.
  const double held = limit_of(make_ideal(), 0, 1 / (2 * pi * 50e-6));
  StiffnessLimits sampled(make_ideal(), {Rational(1, 1000), 0}, DifferenceEstimator{},
                          FreeOperator{});
  EXPECT_NEAR(held / sampled.find(Criterion::exact_disk, 0).stiffness, 10, 0.01);
}

}  // namespace
}  // namespace gyrator
