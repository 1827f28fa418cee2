#pragma once

#include <complex>

namespace gyrator {

/// A first-order lag behind a delay, driven by a command that is held between ticks:
///   dy/dt = w_b (u(t - d) - y),   u(t) = u_k for k T <= t < (k + 1) T                (lag-1)
struct HeldLag {
  double time_constant = 0;  ///< 1/w_b [s]; -3 dB at w_b/(2 pi) Hz
  double delay = 0;          ///< d [s]
  double tick = 1e-4;        ///< T [s]
};

/// y at the ticks per sine of the command at the ticks, exactly. With n = floor(d/T), e = d - n T,
/// z = e^{jwT} and a(t) = e^{-w_b t}
///   Y/U = [(a(T - e) - a(T)) z^{-n-1} + (1 - a(T - e)) z^{-n}]/(z - a(T))            (lag-2)
/// Half a tick of what looks like delay is the hold's.
std::complex<double> compute_held_lag(const HeldLag& lag, double frequency_hz);

/// dy/dt at the ticks per sine of y there [1/s], where `age` ticks old is the command that acts at
/// the instant itself:
///   Y'/Y = w_b (z^{-age}/(Y/U) - 1)                                                  (lag-3)
/// dy/dt jumps with every new command, so this is not jw: the images of the sine around the tick's
/// frequency fold onto it, by up to a fifth of it.
std::complex<double> compute_held_slope(const HeldLag& lag, double frequency_hz, int age);

/// The sine of y itself, without the images of the held command, per that of its samples:
///   Y_mean/Y = (1 - z^{-1})/(jwT) e^{-jwd}/(1 + jw/w_b)/(Y/U)                        (lag-4)
/// A load that integrates y, as an inertia does, sees this one.
std::complex<double> compute_held_mean(const HeldLag& lag, double frequency_hz);

/// The age for an instant just before the tick's new command: n + 1.
int find_acting_age(const HeldLag& lag);

}  // namespace gyrator
