#pragma once

#include "gyrator/amplifiers/experiment.hpp"
#include "gyrator/mechanics/device.hpp"

namespace gyrator {

/// How large the excitations of a tuning may be [A in current mode, V in voltage mode]: no more
/// than `current` [A] flows, and the terminal voltage stays below 0.4 of its limit and the speed
/// below half of its own, also on the way from rest. The drive is one of make_tuned_device, the
/// shaft free.

/// Of a sine u = a sin(2 pi f t). With Z_w = R + s L, load Z_l = s J + b and K, all at s = 2 pi j
/// f,
///   i = min(current, 0.4 V_max/(|Z_w| + 2 K^2/|Z_l|), 0.5 w_max |Z_l|/(2 K))
///   a = i, or by voltage i |Z_w - R_c + K^2/Z_l|                                  (amplitude-1)
/// R_c cancelled resistance, V_max and w_max the bench's limits; a motor from rest comes to at most
/// twice the speed of the steady sine.
double find_sine_amplitude(const Device& device, const BenchLimits& limits, DriveMode mode,
                           double current, double frequency_hz);

/// Of a constant command that lasts `duration` [s]. With the speed
///   w = min(0.4 V_max/K, 0.5 w_max)
///   a = min(current, w J/(K duration)), or by voltage min(current (R - R_c), w K) (amplitude-2)
/// The motor stands at first: its whole voltage drives its current then.
double find_push_amplitude(const Device& device, const BenchLimits& limits, DriveMode mode,
                           double current, double duration);

}  // namespace gyrator
