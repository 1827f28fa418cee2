#pragma once

#include "gyrator/passivity/stiffness_limit.hpp"

#include <vector>

namespace gyrator {

/// A wall as a point of the K-B plane.
struct WallPoint {
  double stiffness = 0;  ///< K [N/m, N.m/rad]
  double damping = 0;    ///< B [N.s/m, N.m.s/rad]
};

/// The walls K >= 0 that a criterion calls passive, as a closed polygon: along K = 0 from the
/// lowest to the highest virtual damping B and back along the largest stiffness.
struct PassiveWalls {
  std::vector<WallPoint> outline;  ///< counter-clockwise over (B, K), the first not repeated

  bool contains(const WallPoint& wall) const;

  /// The usual figure of merit of the K-B plot, the integral of K_max over B >= 0 [N^2.s/m^2].
  double area() const;
};

/// How far the true boundary lies from the polygon's sides, of the largest stiffness.
inline constexpr double outline_tolerance = 1e-3;

/// Finds the polygon: the range of B by bisection from B = 0, then the boundary at dampings that
/// are halved until the middle of every side is within outline_tolerance of the largest stiffness.
/// Corners lie on the limit itself; where the disk's gap |c|^2 - r^2 is not positive, D is concave
/// over (K, B), the region convex, and no side lies outside it.
/// `family` is that of the limits' controller.
/// Throws bad_input at "controller" where not even the bare device is passive and where the
/// criterion bounds stiffness or damping nowhere, as for a wave drive or an analog loop.
PassiveWalls trace_passive_walls(StiffnessLimits& limits, const LawFamily& family,
                                 Criterion criterion);

}  // namespace gyrator
