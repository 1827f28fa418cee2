#pragma once

#include <optional>

namespace gyrator {

/// Dry friction at the motor's shaft: the effort f that it exerts on a shaft of velocity v,
///   v != 0:  f = -sgn(v) (f_c + (f_s - f_c) max(0, 1 - |v|/v_s))                (friction-1)
///   v  = 0:  f = whatever keeps it so, |f| <= f_s                               (friction-2)
/// f_c sliding level, f_s >= f_c breakaway effort [N, N.m], v_s Stribeck velocity [m/s, rad/s]; for
/// v_s = 0 the sliding level is f_c at once. Friction that falls along a line instead of the usual
/// exponential keeps the plant affine in every mode, so that each engine solves the same law.
/// Source: Coulomb's law with stiction (Karnopp 1985) and Stribeck's fall; Armstrong-Hélouvry,
/// Dupont and Canudas de Wit 1994.
struct DryFriction {
  double sliding = 0, breakaway = 0;
  double stribeck_velocity = 0;
};

/// Elastic stops at the operator port: the effort on a port that is delta >= 0 beyond one is
///   e = max(0, k delta + d ddelta/dt), back towards the range                        (stop-1)
/// k stiffness [N/m, N.m/rad], d damping [N.s/m, N.m.s/rad]. A stop never pulls; where the port
/// leaves faster than the damper lets the spring follow, the spring's energy k delta^2/2 turns into
/// heat as delta falls:
///   heat = d (ddelta/dt)^2 in contact, -k delta ddelta/dt while e = 0 and delta > 0  (stop-2)
/// which makes it passive. Source: Kelvin–Voigt contact without adhesion (Hunt and Crossley 1975
/// discuss its force at impact, which jumps to d ddelta/dt).
struct HardStops {
  std::optional<double> lower, upper;  ///< position of the port [m, rad]
  double stiffness = 0, damping = 0;
};

}  // namespace gyrator
