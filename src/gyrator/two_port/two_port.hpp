#pragma once

#include <array>
#include <complex>
#include <functional>
#include <vector>

#include <Eigen/Dense>

namespace gyrator {

/// Hybrid matrix of a two-port at one frequency:
///   f_h = h11 v_h + h12 f_e,      -v_e = h21 v_h + h22 f_e                        (two-port-1)
/// f_h [N, N.m] and v_h [m/s, rad/s] at the operator's port, f_e and v_e what the environment gets.
/// h11 [N.s/m], h22 [m/(N.s)] or rotary, h12 and h21 without unit. An operator Z_h makes
/// f_h = -Z_h v_h, an environment f_e = Z_e v_e; power f_h v_h - f_e v_e flows into the two-port.
struct HybridMatrix {
  std::complex<double> h11, h12, h21, h22;

  /// Impedance that the operator feels in front of the environment Z_e:
  ///   Z_te = (h11 + Dh Z_e)/(1 + h22 Z_e) = h11 - h12 h21 Z_e/(1 + h22 Z_e),
  ///   Dh = h11 h22 - h12 h21                                                      (two-port-2)
  /// Source: (K5), (K10), (K15).
  std::complex<double> transmitted(std::complex<double> environment) const;

  /// The same with v_e = 0, an infinite Z_e: h11 - h12 h21/h22.
  std::complex<double> transmitted_when_clamped() const;
};

/// Impedance matrix of the same two-port, with f_2 = -f_e flowing into it as f_h does:
///   f_1 = z11 v_1 + z12 v_2,      f_2 = z21 v_1 + z22 v_2
struct ImpedanceMatrix {
  std::complex<double> z11, z12, z21, z22;

  /// h11 = z11 - z12 z21/z22, h12 = -z12/z22, h21 = z21/z22, h22 = 1/z22           (two-port-3)
  HybridMatrix to_hybrid() const;
};

/// Left side less right side of Llewellyn's three conditions:
///   Re h11 >= 0,   Re h22 >= 0,   2 Re h11 Re h22 >= |h12 h21| + Re(h12 h21)        (llewellyn)
/// A two-port that is stable by itself stays so between every two passive operators if and only if
/// they hold at every frequency. All three vanish for some two-ports as the frequency goes to zero;
/// `ratio` = 2 Re h11 Re h22/(|h12 h21| + Re(h12 h21)) has a limit there, and the third condition
/// is ratio >= 1 (infinite where nothing is asked for).
/// `felt` is the least damping that a hand feels over all passive environments,
///   min Re Z_te = Re h11 - (|p| + Re p)/(2 Re h22),   p = h12 h21                    (two-port-4)
/// what is missing to it is a damper's at the operator's port; -infinity where Re h22 < 0.
/// |p| + Re p is computed without cancellation, as (Im p)^2/(|p| - Re p) for Re p < 0.
/// Source: Llewellyn 1952; (K2)–(K4), (K7)–(K9), (K12)–(K14).
struct LlewellynMargins {
  double first = 0;   ///< [N.s/m, N.m.s/rad]
  double second = 0;  ///< [m/(N.s), rad/(N.m.s)]
  double third = 0;
  double ratio = 0;
  double felt = 0;  ///< [N.s/m, N.m.s/rad]
};
LlewellynMargins compute_llewellyn_margins(const HybridMatrix& h);

/// Frequencies from one to another [Hz].
struct FrequencyBand {
  double from_hz = 0, to_hz = 0;
};

/// One condition over all frequencies.
struct ConditionResult {
  bool holds = false;
  double margin = 0;              ///< lowest, in the condition's own unit
  double worst_frequency_hz = 0;  ///< where it is lowest
  std::vector<FrequencyBand> violated;
};

struct TwoPortVerdict {
  bool absolutely_stable = false;  ///< all three hold, and the two-port is stable by itself
  std::array<ConditionResult, 3> conditions;
  double ratio = 0;  ///< lowest of the third condition
  double ratio_frequency_hz = 0;
  double felt = 0;  ///< lowest damping felt, by (two-port-4) [N.s/m, N.m.s/rad]
  double felt_frequency_hz = 0;
  /// Spectral radius of what is computed, moved on by its own scheme with both ports as in
  /// (two-port-1): velocity imposed on one side, effort on the other. Above 1: unstable by itself.
  double computed_spectral_radius = 0;
};

/// Judges a two-port over a grid of frequencies [rad/s], refined between its points; bands end
/// where the condition is met to 1e-6 of the frequency. Equality counts as holding: a condition
/// is violated where its left side is below the right one by more than rounding (1e-7 of it).
/// A frequency of 0 is the lowest of the grid: towards zero.
TwoPortVerdict judge_two_port(const std::function<HybridMatrix(double)>& port,
                              const std::vector<double>& grid, double computed_spectral_radius = 0);

/// Frequencies [rad/s] in (0, pi/period] at which a two-port computed at that period is judged:
/// those of make_judging_grid from 1e-5/period on (below, differences of what is nearly 1 would be
/// rounding).
std::vector<double> make_two_port_grid(const Eigen::VectorXcd& poles, double period);

}  // namespace gyrator
