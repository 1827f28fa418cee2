#pragma once

#include "gyrator/amplifiers/experiment.hpp"
#include "gyrator/identification/amplifier_fit.hpp"
#include "gyrator/identification/motor_fit.hpp"

#include <functional>
#include <optional>
#include <string>
#include <vector>

namespace gyrator {

/// How far the experiments may go, as shares of the bench's limits, and what is assumed.
struct IdentificationOptions {
  double current_share = 0.3;                ///< of the current limit, as amplitude of a sine
  double voltage_share = 0.6;                ///< of the voltage limit, at the terminals
  double velocity_share = 0.6;               ///< of the velocity limit, where there is one
  double confidence = 0.99;                  ///< of the intervals
  double temperature_error = 0.5;            ///< largest, of the winding's temperature [K]
  double temperature_coefficient = 0.00393;  ///< of the winding [1/K]
  double highest_frequency_hz = 1500;        ///< of the sines
  double slow_frequency_hz = 1;              ///< of the sines for friction
};

/// One experiment that was run.
struct Experiment {
  std::string purpose;  ///< "amplitude", "winding and amplifier", "motion", "inertia", "friction"
  Excitation excitation;
  CaptureRequest capture;
};

/// Experiments to come; their amplitudes and frequencies follow from one another.
struct PlannedStep {
  std::string purpose;  ///< as of the experiments
  DriveMode mode = DriveMode::current;
  double lowest_hz = 0, highest_hz = 0;  ///< of the sines
  double smallest = 0, largest = 0;      ///< amplitude [A or V]
  int runs = 0;                          ///< at most
  double duration = 0;                   ///< of all together, at most [s]
};

/// A value with its interval, by the model file's name.
struct IdentifiedParameter {
  std::string name;  ///< "resistance", "inductance", …
  std::string unit;
  std::optional<double> value, low, high;  ///< in SI units; none: not known at all
  bool identifiable = false;               ///< the interval is narrower than the value itself
  std::string note;                        ///< why not, or what the value stands for
};

struct Identification {
  std::vector<IdentifiedParameter> parameters;
  std::vector<Experiment> experiments;  ///< as they were run
  double duration = 0;                  ///< of all excitations and pauses [s]
  double tick = 1e-4;                   ///< of the amplifier [s]
  double winding_temperature = 298.15;  ///< mean over the sines [K]
  bool temperature_known = false;
  double position_quantum = 0;
  std::vector<SineMeasurement> sines;
  std::vector<MotionWindow> windows;
  std::optional<AmplifierFit> amplifier;
  std::optional<HeldLag> lag;  ///< the amplifier's, or the apparent one
  std::optional<MotionFit> motion;
  std::optional<WindingFit> winding;
  WindingOptions winding_options;  ///< that it was fitted with

  const IdentifiedParameter& find(const std::string& name) const;
};

/// Whether a window is of the slow sines for friction.
bool is_slow(const MotionWindow& window, const Identification& found);

/// Called before each experiment.
using ExperimentListener = std::function<void(const Experiment&)>;

/// The experiments in their order. Throws bad_input for a bench that plays no sines of current.
std::vector<PlannedStep> plan_identification(const BenchLimits& limits,
                                             const IdentificationOptions& options);

/// Moves the motor and finds what it is. Amplitudes begin at a fiftieth of the limit and grow until
/// the signals stand a thousand standard deviations above their noise or the options' shares are
/// reached. What acts on the motor beside the command is switched off meanwhile (SettingsGuard).
/// Throws what the bench does, and interrupted after Ctrl-C.
Identification identify(Bench& bench, const IdentificationOptions& options = {},
                        const ExperimentListener& listener = {});

}  // namespace gyrator
