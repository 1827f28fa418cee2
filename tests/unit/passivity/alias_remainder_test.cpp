#include "gyrator/passivity/alias_remainder.hpp"

#include <array>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "support/passivity_closed_forms.hpp"

namespace gyrator {
namespace {

using namespace passivity_tests;

constexpr double T = 1e-3;
constexpr double w_s = 2 * pi / T;
constexpr int direct = 12;
constexpr int bounded = direct + 300;

struct Named {
  std::string name;
  KnownDevice known;
};

std::vector<Named> list_devices() {
  return {{"point mass", make_p3()},
          {"rc motor", make_rc_motor()},
          {"rc motor, slow amplifier", make_slow_rc_motor(300)},
          {"voltage drive", make_voltage_driven_motor(0.5)},
          {"wave drive", make_wave_motor()},
          {"compliant, sensor at port",
           make_compliant(0.04, 0.8, {2e4, 0.3, 0.02}, SensorLocation::port)},
          {"compliant, sensor at motor",
           make_compliant(0.04, 0.8, {2e4, 0.3, 0.02}, SensorLocation::motor)}};
}

// (remainder-1) of the closed form, without what M tends to being taken out.
struct Sums {
  Complex center;
  double radius = 0;
  double size = 0;  // of the terms of both
};

struct Reach {
  Complex center;
  double radius = 0;
};

Reach reach_at(const KnownDevice& known, double omega) {
  const PortForm form = known.at(Complex(0, omega));
  const Complex swing = form.sensor_path * form.actuation / (2 * form.impedance.real());
  return {form.blocked_motion + swing, std::abs(swing)};
}

// 20,000 aliases on either side one by one. The rest of the radius, and of the centre where the
// delay turns nothing, is an integral from half an alias on over what has long been constant.
Sums sum_directly(const KnownDevice& known, double omega, double delay) {
  constexpr int last = 20000;
  const bool whole = std::abs(delay / T - std::round(delay / T)) < 1e-12;
  const double theta = whole ? 0 : w_s * delay;
  Sums sums;
  for (int k = last; k > direct; --k) {
    for (const int n : {k, -k}) {
      const double at = omega + n * w_s;
      const Reach g = reach_at(known, at);
      sums.center += std::polar(1.0, -n * theta) * g.center / (at * at);
      sums.radius += g.radius / (at * at);
      sums.size += (std::abs(g.center) + g.radius) / (at * at);
    }
  }
  const double from = (last + 0.5) * w_s;
  const Reach far = reach_at(known, from);
  if (whole) sums.center += 2 * far.center.real() / (w_s * from);
  sums.radius += 2 * far.radius / (w_s * from);
  return sums;
}

TEST(AliasRemainder, differs_from_long_direct_sums_by_no_more_than_it_says_is_left_out) {
  for (const Named& named : list_devices()) {
    PortModel model(named.known.device);
    for (const double periods : {0.0, 2.0, 0.37, 0.5, 1.3}) {
      const double delay = periods * T;
      const bool whole = periods == std::round(periods);
      const AliasRemainder remainder(model, T, delay, whole, direct, bounded);
      ASSERT_TRUE(std::isfinite(remainder.left_out())) << named.name;
      EXPECT_GT(remainder.left_out(), 0) << named.name;
      for (const double share : {1e-3, 0.1, 0.37, 0.7, 1.0}) {
        const double omega = share * pi / T;
        const Sums sums = sum_directly(named.known, omega, delay);
        const double center_off = std::abs(remainder.center(omega, 0).value - sums.center);
        const double radius = remainder.radius(omega, 0).value.real();
        EXPECT_LE(center_off, remainder.left_out()) << named.name << ", " << periods << " periods";
        EXPECT_GE(radius, sums.radius) << named.name << ", " << periods << " periods";
        // One reserve has to do for both: the whole disk is held.
        EXPECT_GE(radius, sums.radius + center_off) << named.name << ", " << periods << " periods";
        // A reserve, and no substitute for the sum: a fifth of its terms at most.
        if (whole) {
          EXPECT_LE(remainder.left_out(), 0.2 * sums.size) << named.name;
        }
      }
    }
  }
}

TEST(AliasRemainder, bounds_its_own_course_over_a_reach) {
  const KnownDevice known = make_compliant(0.04, 0.8, {2e4, 0.3, 0.02}, SensorLocation::motor);
  PortModel model(known.device);
  const AliasRemainder remainder(model, T, 0.37 * T, false, direct, bounded);
  const double omega = 0.5 * pi / T;
  const double reach = 0.49 * pi / T;
  const TaylorModel center = remainder.center(omega, reach);
  const TaylorModel radius = remainder.radius(omega, reach);
  for (int i = -50; i <= 50; ++i) {
    const double t = reach * i / 50;
    const auto off = [&](const TaylorModel& model_over, Complex value) {
      return std::abs(value - model_over.value - model_over.slope * t) -
             model_over.curvature * t * t;
    };
    // Rounding of a cubic's few terms.
    const double rounding = 1e-14 * std::abs(center.value) + 1e-14 * std::abs(radius.value);
    EXPECT_LE(off(center, remainder.center(omega + t, 0).value), rounding) << t;
    EXPECT_LE(off(radius, remainder.radius(omega + t, 0).value), rounding) << t;
  }
}

}  // namespace
}  // namespace gyrator
