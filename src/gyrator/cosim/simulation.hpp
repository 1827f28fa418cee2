#pragma once

#include "gyrator/controllers/controller.hpp"
#include "gyrator/controllers/sampling.hpp"
#include "gyrator/cosim/classification.hpp"
#include "gyrator/cosim/engine.hpp"
#include "gyrator/mechanics/plant.hpp"

#include <functional>
#include <optional>
#include <string>
#include <vector>

namespace gyrator {

/// The sensor: the multiple of `quantum` nearest to the true position, halves up, plus `offset`.
struct Sensor {
  double quantum = 0;  ///< [m, rad]; 0 for none
  double offset = 0;   ///< [m, rad]
};

struct SimulationOptions {
  Rational duration{1, 2};      ///< [s]; runs to the last sample instant at or before it
  double initial_position = 0;  ///< [m, rad]
  double initial_velocity = 0;  ///< [m/s, rad/s]
  double external_effort = 0;   ///< constant effort that the operator adds at the port [N, N.m]
  EngineKind engine = EngineKind::exact;
  EngineOptions engine_options;
  std::optional<Rational>
      trace_step;         ///< also record in between, every so many seconds, and at hold edges
  bool record = true;     ///< keep the trace's columns; a run without them is not classified
  long record_every = 1;  ///< samples per row, for long runs
  ClassificationOptions classification;
  std::function<void(long)>
      on_progress;  ///< called now and then with the samples done since the last call
};

/// Energies since t = 0 [J]; operator + source = (stored - stored at start) + dissipated +
/// residual.
struct EnergyLedger {
  double operator_work = 0, source = 0, stored = 0, stored_initially = 0, dissipated = 0,
         residual = 0;
};

/// Columns of equal length. Row k is sample instant k: the state before the command jumps, the
/// command computed there, and in columns "..._after" what the jump of the held command changes at
/// that instant. With a trace step, rows in between too, and two rows where the hold jumps.
struct Trace {
  std::vector<std::string> names;
  std::vector<std::vector<double>> columns;

  const std::vector<double>& column(const std::string& name) const;
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
};

/// The sampled loop: at each tick the sensor is read before the jump, the command computed, and
/// applied after the delay; the plant between is the engine's. Deterministic.
/// Throws bad_input for a duration below one period, numerical where an engine gives up.
TimeRun simulate(const Plant& plant, const Sensor& sensor, const Controller& controller,
                 const Sampling& sampling, const SimulationOptions& options);

}  // namespace gyrator
