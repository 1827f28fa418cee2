#pragma once

#include "gyrator/cosim/simulation.hpp"

#include <optional>

namespace gyrator {

/// Rate-hardness of the first contact in a run [N/m, N.m/rad]: how fast the effort rises per
/// velocity of penetration, (N/s)/(m/s).
///   R = f(t_c + T)/(T v),  v = (x[k] - x[k-1])/T                                        (rate-1)
/// k is the first sample whose sensed position is above zero behind one that is not, t_c the
/// crossing between them (linear), f the opposing command less that of sample k-1, linear between
/// samples k and k+1. At an even velocity a wall has R = K + B/T with the one-sample difference,
/// wherever between samples the surface is crossed; a braking pulse adds g/T. None without a
/// contact, without the sample that follows it, and where R is negative: an effort that falls off
/// at the surface, or pulls into it, is no hardness. The trace must have every sample of an even
/// clock. Source: Lawrence et al. 2000, the ratio; the sampled form (rate-1) chosen here.
std::optional<double> find_rate_hardness(const Trace& trace, double period);

}  // namespace gyrator
