#pragma once

#include "gyrator/passivity/port_response.hpp"
#include "gyrator/passivity/verdict.hpp"
#include "gyrator/tuning/drive_response.hpp"

#include <cstdint>
#include <optional>
#include <vector>

namespace gyrator {

/// Two runs of the same sines, free of images: without any damping, and with what is judged.
struct DriveMeasurement {
  DriveMode mode = DriveMode::current;
  double delay = 0;  ///< of the amplifier, which the model has in its sampling's delay [s]
  std::vector<Tone> bare, damped;  ///< at the same, rising frequencies
};

/// One measured frequency, beside the model.
struct MeasuredPoint {
  double frequency_hz = 0;
  std::complex<double> impedance, actuation;  ///< Z and A at the port
  double damping_low = 0, damping_high = 0;   ///< 99 % interval of Re Z
  std::complex<double> modelled_impedance, modelled_actuation;
  double winding_resistance = 0;  ///< Re(R + jwL) [ohm]
};

/// Whether the wall is passive on the drive as it was measured.
struct MeasuredVerdict {
  /// The least margin's 99 % lower bound is positive, no alias is active, and the loop with
  /// nothing attached is stable.
  bool passive = false;
  double margin = 0;      ///< least D of (disk-3) over frequency [N.m.s/rad, N.s/m]
  double margin_low = 0;  ///< not undercut by 99 % of what the measurement's noise would make of it
  double worst_frequency_hz = 0;
  double max_stiffness = 0;      ///< largest K at the wall's B by the measured disk; 0: none
  double max_stiffness_low = 0;  ///< its 99 % lower bound
  double modelled_max_stiffness = 0;
  std::vector<MeasuredPoint> points;
};

/// Throws what judge_measured does for a model that it does not judge.
void check_measurable(const PassivityModel& model);

/// Judges a wall by the exact disk with the drive's measured response in the model's place.
///
/// `model` is the identified device with the settings that were measured, the winding as warm; its
/// mechanics are the identified ones, rigid, sensed at the port. Of Z_e and A the ratio to the
/// model's is taken at each measured frequency and interpolated over the logarithm of frequency;
/// below the lowest one its size is kept and its phase goes to zero with frequency, above the
/// highest it goes to one within an octave. The intervals are from `draws` repetitions with the
/// measured standard errors (parametric bootstrap), deterministic for a seed.
/// Throws bad_input for a controller without a wall from the position, a compliant transmission, a
/// sensor elsewhere, or fewer than four frequencies.
MeasuredVerdict judge_measured(const PassivityModel& model, const DriveMeasurement& measurement,
                               std::uint64_t seed = 1, int draws = 200);

}  // namespace gyrator
