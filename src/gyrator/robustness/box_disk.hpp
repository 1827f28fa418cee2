#pragma once

#include "gyrator/controllers/sampling.hpp"
#include "gyrator/robustness/box_aliases.hpp"

namespace gyrator {

/// The sampled side: the same for every box.
struct SampledSide {
  DiscreteStateSpace law;
  double period = 0, delay = 0;  ///< [s]
  double steady_law = 0;         ///< H(1)
};

/// D of (disk-3) over a band of base frequencies 0 <= w <= pi/T, which may begin at 0, and a box of
/// parts.
struct BoxMargin {
  BoxModel margin;         ///< real; D is nowhere below lowest_real()
  double size = 0;         ///< of what it was summed from, for the rounding
  bool is_damped = false;  ///< Re Z > 0 throughout
  /// What the loop answers to a position at rest is zero, or of one sign, throughout: no pole of
  /// the loop is at z = 1 for some parts only.
  bool keeps_sign = false;
  double lowest() const { return margin.lowest_real() - rounding * size; }
  static constexpr double rounding = 1e-10;
};

/// D grouped as (proof-1). With the pole of L at zero frequency divided out (box-5), c0 = H k_0 s
/// of path and command at rest and N = N_0 + s N_1:
///   D = R (|W|^2 - w^2 G^2) + Re{W* L_1} - c0 (Re N_1 + Re E) - |f| G                      (box-9)
///   f = command S A = c0 + s L_1,   W = 1 + N + s E,   E = H hold c_a,   G = |H hold| r_a
/// or, above zero frequency, with Re{W* f/s} in place of the three; the higher bound holds.
BoxMargin bound_margin(const BoxPortModel& port, const SampledSide& side, const AliasSums& aliases,
                       const Band& band);

/// Whether D has a finite bound at zero frequency: what the sensor sees of a steady command with
/// the port held is nothing, or the law does not answer it.
bool has_limit_at_rest(const BoxPortModel& port, const SampledSide& side);

}  // namespace gyrator
