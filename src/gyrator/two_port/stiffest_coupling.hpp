#pragma once

#include "gyrator/two_port/rendering_port.hpp"

#include <optional>
#include <vector>

namespace gyrator {

struct CouplingLimit {
  bool feasible = false;          ///< a vanishing stiffness meets the conditions at this damping
  double stiffness = 0;           ///< largest k [N/m, N.m/rad]; infinite where nothing bounds it
  double worst_frequency_hz = 0;  ///< where it is bounded; 0: towards zero
};

struct BestCoupling {
  double damping = 0;  ///< [N.s/m, N.m.s/rad]
  CouplingLimit limit;
};

/// The stiffest virtual coupling Z_vc = c + k/D between a device and any environment that keeps
/// Llewellyn's conditions at every frequency up to Nyquist, as direct rendering with
/// h22 = 1/Z_vc + V M P. Re h22 must reach what the device leaves,
///   Re(1/Z_vc) >= R,   R = max(0, (|p| + Re p)/(2 Re Z) - Re(V M P)),   p = -A P V S  (coupling-2)
/// With (virtual-1) 1/D = (h/2)(s - j q), q = cot(wh/2), s = -1 for explicit steps, else 1, and
/// x = k h/2, that is a quadratic in x,
///   R (1 + q^2) x^2 + s (2 R c - 1) x + c (R c - 1) <= 0,                           (coupling-3)
/// true from x = 0 (for R c <= 1) to its upper root; the lowest over all frequencies is the limit.
///
/// On a mass with damping b and an ideal drive, t the loop's whole lag, that is
///   k <= (b T + sqrt((b T)^2 + 4 b c t^2))/t^2                towards zero          (coupling-4)
///   c + k T/2 <= pi b (velocity sensed, without delay)        at Nyquist
/// With the position sensed t = T: for c = 0 k = 2 b/T, the wall of b > K T/2. With the velocity
/// t = T/2, and Nyquist allows 2 pi b/T: pi times as stiff, since half a sample of lag is left out.
/// A damper alone may be c = pi b, with the position sensed 1.904 b.
/// Holds for any device that is passive by itself; aliases left out. With Re Z <= 0 anywhere, none.
/// Source: the question is that of Adams and Hannaford 1999; solved here.
class StiffestCoupling {
 public:
  StiffestCoupling(const Device& device, const ComputedPath& path);

  /// Largest stiffness at a damping. Throws bad_input for a negative one.
  CouplingLimit find(double damping) const;

  /// Over every damping; none where no damping allows a coupling.
  std::optional<BestCoupling> find_best() const;

 private:
  struct Need {
    double omega = 0;
    double compliance = 0;  // R
  };
  Need need_at(double omega) const;
  double bound_at(const Need& need, double damping) const;

  mutable PortModel device_;
  ComputedPath path_;
  std::vector<double> grid_;
  std::vector<Need> needs_;
};

/// The stiffest coupling of a proxy as it is, tool and contact included: the largest stiffness in
/// place of the coupling's own up to which its two-port is absolutely stable, to 1e-5. 0 where not
/// even a vanishing one is; none where every one is, or the scene has no tool.
std::optional<double> find_stiffest_proxy_coupling(const Device& device,
                                                   const RenderedScene& scene);

}  // namespace gyrator
