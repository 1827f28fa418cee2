#pragma once

#include "gyrator/twin/simulated_amplifier.hpp"

namespace gyrator {

/// A small motor with neither noise nor friction, whose winding stays as warm as it is.
inline TwinDevice make_plain_twin() {
  TwinDevice twin;
  Device& device = twin.device;
  device.drive.motor = Motor{0.05, 1.5, 0.5e-3};
  device.drive.amplifier = CurrentAmplifier{.bandwidth_hz = 1000};
  device.mechanics.inertia = 2e-5;
  device.mechanics.damping = 1e-4;
  twin.thermal = {8, 1e12};
  return twin;
}

}  // namespace gyrator
