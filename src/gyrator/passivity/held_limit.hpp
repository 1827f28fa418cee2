#pragma once

#include "gyrator/passivity/stiffness_limit.hpp"

namespace gyrator {

/// The device's held impedance, if it has one.
const HeldImpedance* find_held_impedance(const Device& device);

/// Largest stiffness k of a held-impedance drive [N/m, N.m/rad] that leaves the device passive at
/// analog damping d. The loop acts continuously, so that neither period nor computation delay bound
/// it; what does is the drive between loop and shaft:
///   Re{Z_0 + A S G/(1 + G M)} >= 0 at every frequency,  G = F (k/(jw) + d)          (held-2)
/// Z_0, A, S, M of the device without the loop (port-1), F its low-pass. With one pole of time
/// constant tau in the whole loop, k tau <= b + d. Infinite for an ideal drive.
StiffnessLimit find_held_stiffness_limit(const Device& device, double damping);

}  // namespace gyrator
