#pragma once

#include "gyrator/studies/model_file.hpp"

#include <optional>
#include <string>

namespace gyrator {

struct SpiceRequest {
  double from_hz = 0.1, to_hz = 1e4;  ///< of the AC analysis
  int points_per_decade = 20;
  std::optional<Rational> duration;      ///< of the transient, instead of the model's
  std::optional<Rational> largest_step;  ///< of the transient, instead of one by the plant's poles
  std::string data_name = "gyrator";  ///< the deck's own files begin with it (letters, digits, _)
  bool quiet = true;                  ///< no progress bar
};

/// A model's continuous plant as a netlist that `ngspice -b` runs unchanged, mechanics included:
/// velocity is voltage and effort is current.
///
/// AC: the port is driven (an effort of 1, or a velocity of 1 where it is clamped), then the
/// command, and from velocity v and effort f at the port
///   Z = f/v  (no command)        A = Z v - f  (command 1)                          (spice-1)
/// whatever operator holds the port. Transient: the command that the amplifier holds in the run of
/// the sampled loop (exact engine; cvode where the model is not linear), as a piecewise linear
/// source whose edges ngspice cannot step over, from the model's initial state.
struct SpiceDeck {
  std::string text;
  /// Relative names of the files that ngspice writes: frequency, Re and Im of Z and of A; time,
  /// position, velocity, held command and, where `has_current`, the motor's current.
  std::string impedance_file, motion_file;
  bool has_current = false;
  TimeRun run;  ///< the run whose command the transient replays
};

/// Errors as those of run_simulation.
SpiceDeck make_spice_deck(const Model& model, const SpiceRequest& request);

/// How long the edge of a hold takes, in sample periods; the motion is late by half of it.
inline constexpr double spice_edge_periods = 1e-6;

}  // namespace gyrator
