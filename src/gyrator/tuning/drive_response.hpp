#pragma once

#include "gyrator/amplifiers/experiment.hpp"
#include "gyrator/circuits/drive.hpp"
#include "gyrator/identification/sine_measurement.hpp"

#include <complex>
#include <vector>

namespace gyrator {

/// A sine in steady state, as it was captured. A signal s(t) is Re{S e^(jwt)}; t = 0 is the
/// excitation's begin for all of them.
struct Tone {
  double frequency_hz = 0;
  double duration = 0;  ///< that it took [s]
  Phasor command;       ///< of the generator's values, before they are held [A or V]
  Phasor current;       ///< in the winding [A]
  Phasor voltage;       ///< at the motor's terminals [V]
  Phasor velocity;      ///< [rad/s, m/s]
};

/// What the motor sees of the drive at one frequency:
///   current mode   i = G u - Y v      G without unit, Y [S]                          (tune-1)
///   voltage mode   v = G u - Z i      G without unit, Z [ohm]                        (tune-2)
/// and the winding v - K_t w = (R + jwL) i.
struct DrivePoint {
  double frequency_hz = 0;
  std::complex<double> gain;     ///< G
  std::complex<double> source;   ///< Y or Z
  std::complex<double> winding;  ///< R + jwL [ohm]
};

/// From two sines of one frequency, free of images (remove_step_images): `bare`, with all damping
/// switched off, where Y or Z is zero (the amplifier is taken to be a stiff source by itself), and
/// `damped`. In current mode v is (R + jwL) i + K_t w with the motor's warm resistance and its
/// inductance, less disturbed than the sampled voltage; in voltage mode the winding is measured.
DrivePoint find_drive_point(DriveMode mode, const Motor& motor, const Tone& bare,
                            const Tone& damped);

/// The drive's share of the port (docs/tuning.md):
///   current mode   Z_e = K_t^2 Y/(1 + Y Z_w)      A = g K_t G/(1 + Y Z_w)
///   voltage mode   Z_e = K_t^2/(Z_w + Z)          A = g K_t G/(Z_w + Z)              (tune-3)
/// g is the command per effort asked for [A/N.m, V/N.m …].
struct DrivePort {
  double frequency_hz = 0;
  std::complex<double> impedance;  ///< Z_e, on top of the mechanics' [N.m.s/rad, N.s/m]
  std::complex<double> actuation;  ///< A
};
DrivePort find_drive_port(DriveMode mode, double torque_constant, double gain,
                          const DrivePoint& point);

}  // namespace gyrator
