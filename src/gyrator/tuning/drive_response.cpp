#include "gyrator/tuning/drive_response.hpp"

#include <cmath>
#include <numbers>

namespace gyrator {
namespace {

// A held value's fundamental per sample: sin(x)/x e^(-jx), x = w t/2.
std::complex<double> hold(double omega, double tick) {
  const double x = omega * tick / 2;
  return x == 0 ? 1.0 : std::polar(std::sin(x) / x, -x);
}

}  // namespace

DrivePoint find_drive_point(DriveMode mode, double torque_constant, double tick, const Tone& bare,
                            const Tone& damped) {
  const double omega = 2 * std::numbers::pi * damped.frequency_hz;
  DrivePoint point;
  point.frequency_hz = damped.frequency_hz;
  point.winding =
      (damped.voltage.value - torque_constant * damped.velocity.value) / damped.current.value;
  const bool is_current = mode == DriveMode::current;
  const std::complex<double> held_gain =
      (is_current ? bare.current.value : bare.voltage.value) / bare.command.value;
  const std::complex<double> asked = held_gain * damped.command.value;
  point.source = is_current ? (asked - damped.current.value) / damped.voltage.value
                            : (asked - damped.voltage.value) / damped.current.value;
  point.gain = held_gain / hold(omega, tick);
  return point;
}

DrivePort find_drive_port(DriveMode mode, double torque_constant, double gain,
                          const DrivePoint& point) {
  DrivePort port;
  port.frequency_hz = point.frequency_hz;
  const double K = torque_constant;
  if (mode == DriveMode::current) {
    const std::complex<double> loop = 1.0 + point.source * point.winding;
    port.impedance = K * K * point.source / loop;
    port.actuation = gain * K * point.gain / loop;
  } else {
    const std::complex<double> loop = point.winding + point.source;
    port.impedance = K * K / loop;
    port.actuation = gain * K * point.gain / loop;
  }
  return port;
}

}  // namespace gyrator
