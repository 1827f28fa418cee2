#pragma once

#include "gyrator/amplifiers/experiment.hpp"
#include "gyrator/passivity/verdict.hpp"

#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace gyrator {

/// What an amplifier can make damping of.
enum class TuningCircuit {
  rc,           ///< R_1 and C across the motor, behind a current amplifier
  cancellation  ///< a part of the winding's resistance cancelled, in a voltage amplifier
};
std::string_view name_of(TuningCircuit circuit);
DriveMode mode_of(TuningCircuit circuit);

/// What is wanted: a wall, or a share of the winding's resistance cancelled whatever wall it
/// allows.
struct TuningTarget {
  TuningCircuit circuit = TuningCircuit::rc;
  /// The wall's K must stay below the passive limit divided by this.
  double margin = 1.2;
  /// Cancel so much of the winding, as warm as it is; none: what the wall needs.
  std::optional<double> cancellation;
  /// … and never more than this.
  double most_cancellation = 0.85;
};

/// The values of the amplifier that make up a circuit, and the device that results.
struct TuningChoice {
  TuningCircuit circuit = TuningCircuit::rc;
  std::vector<Setting> settings;
  Device device;             ///< the identified one with them
  double max_stiffness = 0;  ///< by the exact disk at the wall's B [N.m/rad, N/m]
  bool reaches_wall = false;
};

/// R_c of a drive that cancels resistance [ohm]; 0 without.
double find_cancelled_resistance(const Drive& drive);

/// The identified device behind the amplifier's settings: `identified` with its motor, mechanics
/// and bandwidth, driven in the circuit's mode, with the damping that the settings stand for. Its
/// gain makes the blocked effort equal the command with the winding as warm as it is.
Device make_tuned_device(const Device& identified, TuningCircuit circuit,
                         const std::vector<Setting>& settings);

/// Where a setting may lie.
using RangeOf = std::function<SettingRange(std::string_view)>;

/// Chooses settings on the amplifier's own lattice (step and limits) for the model's wall. An RC
/// branch: of those that carry the wall with its margin, the one of least capacitance (apparent
/// inertia), or where none does the one of the stiffest wall. A cancellation: the least that
/// carries the wall, or the most that is allowed. Throws bad_input for a controller without a wall.
TuningChoice choose_settings(const PassivityModel& model, const TuningTarget& target,
                             const RangeOf& range_of);

/// The value of the lattice nearest to `value`; `down`: the nearest that does not exceed it.
double snap(double value, const SettingRange& range, bool down = false);

/// The value of a setting in a list; throws bad_input where it is not in it.
double value_of(const std::vector<Setting>& settings, std::string_view name);

}  // namespace gyrator
