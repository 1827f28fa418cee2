#pragma once

#include "gyrator/verification/held_device.hpp"

#include <vector>

namespace gyrator {

/// Hurwitz's zeta, sum over n >= 0 of (n + a)^-power, by Euler and Maclaurin; power >= 2, a >= 32.
template <class Real>
Real compute_zeta(int power, Real a);

/// Aliases first <= |n| < last together; last = 0: all from first on.
struct AliasBand {
  int first = 0, last = 0;
  HeldBand response;
};

/// All aliases from `first` on in bands in which the device's response, enclosed over each, moves
/// little. `rate` = 2 pi/T [rad/s].
std::vector<AliasBand> enclose_alias_bands(const HeldEnclosure& device, double rate, int first);

/// Sum over a band of 1/(omega + t + n rate)^2 for n > 0 (side = 1) or n < 0 (side = -1).
SlopeForm weigh_band(const AliasBand& band, int side, double rate, double omega, double reach);

}  // namespace gyrator
