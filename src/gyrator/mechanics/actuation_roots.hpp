#pragma once

#include "gyrator/mechanics/device.hpp"

#include <complex>
#include <vector>

namespace gyrator {

/// Poles and zeros [rad/s] of the drive's actuation path, from the command to the effort on the
/// blocked motor shaft, and so what a command is delayed and weakened by on its way:
///   A_0(s) = prod (1 - s/z_j) / prod (1 - s/p_i),   A_0(0) = 1                  (act-1)
/// Complex ones come in conjugate pairs. Pairs that cancel are left out. Behind a compliant
/// transmission the port's A has the transmission's resonance as well; it is not part of A_0.
/// Throws bad_input and numerical as build_device_network() and build_plant() do.
struct ActuationRoots {
  std::vector<std::complex<double>> poles, zeros;
};
ActuationRoots find_actuation_roots(const Device& device);

}  // namespace gyrator
