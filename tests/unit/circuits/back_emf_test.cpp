#include <cmath>
#include <optional>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "support/device_list.hpp"
#include "support/port_forms.hpp"

// Active electrical damping. With e = K_t v the estimate is e + D i, D = (R_m - R) + (L_m - L) s,
// and the amplifier is told c = u - (d/K_t) F (e + D i). Each amplifier then gives the current.

namespace gyrator {
namespace {

using testing::Complex;
using testing::expect_port;
using testing::lag;
using testing::make_rc_display;
using testing::PortForm;

constexpr double K_t = 0.05, R_m = 1.5, L_m = 0.5e-3, J = 2e-5, b = 1e-4;  // make_rc_display()
constexpr double R_1 = 5, C = 2200e-6;
constexpr double alpha = copper_temperature_coefficient;

// What is varied: the filter, the estimates, the winding.
struct Case {
  std::string name;
  BackEmfDamping feedback;
  double rise = 0;

  Complex filter(Complex s) const {
    Complex F = 1;
    if (feedback.low_pass_hz) F *= lag(s, *feedback.low_pass_hz);
    if (feedback.high_pass_hz) F *= 1.0 - lag(s, *feedback.high_pass_hz);
    return F;
  }
  double at_dc() const { return feedback.high_pass_hz ? 0 : 1; }
  double winding() const { return R_m * (1 + alpha * rise); }
  // D now, and as it was when the amplifier's scale was set.
  Complex error(Complex s) const {
    return winding() - feedback.resistance_estimate + (L_m - feedback.inductance_estimate) * s;
  }
  double calibrated_error() const { return R_m - feedback.resistance_estimate; }
  // d/K_t [V.s/(A.rad)...]: volts of estimate to command.
  double gain() const { return feedback.damping / K_t; }

