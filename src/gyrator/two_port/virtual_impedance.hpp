#pragma once

#include "gyrator/controllers/virtual_chain.hpp"

#include <complex>

namespace gyrator {

/// Impedances [N.s/m, N.m.s/rad] of what a computer moves on by steps h, at one frequency:
///   explicit                  mass m (z - 1)/h,       spring k h/(z - 1)            (virtual-1)
///   semi-implicit, implicit   mass m (z - 1)/(h z),   spring k h z/(z - 1)
/// and a damper c; z = e^(jwh), h = 0 for continuous time. An explicit mass and an explicit spring
/// have negative real parts, -m (1 - cos wh)/h and -k h/2, the others positive ones.
///
/// As printed in the paper, a semi-implicit mass pairs an effort with the velocity that it makes.
/// The sums of such impedances are zero at the poles of implicit steps; at those of semi-implicit
/// steps, where a spring's effort is that of the step before, the mass is m (z - 1)/h beside the
/// spring k h z/(z - 1). Whether what is computed is stable by itself is therefore asked of the
/// scheme's steps (compute_virtual_radius), not of these.
/// Source: Kim and Lee 2017, section 4; Brown and Colgate 1998 for the schemes.
class VirtualElements {
 public:
  VirtualElements(double omega, double step, Integration integration);

  std::complex<double> mass(double m) const { return m * rate_; }
  std::complex<double> spring(double k) const { return k * integral_; }
  std::complex<double> link(const SpringDamper& law) const {
    return law.damping + spring(law.stiffness);
  }
  /// A body with its damping, stiffness and damping to ground.
  std::complex<double> body(double inertia, const SpringDamper& to_ground) const {
    return mass(inertia) + link(to_ground);
  }

 private:
  std::complex<double> rate_, integral_;
};

/// Spectral radius of a body on a spring and damper, moved on by steps h of the scheme:
///   explicit       m (z - 1)^2 + c h (z - 1)   + k h^2     = 0                      (virtual-2)
///   semi-implicit  m (z - 1)^2 + c h (z - 1)   + k h^2 z   = 0
///   implicit       m (z - 1)^2 + c h z (z - 1) + k h^2 z^2 = 0
/// Inertia zero: of spring and damper alone, pushed by an effort.
double compute_virtual_radius(double inertia, const SpringDamper& to_ground, double step,
                              Integration integration);

}  // namespace gyrator
