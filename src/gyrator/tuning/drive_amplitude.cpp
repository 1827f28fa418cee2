#include "gyrator/tuning/drive_amplitude.hpp"

#include "gyrator/tuning/settings_choice.hpp"

#include <algorithm>
#include <cmath>
#include <complex>
#include <limits>
#include <numbers>

namespace gyrator {
namespace {

// Of what the device bounds, so much may be met on the way from rest to a steady sine.
constexpr double speed_share = 0.5;
constexpr double voltage_share = 0.4;

double find_highest_speed(const BenchLimits& limits) {
  if (limits.largest_velocity > 0) return speed_share * limits.largest_velocity;
  return std::numeric_limits<double>::infinity();
}

}  // namespace

double find_sine_amplitude(const Device& device, const BenchLimits& limits, DriveMode mode,
                           double current, double frequency_hz) {
  const Motor& motor = *device.drive.motor;
  const double K = motor.torque_constant;
  const std::complex<double> s(0, 2 * std::numbers::pi * frequency_hz);
  const std::complex<double> load = s * device.mechanics.inertia + device.mechanics.damping;
  const std::complex<double> winding = motor.warm_resistance() + s * motor.inductance;
  const double by_voltage =
      voltage_share * limits.largest_voltage / (std::abs(winding) + 2 * K * K / std::abs(load));
  const double by_speed = find_highest_speed(limits) * std::abs(load) / (2 * K);
  const double amperes = std::min({current, by_voltage, by_speed});
  if (mode == DriveMode::current) return amperes;
  return amperes * std::abs(winding - find_cancelled_resistance(device.drive) + K * K / load);
}

double find_push_amplitude(const Device& device, const BenchLimits& limits, DriveMode mode,
                           double current, double duration) {
  const Motor& motor = *device.drive.motor;
  const double K = motor.torque_constant;
  const double speed =
      std::min(voltage_share * limits.largest_voltage / K, find_highest_speed(limits));
  if (mode == DriveMode::current)
    return std::min(current, speed * device.mechanics.inertia / (K * duration));
  const double left = motor.warm_resistance() - find_cancelled_resistance(device.drive);
  return std::min(current * left, speed * K);
}

}  // namespace gyrator