  Device device(const Amplifier& amplifier, std::vector<Damping> more = {}) const {
    Device device = make_rc_display();
    device.drive.amplifier = amplifier;
    device.drive.motor->temperature_rise = rise;
    device.drive.damping = std::move(more);
    device.drive.damping.emplace_back(feedback);
    return device;
  }
};

std::vector<Case> make_cases() {
  std::vector<Case> setups;
  constexpr double d = 6e-4;
  const std::vector<std::pair<std::string, BackEmfDamping>> filters{
      {"unfiltered", {d, R_m, L_m, {}, {}}},
      {"low-pass", {d, R_m, L_m, 150, {}}},
      {"high-pass", {d, R_m, L_m, {}, 4}},
      {"band-pass", {d, R_m, L_m, 150, 4}}};
  for (const auto& [name, exact] : filters) {
    setups.push_back({name, exact, 0});
    Case wrong{name + ", wrong R and L", exact, 0};
    wrong.feedback.resistance_estimate = 1.1;
    wrong.feedback.inductance_estimate = 0.35e-3;
    setups.push_back(wrong);
    Case none{name + ", terminal voltage alone", exact, 0};
    none.feedback.resistance_estimate = 0;
    none.feedback.inductance_estimate = 0;
    setups.push_back(none);
    setups.push_back({name + ", warm winding", exact, 50});
    wrong.name += ", cold winding";
    wrong.rise = -20;
    setups.push_back(wrong);
  }
  return setups;
}

// A current source without a branch, i = g F_a c:  i (1 + g F_a (d/K_t) F D) = g F_a (u - d F v).
// At DC, where the scale was set, K_t g = 1 + g (d/K_t) F(0) D_0.
double current_gain(const Case& setup) {
  return 1 / (K_t - setup.gain() * setup.at_dc() * setup.calibrated_error());
}

void expect_current_source(const CurrentAmplifier& amplifier) {
  for (const Case& setup : make_cases()) {
    const double g = current_gain(setup);
    expect_port(
        setup.device(amplifier),
        [&](Complex s) {
          const Complex G = g * (amplifier.bandwidth_hz ? lag(s, *amplifier.bandwidth_hz) : 1.0);
          const Complex F = setup.filter(s);
          const Complex loop = 1.0 + G * setup.gain() * F * setup.error(s);
          return PortForm{J * s + b + K_t * G * setup.feedback.damping * F / loop, K_t * G / loop};
        },
        setup.name);
  }
}

TEST(BackEmf, under_an_ideal_current_amplifier_is_d_in_the_filters_band) {
  expect_current_source(CurrentAmplifier{});
}

TEST(BackEmf, under_a_current_amplifier_lags_by_the_bandwidth_whichever_current_is_sensed) {
  expect_current_source(CurrentAmplifier{.bandwidth_hz = 600});
  expect_current_source(CurrentAmplifier{.bandwidth_hz = 600, .sense = CurrentSense::motor});
  expect_current_source(CurrentAmplifier{.bandwidth_hz = {}, .sense = CurrentSense::motor});
}

TEST(BackEmf, with_exact_estimates_adds_d_alone) {
  const Case setup{"", {6e-4, R_m, L_m, {}, {}}, 0};
  expect_port(setup.device(CurrentAmplifier{}), [](Complex s) {
    return PortForm{J * s + b + 6e-4, 1};
  });
}

TEST(BackEmf, of_a_warm_winding_takes_its_error_off_damping_and_command_alike) {
  // D = R_m alpha rise: both are divided by 1 + (d/K_t^2) R_m alpha rise.
  for (const double rise : {80.0, -40.0}) {
    const Case setup{"", {6e-4, R_m, L_m, {}, {}}, rise};
    const double divisor = 1 + 6e-4 / (K_t * K_t) * R_m * alpha * rise;
    expect_port(setup.device(CurrentAmplifier{}), [&](Complex s) {
      return PortForm{J * s + b + 6e-4 / divisor, 1 / divisor};
    });
  }
}

TEST(BackEmf, under_a_voltage_amplifier_comes_on_top_of_what_the_source_damps_by_itself) {
  // g F_a c = (R + R_o + L s) i + K_t v; K_t g = R_m + R_o + g (d/K_t) F(0) D_0 at DC.
  for (const double R_o : {0.0, 0.7}) {
    for (const std::optional<double> hz : {std::optional<double>{}, {800}}) {
      for (const Case& setup : make_cases()) {
        const double g =
            (R_m + R_o) / (K_t - setup.gain() * setup.at_dc() * setup.calibrated_error());
        expect_port(
            setup.device(VoltageAmplifier{hz, R_o}),
            [&](Complex s) {
              const Complex G = g * (hz ? lag(s, *hz) : 1.0);
              const Complex F = setup.filter(s);
              const Complex loop =
                  setup.winding() + R_o + L_m * s + G * setup.gain() * F * setup.error(s);
              return PortForm{J * s + b + K_t * (K_t + G * setup.feedback.damping * F) / loop,
                              K_t * G / loop};
            },
            setup.name);
      }
    }
  }
}

TEST(BackEmf, beside_an_rc_branch_both_damp) {
  for (const Case& setup : make_cases()) {
    const double g = current_gain(setup);
    constexpr double hz = 600, w_a = 2 * std::numbers::pi * hz;
    const RcDamping rc{R_1, C};
    // Total sensed: Z_b (G c - i) = (R + L s) i + K_t v.
    expect_port(
        setup.device(CurrentAmplifier{.bandwidth_hz = hz}, {rc}),
        [&](Complex s) {
          const Complex branch = R_1 + 1.0 / (C * s);
          const Complex feedback = branch * g * lag(s, hz) * setup.gain() * setup.filter(s);
          const Complex loop = branch + setup.winding() + L_m * s + feedback * setup.error(s);
          return PortForm{J * s + b + K_t * K_t * (1.0 + feedback) / loop,
                          K_t * branch * g * lag(s, hz) / loop};
        },
        setup.name + ", total sensed");
    // Motor sensed: s I = w_a (g c - i), and the same branch.
    expect_port(
        setup.device(CurrentAmplifier{.bandwidth_hz = hz, .sense = CurrentSense::motor}, {rc}),
        [&](Complex s) {
          const Complex branch = R_1 + 1.0 / (C * s);
          const Complex feedback = w_a * g * branch * setup.gain() * setup.filter(s);
          const Complex loop =
              s * (branch + setup.winding() + L_m * s) + w_a * branch + feedback * setup.error(s);
          return PortForm{J * s + b + K_t * K_t * (s + feedback) / loop,
                          K_t * w_a * g * branch / loop};
        },
        setup.name + ", motor sensed");
  }
}

TEST(BackEmf, is_estimated_behind_a_resistance_cancellation) {
  // The terminal voltage is the winding's own, whatever is in series: e + D i still.
  const Case setup{"", {6e-4, 1.1, L_m, 150, {}}, 0};
  constexpr double R_c = 0.9;
  const double g = (R_m - R_c) / (K_t - setup.gain() * setup.calibrated_error());
  expect_port(setup.device(VoltageAmplifier{}, {ResistanceCancellation{R_c, {}}}), [&](Complex s) {
    const Complex F = setup.filter(s);
    const Complex loop = R_m - R_c + L_m * s + g * setup.gain() * F * setup.error(s);
    return PortForm{J * s + b + K_t * (K_t + g * setup.feedback.damping * F) / loop,
                    K_t * g / loop};
  });
}

}  // namespace
}  // namespace gyrator
