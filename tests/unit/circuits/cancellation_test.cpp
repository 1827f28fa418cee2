#include <cmath>
#include <optional>
#include <string>

#include <gtest/gtest.h>

#include "support/device_list.hpp"
#include "support/port_forms.hpp"

// Resistance cancellation: closed forms of the port, derived from the loop equation
//   V_s + R_c F_c i = (R_m + R_o + L_m s) i + K_t v,   V_s = g F_a u behind R_o,   torque K_t i.

namespace gyrator {
namespace {

using testing::Complex;
using testing::expect_port;
using testing::lag;
using testing::make_rc_display;
using testing::PortForm;

constexpr double K_t = 0.05, R_m = 1.5, L_m = 0.5e-3, J = 2e-5, b = 1e-4;  // make_rc_display()
constexpr double R_1 = 5, C = 2200e-6;

Device make_device(const Amplifier& amplifier, std::vector<Damping> damping) {
  Device device = make_rc_display();
  device.drive.amplifier = amplifier;
  device.drive.damping = std::move(damping);
  return device;
}

Complex lag_if(Complex s, std::optional<double> hz) {
  return hz ? lag(s, *hz) : 1.0;
}

TEST(ResistanceCancellation, under_a_voltage_amplifier_leaves_what_it_does_not_cancel) {
  for (const double R_o : {0.0, 0.7}) {
    for (const double R_c : {0.5, 1.2, 1.35}) {
      for (const std::optional<double> own_hz : {std::optional<double>{}, {300}, {20e3}}) {
        for (const std::optional<double> amplifier_hz : {std::optional<double>{}, {800}}) {
          const Device device = make_device(VoltageAmplifier{amplifier_hz, R_o},
                                            {ResistanceCancellation{R_c, own_hz}});
          expect_port(
              device,
              [&](Complex s) {
                const Complex loop = R_m + R_o + L_m * s - R_c * lag_if(s, own_hz);
                const double at_dc = R_m + R_o - R_c;
                return PortForm{J * s + b + K_t * K_t / loop,
                                at_dc / loop * lag_if(s, amplifier_hz)};
              },
              std::to_string(R_c) + " ohm behind " + std::to_string(R_o));
        }
      }
    }
  }
}

TEST(ResistanceCancellation, beside_an_rc_branch_under_a_current_amplifier_acts_on_their_loop) {
  // The branch takes I - i of the total I: Z_b (I - i) + R_c F_c i = (R_m + L_m s) i + K_t v.
  for (const double R_c : {1.2, 4.0}) {  // more than R_m is stable here: R_1 is in the loop
    for (const std::optional<double> own_hz : {std::optional<double>{}, {2e3}}) {
      for (const std::optional<double> amplifier_hz : {std::optional<double>{}, {250}}) {
        expect_port(make_device(CurrentAmplifier{amplifier_hz},
                                {RcDamping{R_1, C}, ResistanceCancellation{R_c, own_hz}}),
                    [&](Complex s) {
                      const Complex branch = R_1 + 1.0 / (C * s);
                      const Complex loop = R_m + L_m * s + branch - R_c * lag_if(s, own_hz);
                      return PortForm{J * s + b + K_t * K_t / loop,
                                      branch / loop * lag_if(s, amplifier_hz)};
                    });
      }
    }
  }
}

TEST(ResistanceCancellation, is_the_same_wherever_it_stands_in_the_list) {
  const ResistanceCancellation cancellation{1.2, 2e3};
  const RcDamping branch{R_1, C};
  const auto first = compute_port_response(make_device(CurrentAmplifier{}, {cancellation, branch}),
                                           testing::sweep_frequencies());
  const auto last = compute_port_response(make_device(CurrentAmplifier{}, {branch, cancellation}),
                                          testing::sweep_frequencies());
  for (std::size_t i = 0; i < first.size(); ++i) {
    EXPECT_LE(std::abs(first[i].impedance - last[i].impedance),
              1e-12 * std::abs(first[i].impedance));
    EXPECT_LE(std::abs(first[i].actuation - last[i].actuation),
              1e-12 * std::abs(first[i].actuation));
  }
}

TEST(ResistanceCancellation, with_a_pole_looks_like_an_inductance_on_top_of_the_windings) {
  // R_c/(1 + s/w_b) = R_c - (R_c/w_b) s + ...: read off Im 1/Z_e = w (L_m + R_c/w_b)/K_t^2.
  constexpr double R_c = 1.35, hz = 5e3, at_hz = 1;
  const Device device = make_device(VoltageAmplifier{}, {ResistanceCancellation{R_c, hz}});
  const PortResponse r = compute_port_response(device, {at_hz}).front();
  const Complex loop = K_t * K_t / (r.impedance - Complex(b, J * r.omega));
  const double inductance = loop.imag() / r.omega;
  // (1 Hz/5 kHz)^2 is 4e-8; the drive's part of Z is ten times the inertia's.
  EXPECT_NEAR(inductance / (L_m + R_c / (2 * std::numbers::pi * hz)), 1, 1e-7);
}

TEST(ResistanceCancellation, of_a_warm_winding_leaves_more_and_keeps_the_amplifiers_scale) {
  constexpr double R_c = 1.2, rise = 40, alpha = copper_temperature_coefficient;
  for (const double R_o : {0.0, 0.7}) {
    Device device = make_device(VoltageAmplifier{{}, R_o}, {ResistanceCancellation{R_c, {}}});
    device.drive.motor->temperature_rise = rise;
    expect_port(device, [&](Complex s) {
      const Complex loop = R_m * (1 + alpha * rise) + R_o - R_c + L_m * s;
      return PortForm{J * s + b + K_t * K_t / loop, (R_m + R_o - R_c) / loop};
    });
  }
}

TEST(Resistor, across_a_warm_winding_divides_the_current_differently_at_the_same_scale) {
  constexpr double R = 10, rise = 60, alpha = copper_temperature_coefficient;
  Device device = make_device(CurrentAmplifier{}, {ResistorDamping{R}});
  device.drive.motor->temperature_rise = rise;
  expect_port(device, [&](Complex s) {
    const Complex loop = R_m * (1 + alpha * rise) + L_m * s + R;
    return PortForm{J * s + b + K_t * K_t / loop, (R_m + R) / loop};
  });
}

TEST(Resistor, and_branches_hang_before_the_cancellation_not_behind_it) {
  // Behind R_o the branches see the amplifier's terminals, the cancellation the motor's current.
  constexpr double R_o = 3, R = 10, R_c = 1.0;
  expect_port(
      make_device(VoltageAmplifier{{}, R_o},
                  {ResistorDamping{R}, RcDamping{R_1, C}, ResistanceCancellation{R_c, {}}}),
      [&](Complex s) {
        const Complex source = 1.0 / (1 / R_o + 1 / R + 1.0 / (R_1 + 1.0 / (C * s)));
        const double at_dc = 1 / (1 / R_o + 1 / R);
        const Complex loop = R_m + L_m * s - R_c + source;
        return PortForm{J * s + b + K_t * K_t / loop, source / at_dc * (R_m - R_c + at_dc) / loop};
      });
}

}  // namespace
}  // namespace gyrator
