#pragma once

#include <complex>

namespace gyrator {

/// Virtual damping of a law at one frequency [N.s/m, N.m.s/rad]:
///   b_v(w) = T / (2 (1 - cos wT)) Re{(e^(-jwT) - 1) H}                             (vd-1)
///          = T / (2 sin(wT/2)) Im{e^(-jwT/2) H}
/// (second form: no difference of nearly equal numbers at low frequency). `law` is H at e^(jwT)
/// with the computation delay's factor; omega in rad/s, 0 < omega <= pi/T. For a spring alone
/// b_v = -K T/2 at every frequency.
/// Source: Colgate and Schenkel 1997, [8.2]; the sum with Re Z is [8.46].
double compute_virtual_damping(double omega, double period, std::complex<double> law);

}  // namespace gyrator
