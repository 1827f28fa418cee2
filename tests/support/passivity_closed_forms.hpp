#pragma once

#include "gyrator/mechanics/device.hpp"

#include <cmath>
#include <complex>
#include <cstdint>
#include <functional>
#include <numbers>
#include <random>

namespace gyrator::passivity_tests {

using Complex = std::complex<double>;
using std::numbers::pi;

/// f_h = Z v_p - A u, v_s = S v_p + M u: a device written down by hand, without any network.
struct PortForm {
  Complex impedance, actuation;
  Complex sensor_path = 1, blocked_motion = 0;
};

/// A device with the closed form of its port at s [rad/s].
struct KnownDevice {
  Device device;
  std::function<PortForm(Complex)> at;
};

/// m, b under an ideal drive.
inline KnownDevice make_point_mass(double inertia, double damping) {
  Device device;
  device.motion = Motion::linear;
  device.mechanics.inertia = inertia;
  device.mechanics.damping = damping;
  return {device, [=](Complex s) { return PortForm{inertia * s + damping, 1.0}; }};
}

/// The plant P3 of the reference cases.
inline KnownDevice make_p3() {
  return make_point_mass(0.04, 0.8);
}

struct RcParameters {
  double J = 2e-5, b = 1e-4, K_t = 0.05, R_m = 1.5, L_m = 0.5e-3, R_1 = 5, C = 2200e-6;
};

/// The motor with an RC branch [8.48]: Z = J s + b + K_t^2/Z_w, Z_w = R_m + L_m s + R_1 + 1/(C s).
/// The current source sets the total current, A = (R_1 + 1/(C s))/Z_w; an ideal drive has A = 1.
inline KnownDevice make_rc_motor(const RcParameters& p = {}, bool ideal = false) {
  Device device;
  device.mechanics.inertia = p.J;
  device.mechanics.damping = p.b;
  device.drive.motor = Motor{p.K_t, p.R_m, p.L_m};
  if (!ideal) device.drive.amplifier = CurrentAmplifier{};
  device.drive.damping = {RcDamping{p.R_1, p.C}};
  return {
      device, [=](Complex s) {
        const Complex branch = p.R_1 + 1.0 / (p.C * s);
        const Complex winding = p.R_m + p.L_m * s + branch;
        return PortForm{p.J * s + p.b + p.K_t * p.K_t / winding, ideal ? 1.0 : branch / winding};
      }};
}

/// A voltage amplifier behind R_o: the source closes the back-EMF loop itself.
inline KnownDevice make_voltage_driven_motor(double output_resistance) {
  const RcParameters p;
  const double R = p.R_m + output_resistance;
  Device device;
  device.mechanics.inertia = p.J;
  device.mechanics.damping = p.b;
  device.drive.motor = Motor{p.K_t, p.R_m, p.L_m};
  device.drive.amplifier = VoltageAmplifier{std::nullopt, output_resistance};
  return {device, [=](Complex s) {
            const Complex winding = R + p.L_m * s;
            return PortForm{p.J * s + p.b + p.K_t * p.K_t / winding, R / winding};
          }};
}

/// A wave drive whose outgoing wave W = V - R_w i is sensed, R_c of the winding cancelled at once;
/// L_m in series. With R = R_w + R_m - R_c and R/K_t volts per command,
///   Z = J s + b + K_t^2/(R + L s),   A = R/(R + L s),   S = 2 K_t R_w/(R + L s),
///   M = (R/K_t) (R_m - R_c + L s - R_w)/(R + L s).
struct WaveParameters {
  double J = 1.07e-6, b = 1.2e-6, K_t = 23.5e-3, R_m = 2.06, L_m = 0.238e-3, b_w = 1e-3, R_c = 0;

