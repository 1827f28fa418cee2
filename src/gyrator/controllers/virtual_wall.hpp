#pragma once

#include "gyrator/controllers/discrete_state_space.hpp"
#include "gyrator/controllers/running_velocity_estimator.hpp"

namespace gyrator {

/// A spring and damper computed from the sampled position y; its effort opposes the motion:
///   effort[k] = K y[k] + B v[k],   command = -effort                             (wall-2)
/// K [N/m, N.m/rad], B [N.s/m, N.m.s/rad], v from the velocity estimator. A unilateral wall is
/// active for y > 0 only, and may pull while inside unless `no_pull`.
/// Bilateral: H(z) = K + B V(z) with the estimator's V(z)                          [8.3]
struct VirtualWall {
  double stiffness = 0;
  double damping = 0;
  VelocityEstimator velocity = DifferenceEstimator{};
  bool unilateral = false;
  bool no_pull = false;
};

/// H(z) of the bilateral wall as one discrete state space, from position to opposing effort. Throws
/// bad_input for a velocity estimator that is not linear: no H(z) exists, whatever B.
DiscreteStateSpace make_wall_law(const VirtualWall& wall, double period);

/// The running wall. Velocity is zero at the first sample. `step` allocates nothing.
class VirtualWallController {
 public:
  VirtualWallController(const VirtualWall& wall, double period);

  /// Command for the sampled position y.
  double step(double y) {
    const double effort = wall_.stiffness * y + wall_.damping * velocity_.step(y);
    if (!wall_.unilateral) return -effort;
    if (y <= 0 || (wall_.no_pull && effort < 0)) return 0;
    return -effort;
  }

 private:
  VirtualWall wall_;
  RunningVelocityEstimator velocity_;
};

}  // namespace gyrator
