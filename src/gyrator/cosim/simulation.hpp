#pragma once

#include "gyrator/controllers/controller.hpp"
#include "gyrator/controllers/sampling.hpp"
#include "gyrator/core/error.hpp"
#include "gyrator/cosim/classification.hpp"
#include "gyrator/cosim/command_path.hpp"
#include "gyrator/cosim/engine.hpp"
#include "gyrator/cosim/gesture.hpp"
#include "gyrator/cosim/sensor.hpp"
#include "gyrator/cosim/trace_recorder.hpp"
#include "gyrator/mechanics/plant.hpp"

#include <cstdint>
#include <functional>
#include <optional>

namespace gyrator {

/// A run has run away when a state is this much larger than any was in the first samples; looked at
/// every so many samples.
inline constexpr double runaway_ratio = 1e9;
inline constexpr long samples_between_checks = 16;

struct SimulationOptions {
  Rational duration{1, 2};      ///< [s]; runs to the last sample instant at or before it
  double initial_position = 0;  ///< [m, rad]
  double initial_velocity = 0;  ///< [m/s, rad/s]
  double external_effort = 0;   ///< constant effort that the operator adds at the port [N, N.m]
  std::optional<HandGesture> gesture;  ///< adds to it
  Dac dac;
  std::uint64_t seed = 1;  ///< of noise, jitter and random gestures
  EngineKind engine = EngineKind::exact;
  EngineOptions engine_options;
  std::optional<Rational>
      trace_step;         ///< also record in between, every so many seconds, and at hold edges
  bool record = true;     ///< keep the trace's columns; a run without them is not classified
  long record_every = 1;  ///< samples per row, for long runs
  ClassificationOptions classification;
  /// A failure on the way comes back in TimeRun::failure, with the run up to there, instead of
  /// being thrown.
  bool keep_failed = false;
  std::function<void(long)>
      on_progress;  ///< called now and then with the samples done since the last call
};

/// Energies since t = 0 [J]; operator + source = (stored - stored at start) + dissipated +
/// residual.
struct EnergyLedger {
  double operator_work = 0, source = 0, stored = 0, stored_initially = 0, dissipated = 0,
         residual = 0;
};

struct TimeRun {
  Trace trace;
  EnergyLedger energy;
  Classification classification;
  double final_time_s = 0;
  long steps = 0;
  EngineKind engine = EngineKind::exact;
  ContactEvents events;        ///< of friction and stops
  bool stopped_early = false;  ///< grew beyond 1e9 times its largest size at the start
  /// Why it ended before its time: numerical or interrupted. The ledger is that of the last sample
  /// instant, `final_time_s`; nothing is classified.
  std::optional<Error> failure;
};

/// The sampled loop: at each tick the sensor is read before the jump, the command computed,
/// converted, and applied after the delay; the plant between is the engine's. A gesture is held at
/// its mean from tick to tick. Deterministic: noise, jitter and random gestures follow from the
/// seed.
/// Throws bad_input for a duration below one period; numerical where an engine gives up and where
/// a command is not finite; interrupted on Ctrl-C.
TimeRun simulate(const Plant& plant, const Sensor& sensor, const Controller& controller,
                 const Sampling& sampling, const SimulationOptions& options);

}  // namespace gyrator
