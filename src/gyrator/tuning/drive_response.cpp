#include "gyrator/tuning/drive_response.hpp"

#include <cmath>
#include <numbers>

namespace gyrator {

DrivePoint find_drive_point(DriveMode mode, const Motor& motor, const Tone& bare,
                            const Tone& damped) {
  const double omega = 2 * std::numbers::pi * damped.frequency_hz;
  const std::complex<double> back_emf = motor.torque_constant * damped.velocity.value;
  DrivePoint point;
  point.frequency_hz = damped.frequency_hz;
  if (mode == DriveMode::current) {
    point.gain = bare.current.value / bare.command.value;
    point.winding = {motor.warm_resistance(), omega * motor.inductance};
    point.source = (point.gain * damped.command.value - damped.current.value) /
                   (point.winding * damped.current.value + back_emf);
  } else {
    point.gain = bare.voltage.value / bare.command.value;
    point.winding = (damped.voltage.value - back_emf) / damped.current.value;
    point.source =
        (point.gain * damped.command.value - damped.voltage.value) / damped.current.value;
  }
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
