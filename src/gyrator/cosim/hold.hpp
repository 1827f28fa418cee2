#pragma once

#include <complex>

namespace gyrator {

/// Zero-order hold over the effort that it holds, without unit:
///   G(jw) = (1 - e^(-jwT))/(jwT) = e^(-jwT/2) sin(wT/2)/(wT/2)                          (hold-1)
/// w [rad/s], T period [s]; 1 for T = 0. It is the fundamental alone: the aliases are left out.
/// It is also a position's difference over the period, by the velocity: (1 - z^-1) x/T = G v.
std::complex<double> compute_normalized_hold(double omega, double period);

}  // namespace gyrator
