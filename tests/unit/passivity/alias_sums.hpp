#pragma once

#include "gyrator/controllers/sampling.hpp"
#include "gyrator/passivity/aliased_disk.hpp"

#include "support/passivity_closed_forms.hpp"

namespace gyrator::passivity_tests {

/// c and r of (disk-1), term by term.
struct PlainDisk {
  Complex center;
  double radius = 0;
  double left_out = 0;  ///< bound of what the terms beyond the last one would change
};

/// What a device's terms tend to at high frequency: M + S A/(2 Re Z) in `reach`, its size in
/// `size`.
struct FarTerms {
  Complex reach = 0;
  double size = 0;
};

/// `terms` aliases on either side, one by one; for a whole delay the rest of the series at the
/// limit `far` by sum_n (w + n w_s)^-2 = (T/2)^2 / sin^2(wT/2).
inline PlainDisk sum_plainly(const KnownDevice& known, const Sampling& sampling, double omega,
                             int terms, const FarTerms& far = {}) {
  const double period = sampling.period.to_double();
  const double delay = sampling.delay.to_double();
  const double sampling_frequency = 2 * pi / period;
  const Complex hold = (1.0 - std::polar(1.0, -omega * period)) / period;
  PlainDisk disk;
  double weights = 0;
  // From the smallest to the largest, so that rounding stays that of the largest few.
  for (int n = terms; n >= 0; --n) {
    for (const int side : {1, -1}) {
      if (n == 0 && side < 0) continue;
      const double at = omega + side * n * sampling_frequency;
      PortForm form = known.at(Complex(0, at));
      const Complex path = form.sensor_path * form.actuation;
      const double half_over = 1 / (2 * form.impedance.real());
      const Complex k = hold * std::polar(1.0, -at * delay) / (Complex(0, at) * Complex(0, at));
      disk.center += k * (form.blocked_motion + path * half_over);
      disk.radius += std::abs(k * path) * half_over;
      weights += 1 / (at * at);
    }
  }
  const double sine = std::sin(omega * period / 2);
  const double rest = period * period / (4 * sine * sine) - weights;
  disk.center -= hold * std::polar(1.0, -omega * delay) * rest * far.reach;
  disk.radius += std::abs(hold) * rest * far.size;
  disk.left_out = std::abs(hold) * rest;
  return disk;
}

}  // namespace gyrator::passivity_tests
