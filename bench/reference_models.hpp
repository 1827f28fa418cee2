#pragma once

#include "gyrator/controllers/controller.hpp"
#include "gyrator/mechanics/device.hpp"

namespace gyrator::bench {

/// The RC-damped motor of examples/rc_display.json: 4 states with the position.
inline Device make_rc_display() {
  Device device;
  device.drive.motor = Motor{0.05, 1.5, 0.5e-3};
  device.drive.amplifier = CurrentAmplifier{};
  device.drive.damping = {RcDamping{5, 2200e-6}};
  device.mechanics.inertia = 2e-5;
  device.mechanics.damping = 1e-4;
  return device;
}

/// The same with a compliant transmission: 6 states.
inline Device make_compliant_display() {
  Device device = make_rc_display();
  device.mechanics.transmission = Transmission{20, 1e-3, 1e-5};
  return device;
}

}  // namespace gyrator::bench
