#pragma once

#include "gyrator/controllers/discrete_state_space.hpp"
#include "gyrator/robustness/box_model.hpp"

namespace gyrator {

/// A function of s that is real at s = 0, together with its divided differences there:
///   f = c0 + s q1,   q1 = c1 + s q2                                                      (box-5)
/// so that f/s without its pole is known where s may be zero, without a difference of large
/// numbers. c0 and c1 depend on the parts alone.
struct DividedModel {
  BoxModel f, c0, c1, q1, q2;
};

inline DividedModel operator*(const DividedModel& a, const DividedModel& b) {
  return {a.f * b.f, a.c0 * b.c0, a.c0 * b.c1 + a.c1 * b.c0, a.q1 * b.f + a.c0 * b.q1,
          a.q2 * b.f + a.c1 * b.q1 + a.c0 * b.q2};
}

/// Frequencies |w| within `reach` of omega: s = j (omega + reach d_0).
struct Band {
  double omega = 0, reach = 0;  ///< [rad/s]
  double low() const { return omega - reach; }
  double high() const { return omega + reach; }
  BoxModel s() const;
};

/// e^(-s time)
DividedModel expand_turn(const Band& band, double time);
/// (1 - e^(-sT))/(sT)
DividedModel expand_hold(const Band& band, double period);
/// H(e^(sT)) of a law that has a steady state.
DividedModel expand_law_divided(const DiscreteStateSpace& law, double period, const Band& band);

}  // namespace gyrator
