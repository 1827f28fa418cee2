#pragma once

#include "gyrator/controllers/controller.hpp"
#include "gyrator/passivity/counterexample.hpp"
#include "gyrator/passivity/disk_proof.hpp"
#include "gyrator/passivity/stiffness_limit.hpp"

#include <optional>
#include <string>
#include <vector>

namespace gyrator {

/// One criterion's answer. Margins are dampings [N.s/m, N.m.s/rad]: what is left at the worst
/// frequency, negative by what is missing there.
struct CriterionResult {
  std::string name;
  bool applies = false;  ///< its assumptions hold for this device
  bool holds = false;    ///< its inequality holds, whether it applies or not
  double margin = 0;
  std::optional<double> worst_frequency_hz;
  std::optional<double> max_stiffness;  ///< largest K at the model's virtual damping
  std::string reason;                   ///< why it does not apply, or what it says
};

/// Damping over frequency, for the picture of figs 8.18–8.21 [N.s/m, N.m.s/rad].
struct DampingCurves {
  std::vector<double> frequency_hz, physical, virtual_damping, total, exact;
};

/// A linear loop that was judged, and what is proved of it.
struct JudgedLoop {
  std::string name;  ///< "in_contact", or "free": a coupling's tool away from its wall
  DiscreteStateSpace law;
  double uncoupled_spectral_radius = 0;  ///< with nothing attached
  DiskProof proof;
};

struct Verdict {
  bool passive = false;
  /// All that a passive verdict rests on; the first that is not where it is not passive.
  std::vector<JudgedLoop> loops;
  Controller judged;        ///< the controller in the state that the verdict speaks of
  std::string explanation;  ///< one sentence
  std::vector<CriterionResult> criteria;
  bool device_passive = true;  ///< Re Z >= 0 everywhere, alone
  double least_damping = 0;    ///< lowest Re Z over base frequencies and aliases
  double least_damping_frequency_hz = 0;
  /// Smallest additional port damping that mends all that a passive verdict would rest on; none if
  /// it cannot.
  std::optional<double> extra_damping;
  DiskPoint worst_disk;
  /// The disk and H where the picture says most: at the counterexample's frequency, else at the
  /// worst one, but not below the slowest pole (towards zero frequency every disk is a half-plane).
  DiskPoint shown_disk;
  std::complex<double> shown_law;
  DampingCurves curves;
  std::optional<Counterexample> counterexample;
};

struct PassivityModel {
  Device device;
  Controller controller;
  Sampling sampling;
  double quantum = 0;  ///< encoder quantum [m, rad]
};

/// Judges the sampled loop for every passive operator. The verdict is the exact disk's, proved
/// between the points too (prove_disk), so that one too close to call is not passive; the textbook
/// criteria stand beside it with the reason where they do not apply. Throws numerical for a device
/// that is unstable alone.
Verdict judge_passivity(const PassivityModel& model, bool search_counterexample = true);

}  // namespace gyrator
