#pragma once

#include "gyrator/mechanics/device.hpp"

#include <optional>
#include <vector>

namespace gyrator {

/// What a lossless operator is to be at one frequency.
struct WantedReactance {
  double omega = 0;      ///< [rad/s], positive
  double reactance = 0;  ///< Im Σ(j omega) [N.s/m, N.m.s/rad]
};

/// A lossless operator that has all the wanted reactances: inertia and spring for the first, and a
/// resonator hung beside each of the others,
///   X(w) = M w - k/w + sum_i k_i w/(w_i^2 - w^2),   M, k, k_i >= 0                (foster-1)
/// tuned above the point where the reactance is to be raised and below it where lowered, by
/// `nearness` times the distance to the next point; nearer where that takes a negative k_i. `both`
/// is how much of the first reactance's size inertia and spring hold against each other. None if no
/// such operator was found. Source: Foster 1924 (every rising X with such poles is lossless).
std::optional<MassSpringDamper> interpolate_reactances(const std::vector<WantedReactance>& wanted,
                                                       double nearness, double both);

}  // namespace gyrator
