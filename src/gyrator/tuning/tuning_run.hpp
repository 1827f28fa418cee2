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

/// How a tuning ended. Of all but `reached` the settings are back as they were found.
enum class TuningOutcome {
  /// The settings of TuningRun::choice stand. The 99 % bound of the measured response has the wall
  /// passive; or, where a share of the winding was asked for, that much of it or the most that is
  /// allowed is cancelled, every step was stable, and the verdict may be either.
  reached,
  /// Every step was stable and the whole response was measured, but its 99 % bound does not have
  /// the wall passive: it is not, or the noise leaves it open. Not where a share was asked for.
  not_passive,
  /// By the model, with the winding as warm as measured, no setting carries the wall with its
  /// margin: the bare drive was measured, and nothing was raised. Not where a share was asked for.
  unreachable,
  /// The bare drive is not the model's (find_contradiction), or at a step, also while the winding
  /// was watched, motion or current did not fade after a push (find_instability), less of the
  /// winding was left than it should (find_shortage) or the damping was not the model's
  /// (find_deviation). TuningRun::explanation says which.
  stopped
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

/// Settings that a tuning may change: switches (find_disturbing_settings) and values.
const std::vector<std::string>& tuned_settings();

/// Switches all damping off, measures the bare drive and its winding, chooses settings for the
/// model's wall with the winding as warm as it is, and raises them in steps, each measured before
/// the next: whether motion fades after a push, Re Z_e against the model, what is left of the
/// winding's resistance. The first sign of instability ends it. After the watch the whole response
/// is measured and judged (judge_measured).
///
/// Unless the target is reached the settings are put back as they were found (SettingsGuard), also
/// when an exception leaves (device: link, fault or limit; interrupted; bad_input for a model or an
/// amplifier that lacks what is needed).
TuningRun tune(Bench& bench, const PassivityModel& identified, const TuningOptions& options);

}  // namespace gyrator
