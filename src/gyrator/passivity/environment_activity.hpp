#pragma once

#include "gyrator/controllers/sampling.hpp"
#include "gyrator/mechanics/device.hpp"

#include <optional>
#include <string>
#include <vector>

namespace gyrator {

/// A nonlinear environment without memory: the effort with which it opposes at a position, straight
/// between rows and constant beyond the ends. Command = -f(y).
struct EnvironmentProfile {
  std::vector<double> position;  ///< increasing [m, rad]
  std::vector<double> effort;    ///< f [N, N.m]

  /// Throws bad_input, with the index of the row as place, for fewer than two rows, another number
  /// of efforts, and a position that does not increase.
  void check() const;

  double at(double position) const;
};

/// A slope between two neighbouring rows.
struct ProfileSlope {
  double slope = 0;  ///< [N/m, N.m/rad]
  double from = 0, to = 0;
};

/// How much damping a sampled and held profile takes to be passive.
struct EnvironmentActivity {
  double alpha = 0;      ///< [N.s/m, N.m.s/rad]
  ProfileSlope rising;   ///< steepest, f growing with the position; slope 0 where there is none
  ProfileSlope falling;  ///< steepest the other way, slope positive; 0 where there is none
};

/// The damping alpha [N.s/m, N.m.s/rad] that a sampled, held environment can feed on: over any
/// motion x(t) that ends where it began, the energy that it gives is at most alpha int v^2 dt.
///   alpha = 1/2 (s + sqrt(s^2 + L^2 rho (T - rho))),   s = kappa T/2 + L t_d       (activity-1)
/// kappa the steepest rising slope of f, L the steepest of both [N/m, N.m/rad]; T period, t_d
/// delay, rho its part beyond whole periods [s]. Without delay alpha = kappa T/2, with a whole
/// number of periods kappa T/2 + L t_d. Why:
/// In one period the held f(x_k) gives int (f(x) - f(x_k)) dx more than the potential does, which
/// is at most kappa D^2/2 + L |a| |D|: a the motion during the delay, D the one while f(x_k) is
/// held. (Where f falls, an old value opposes more than it should: that takes energy, and only a
/// motion during the delay that turns back can use it.) With p, q the motions in rho and T - rho of
/// each period, int v^2 >= sum p^2/rho + q^2/(T - rho); the ratio of the two forms, all of whose
/// coefficients are positive, is largest for the same p, q in every period, and there it is the
/// largest eigenvalue of a 2 x 2 matrix.
/// Holds for every profile without memory. Attained, with p and q as above, where the steepest
/// slope rises (kappa = L), and always without delay; else a bound on the safe side. For a straight
/// spring it is where the exact disk of a constant damping begins to fail at low frequency.
/// Source: the condition [8.29] of Miller, Colgate and Freeman 2000; the law is new, tested by
/// motions that attain it and by random ones that stay below.
EnvironmentActivity compute_environment_activity(const EnvironmentProfile& profile,
                                                 const Sampling& sampling);

/// The motion that attains alpha: |motion| in the delay's part rho of a period over that in all of
/// it. rho/T would be a constant velocity.
double find_worst_share(const EnvironmentActivity& activity, const Sampling& sampling);

struct EnvironmentVerdict {
  EnvironmentActivity activity;
  double dissipation = 0;               ///< delta, the least Re Z over all frequencies
  double dissipation_frequency_hz = 0;  ///< where; the limit at zero if constant
  std::optional<double> coupling;       ///< gamma [N.s/m, N.m.s/rad]
  double allowed = 0;                ///< what alpha must stay below: delta, or with gamma in series
  bool inequality = false;           ///< alpha < allowed
  std::vector<std::string> reasons;  ///< why the inequality says nothing here; empty: it does

  bool applies() const { return reasons.empty(); }
  bool holds() const { return inequality && applies(); }
};

/// Whether device and environment are passive together:
///   alpha < delta                                                                         [8.29]
///   alpha < delta gamma/(delta + gamma)    behind a virtual coupling of damping gamma     [8.30]
/// delta = least Re Z(jw), 0 < w < infinity. Holds where the command reaches the port unchanged
/// (A = 1) from a position sensed there; `reasons` tells what is not so. The second is the damper
/// gamma in series with a damper -alpha, met by delta; a coupling's spring helps, if at all. It is
/// stricter than the first for one alpha. Dry friction is not counted.
/// Throws bad_input at "coupling damping" for one that is not positive.
EnvironmentVerdict judge_environment(const EnvironmentProfile& profile, const Device& device,
                                     const Sampling& sampling,
                                     std::optional<double> coupling_damping);

}  // namespace gyrator
