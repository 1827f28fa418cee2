#include <cmath>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "support/device_list.hpp"
#include "support/port_forms.hpp"

// Dampers at the port and loops around the sensor, on devices whose own port is known:
//   f_h = Z_0 v_p - A_0 c,   v_s = S v_p + M c,   c what the feedback makes of the command u.

namespace gyrator {
namespace {

using testing::Complex;
using testing::expect_port;
using testing::lag;
using testing::make_rc_display;
using testing::PortForm;

constexpr double K_t = 0.05, R_m = 1.5, L_m = 0.5e-3, J = 2e-5, b = 1e-4;  // make_rc_display()
constexpr double R_1 = 5, C = 2200e-6;
constexpr double k_t = 20, c_t = 1e-3, J_l = 1e-5;  // transmission

struct Known {
  std::string name;
  Device device;
  std::function<PortForm(Complex)> form;
};

// Behind a compliant transmission Z_t, motor side Z_m: Z = J_l s + Z_m Z_t/(Z_m + Z_t),
// A = A_m Z_t/(Z_m + Z_t), and a sensor at the motor sees S = Z_t/(Z_m + Z_t), M = A_m/(Z_m + Z_t).
Known behind_transmission(const Known& rigid, SensorLocation sensor) {
  Known known = rigid;
  const bool at_motor = sensor == SensorLocation::motor;
  known.name += at_motor ? ", compliant, sensor at the motor" : ", compliant, sensor at the port";
  known.device.mechanics.transmission =
      Transmission{.stiffness = k_t, .damping = c_t, .load_inertia = J_l};
  known.device.sensor = sensor;
  known.form = [form = rigid.form, at_motor](Complex s) {
    const PortForm motor = form(s);
    const Complex Z_t = c_t + k_t / s;
    const Complex both = motor.impedance + Z_t;
    PortForm port{J_l * s + motor.impedance * Z_t / both, motor.actuation * Z_t / both};
    if (at_motor) {
      port.sensor_path = Z_t / both;
      port.blocked_motion = motor.actuation / both;
    }
    return port;
  };
  return known;
}

std::vector<Known> make_known() {
  Device ideal = make_rc_display();
  ideal.drive = {};
  Device bandwidth = make_rc_display();
  bandwidth.drive.amplifier = CurrentAmplifier{.bandwidth_hz = 250};
  bandwidth.drive.damping.clear();
  Device voltage = bandwidth;
  voltage.drive.amplifier = VoltageAmplifier{};
  std::vector<Known> known{
      {"ideal", ideal,
       [](Complex s) {
         return PortForm{J * s + b, 1};
       }},
      {"250 Hz", bandwidth,
       [](Complex s) {
         return PortForm{J * s + b, lag(s, 250)};
       }},
      {"voltage", voltage,
       [](Complex s) {
         const Complex winding = R_m + L_m * s;
         return PortForm{J * s + b + K_t * K_t / winding, R_m / winding};
       }},
      {"rc", make_rc_display(),
       [](Complex s) {
         const Complex branch = R_1 + 1.0 / (C * s);
         const Complex loop = R_m + L_m * s + branch;
         return PortForm{J * s + b + K_t * K_t / loop, branch / loop};
       }},
  };
  const std::size_t rigid = known.size();
  for (std::size_t i = 0; i < rigid; ++i) {
    known.push_back(behind_transmission(known[i], SensorLocation::port));
    known.push_back(behind_transmission(known[i], SensorLocation::motor));
  }
  return known;
}

Device with(Device device, const Damping& damping) {
  device.drive.damping.push_back(damping);
  return device;
}

TEST(HeldImpedance, is_spring_and_damper_through_the_drive_seen_at_the_port) {
  // c = u - G v_s, G = F (k/s + d): Z = Z_0 + A S G/(1 + G M), A, S and M over 1 + G M.
  constexpr double k = 0.4, d = 3e-4;
  for (const Known& known : make_known()) {
    for (const std::optional<double> hz : {std::optional<double>{}, {900}}) {
      expect_port(
          with(known.device, HeldImpedance{k, d, hz}),
          [&](Complex s) {
            const PortForm p = known.form(s);
            const Complex G = (k / s + d) * (hz ? lag(s, *hz) : 1.0);
            const Complex loop = 1.0 + G * p.blocked_motion;
            return PortForm{p.impedance + p.actuation * p.sensor_path * G / loop,
                            p.actuation / loop, p.sensor_path / loop, p.blocked_motion / loop};
          },
          known.name);
    }
  }
}

TEST(HeldImpedance, without_stiffness_is_a_damper) {
  Device device = make_rc_display();
  device.drive = {};
  expect_port(with(device, HeldImpedance{0, 3e-4, {}}), [](Complex s) {
    return PortForm{J * s + b + 3e-4, 1};
  });
}

TEST(TorqueSensedDamper, is_felt_where_its_cancellation_no_longer_follows) {
  // Z gains d, and its effort F d v comes back through the drive: d (1 - A F); S, M alike.
  constexpr double d = 2e-3, hz = 30;
  for (const Known& known : make_known()) {
    expect_port(
        with(known.device, TorqueSensedDamper{d, hz}),
        [&](Complex s) {
          PortForm p = known.form(s);
          const Complex back = d * lag(s, hz);
          p.impedance += d - p.actuation * back;
          p.sensor_path += p.blocked_motion * back;
          return p;
        },
        known.name);
  }
}

TEST(TorqueSensedDamper, rises_from_nothing_to_d_across_its_cutoff_under_an_ideal_drive) {
  // Re d (1 - 1/(1 + jx)) = d x^2/(1 + x^2).
  Device device = make_rc_display();
  device.drive = {};
  constexpr double d = 2e-3, hz = 30;
  for (const double x : {0.01, 1.0, 100.0}) {
    const PortResponse r =
        compute_port_response(with(device, TorqueSensedDamper{d, hz}), {x * hz}).front();
    EXPECT_NEAR((r.impedance.real() - b) / d, x * x / (1 + x * x), 1e-10) << x;
  }
}

TEST(EddyCurrentBrake, is_a_damper_at_the_port_while_it_is_on) {
  constexpr double d = 2e-3;
  for (const Known& known : make_known()) {
    expect_port(
        with(known.device, EddyCurrentBrake{d, true}),
        [&](Complex s) {
          PortForm p = known.form(s);
          p.impedance += d;
          return p;
        },
        known.name);
    expect_port(with(known.device, EddyCurrentBrake{d, false}), known.form, known.name + ", off");
  }
}

TEST(HighPassDamper, is_a_damper_in_series_with_its_inertia_at_the_port) {
  constexpr double m_2 = 3e-5, d = 2e-3;
  for (const Known& known : make_known()) {
    expect_port(
        with(known.device, HighPassDamper{.inertia = m_2, .damping = d}),
        [&](Complex s) {
          PortForm p = known.form(s);
          p.impedance += d * m_2 * s / (d + m_2 * s);
          return p;
        },
        known.name);
  }
}

TEST(Feedbacks, add_up_whatever_their_order) {
  // c = u - G v_p + F d v_p.
  constexpr double k = 0.4, d_held = 3e-4, d = 2e-3, hz = 30;
  const HeldImpedance held{k, d_held, 900};
  const TorqueSensedDamper sensed{d, hz};
  for (const Known& known : make_known()) {
    if (known.device.sensor == SensorLocation::motor) continue;
    const auto form = [&](Complex s) {
      PortForm p = known.form(s);
      p.impedance += d + p.actuation * ((k / s + d_held) * lag(s, 900) - d * lag(s, hz));
      return p;
    };
    expect_port(with(with(known.device, held), sensed), form, known.name + ", held first");
    expect_port(with(with(known.device, sensed), held), form, known.name + ", held last");
  }
}

}  // namespace
}  // namespace gyrator
