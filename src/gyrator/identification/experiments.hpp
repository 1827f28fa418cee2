#pragma once

#include "gyrator/identification/identification.hpp"

#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace gyrator {

/// Plays experiments whose amplitudes follow from what the ones before them showed.
class Experiments {
 public:
  Experiments(Bench& bench, const IdentificationOptions& options,
              const ExperimentListener& listener, Identification& found);

  /// Grows a sine until it stands well above the noise.
  void find_amplitude();
  /// Sines over all frequencies, up and down again.
  void sweep_sines();
  /// Slower and slower, until the encoder sees the motor move. False: it does not.
  bool find_motion();
  /// Faster and faster, with as much of the current for inertia as may be.
  void measure_inertia();
  /// Slow sines up to the largest speed, in both directions.
  void measure_friction();

 private:
  SineMeasurement measure_sine(const std::string& purpose, double frequency_hz, double amplitude);
  double limit_amplitude(double frequency_hz, double wanted) const;
  void measure_motion(const std::string& purpose, double frequency_hz, double amplitude,
                      int periods);
  void look_at_steps(const Capture& capture);
  void refit();
  double find_velocity_cap() const;
  Capture play(const Experiment& experiment);

  Bench& bench_;
  BenchLimits limits_;
  IdentificationOptions options_;
  const ExperimentListener& listener_;
  Identification& found_;
  double amplitude_ = 0;      // of the sines [A]
  double inertia_guess_ = 0;  // J/K [A s^2/rad]
  double seen_velocity_ = 0;  // the largest peak so far [rad/s]
  int groups_ = 0, runs_ = 0;
};

/// The largest speed that a current a sin(2 pi f t) brings a motor of (motion-1) to from rest
/// within some periods [rad/s].
double find_peak_velocity(double inertia, double damping, double friction, double amplitude,
                          double frequency_hz, int periods);

/// The step of an encoder, from how its captured position moves; none where it does not, or moves
/// by no multiples of one step [rad, m].
std::optional<double> find_quantum(const std::vector<double>& position);

}  // namespace gyrator