  double R_w() const { return K_t * K_t / b_w; }
  double volts_per_command() const { return (R_w() + R_m - R_c) / K_t; }
};
inline KnownDevice make_wave_motor(const WaveParameters& p = {}) {
  Device device;
  device.mechanics.inertia = p.J;
  device.mechanics.damping = p.b;
  device.drive.motor = Motor{p.K_t, p.R_m, p.L_m};
  device.drive.amplifier = VoltageAmplifier{};
  device.drive.damping = {WaveDamping{p.b_w}};
  if (p.R_c > 0) device.drive.damping.push_back(ResistanceCancellation{p.R_c, {}});
  device.sensor = SensorLocation::outgoing_wave;
  return {device, [p](Complex s) {
            const double R = p.R_w() + p.R_m - p.R_c;
            const Complex winding = R + p.L_m * s;
            return PortForm{p.J * s + p.b + p.K_t * p.K_t / winding, R / winding,
                            2 * p.K_t * p.R_w() / winding,
                            p.volts_per_command() * (winding - 2 * p.R_w()) / winding};
          }};
}

/// The current amplifier with a first-order bandwidth [Hz] on the RC motor.
inline KnownDevice make_slow_rc_motor(double bandwidth_hz) {
  KnownDevice known = make_rc_motor();
  known.device.drive.amplifier = CurrentAmplifier{bandwidth_hz};
  return {known.device, [fast = known.at, bandwidth_hz](Complex s) {
            PortForm form = fast(s);
            form.actuation *= 1.0 / (1.0 + s / (2 * pi * bandwidth_hz));
            return form;
          }};
}

/// Motor inertia and load on a compliant transmission t(s) = d + k/s, the sensor on either side:
///   (m s + b + t) v_m = u + t v_p,   f_h = (m_l s + t) v_p - t v_m.
inline KnownDevice make_compliant(double m, double b, const Transmission& t,
                                  SensorLocation sensor) {
  Device device;
  device.motion = Motion::linear;
  device.mechanics.inertia = m;
  device.mechanics.damping = b;
  device.mechanics.transmission = t;
  device.sensor = sensor;
  return {device, [=](Complex s) {
            const Complex link = t.damping + t.stiffness / s;
            const Complex motor = m * s + b;
            const Complex path = link / (motor + link);
            // t - t^2/(motor + t) without the difference
            PortForm form{t.load_inertia * s + motor * path, path};
            if (sensor == SensorLocation::motor) {
              form.sensor_path = path;
              form.blocked_motion = 1.0 / (motor + link);
            }
            return form;
          }};
}

/// F(s) of (filter-1).
inline Complex filter_response(const SensorFilter& filter, Complex s) {
  const Complex p = s / (2 * pi * filter.cutoff_hz);
  return filter.order == 1 ? 1.0 / (1.0 + p) : 1.0 / (1.0 + std::numbers::sqrt2 * p + p * p);
}

/// A device whose sensor is read through a low-pass: S and M behind it, Z and A untouched.
inline KnownDevice behind_filter(KnownDevice known, const SensorFilter& filter) {
  known.device.sensor_filter = filter;
  return {known.device, [bare = known.at, filter](Complex s) {
            PortForm form = bare(s);
            form.sensor_path *= filter_response(filter, s);
            form.blocked_motion *= filter_response(filter, s);
            return form;
          }};
}

/// P3 with a damper to a floating inertia [fig. 8.19b].
inline KnownDevice make_high_pass(double inertia, double damping, const HighPassDamper& far) {
  KnownDevice known = make_point_mass(inertia, damping);
  known.device.drive.damping.push_back(far);
  return {known.device, [=](Complex s) {
            const Complex floating = far.inertia * s;
            return PortForm{
                inertia * s + damping + far.damping * floating / (far.damping + floating), 1.0};
          }};
}

/// The same sequence on every platform, which the distributions of <random> do not promise.
class Random {
 public:
  explicit Random(std::uint64_t seed) : engine_(seed) {}

  double uniform(double from, double to) {
    return from + (to - from) * static_cast<double>(engine_() >> 11U) * 0x1p-53;
  }
  double log_uniform(double from, double to) { return from * std::pow(to / from, uniform(0, 1)); }
  bool chance(double probability) { return uniform(0, 1) < probability; }

 private:
  std::mt19937_64 engine_;
};

}  // namespace gyrator::passivity_tests
