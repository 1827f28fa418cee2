#pragma once

#include "gyrator/tuning/measured_verdict.hpp"
#include "gyrator/tuning/settings_choice.hpp"
#include "gyrator/tuning/tone_measurement.hpp"

#include <functional>
#include <optional>
#include <string>
#include <vector>

namespace gyrator {

struct TuningOptions {
  TuningTarget target;
  double current = 0;  ///< largest of the sines [A]; 0: a fifth of what the bench allows
  /// Of the sines; above a twentieth of the generator's rate its steps are no longer small.
  double lowest_hz = 3, highest_hz = 400;
  int frequencies = 10;  ///< of a whole measurement
  /// Keep following the winding for so long after the last step [s of the device].
  double watch = 0;
  double watch_interval = 2;  ///< [s]
  std::function<void(const struct TuningStep&)> on_step;
};

/// One raise of the settings, and what was measured after it.
struct TuningStep {
  double time = 0;  ///< since the run's begin [s of excitations and waiting]
  std::vector<Setting> settings;
  double winding_resistance = 0;    ///< as warm as it is [ohm]
  double remaining_resistance = 0;  ///< of winding and source in series; cancellation only [ohm]
  double measured_damping = 0;      ///< Re Z_e at `frequency_hz` [N.m.s/rad, N.s/m]
  double modelled_damping = 0;
  double frequency_hz = 0;
  double decay = 0;  ///< of the motion after a push [1/s]; negative: it grew; 0: lost in the noise
  bool stable = true;
  std::string remark;
};

/// How a tuning ended.
enum class TuningOutcome {
  reached,      ///< settings stand: the wall is passive by the measured response, or the share of
                ///< the winding that was asked for is cancelled, whatever the verdict
  not_passive,  ///< measured, and the wall is not passive: settings were put back
  unreachable,  ///< no setting carries the wall: nothing was raised
  stopped       ///< a step showed a sign of instability: settings were put back
};
std::string_view name_of(TuningOutcome outcome);

struct TuningRun {
  TuningOutcome outcome = TuningOutcome::unreachable;
  std::string explanation;
  TuningChoice choice;
  PassivityModel model;  ///< identified, with the settings reached and the winding as warm
  std::vector<TuningStep> steps;
  DriveMeasurement measurement;
  std::optional<MeasuredVerdict> verdict;
  Capture ring_down;  ///< after the last step
};

/// Settings that a tuning may change, in the order of switching off.
const std::vector<std::string>& tuned_settings();

/// Of them those at whose zero no damping acts.
const std::vector<std::string>& damping_switches();

/// Switches all damping off, measures the bare drive and its winding, chooses settings for the
/// model's wall with the winding as warm as it is, and raises them in steps, each measured before
/// the next: whether motion fades after a push, Re Z_e against the model, what is left of the
/// winding's resistance. The first sign of instability ends it. After the watch the whole response
/// is measured and judged (judge_measured).
///
/// Unless the target is reached the settings are put back as they were found, also when an
/// exception leaves (device: link, fault or limit; interrupted; bad_input for a model or an
/// amplifier that lacks what is needed).
TuningRun tune(Bench& bench, const PassivityModel& identified, const TuningOptions& options);

}  // namespace gyrator
