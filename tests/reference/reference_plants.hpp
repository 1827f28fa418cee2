#pragma once

#include "gyrator/controllers/sampling.hpp"
#include "gyrator/mechanics/device.hpp"

namespace gyrator::reference {

/// m, b in linear motion under an ideal drive.
inline Device make_plant(double inertia, double damping) {
  Device device;
  device.motion = Motion::linear;
  device.mechanics.inertia = inertia;
  device.mechanics.damping = damping;
  return device;
}

/// P3, the public teaching plant of the reference cases: 0.04 kg, 0.8 N.s/m.
inline Device make_p3() {
  return make_plant(0.04, 0.8);
}

/// A period in whole milliseconds, and a delay in seconds.
inline Sampling at(int milliseconds, const Rational& delay = 0) {
  return {Rational(milliseconds, 1000), delay};
}

}  // namespace gyrator::reference
