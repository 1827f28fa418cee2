#pragma once

#include <complex>
#include <numbers>
#include <optional>

namespace gyrator {

/// The angular frequency 2 pi f [rad/s] of a frequency f [Hz].
constexpr double to_radians(double frequency_hz) {
  return 2 * std::numbers::pi * frequency_hz;
}

/// A sine of one capture, with its standard deviation in real and imaginary part.
struct Phasor {
  std::complex<double> value;
  double deviation = 0;
};

/// One sine played to steady state, and what the signals held of it.
struct SineMeasurement {
  double frequency_hz = 0;
  std::complex<double> played;     ///< what was asked of the generator [A or V]
  std::optional<Phasor> command;   ///< [A or V]; none: not captured
  Phasor current;                  ///< [A]
  std::optional<Phasor> voltage;   ///< [V]
  std::optional<Phasor> velocity;  ///< [rad/s, m/s]; the sensor's
  std::optional<Phasor> position;  ///< [rad, m]
  double temperature = 298.15;     ///< of the winding, mean [K]
  int group = 0;
};

}  // namespace gyrator
