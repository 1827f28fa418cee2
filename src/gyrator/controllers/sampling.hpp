#pragma once

#include "gyrator/core/rational.hpp"

namespace gyrator {

/// The sampled side's clock. All are exact [s].
///
/// At tick k the sensor is read at t_k = k * period; the command computed from it takes effect
/// at t_k + delay, which may be any length, fractions of a period included. With a jitter, below
/// half a period, t_k is off by a random time within ± jitter; linear tools take it as 0.
struct Sampling {
  Rational period{1, 1000};
  Rational delay{0};
  Rational jitter{0};
};

}  // namespace gyrator
