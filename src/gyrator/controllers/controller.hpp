#pragma once

#include "gyrator/controllers/virtual_wall.hpp"
#include "gyrator/controllers/wave_controller.hpp"

#include <optional>
#include <variant>

namespace gyrator {

/// No controller: the command stays zero.
struct NoController {};

/// The closed list of controllers, as configuration.
using Controller = std::variant<NoController, VirtualWall, WaveController>;

/// H(z) of the controller, from the sampled signal (position, or the wave's integral) to opposing
/// effort; none for a law that is not linear (a unilateral wall). `period` in s.
std::optional<DiscreteStateSpace> find_linear_law(const Controller& controller, double period);

/// The linear law that a criterion judges: H itself, and for a unilateral wall the wall that it
/// is while in contact.
DiscreteStateSpace make_contact_law(const Controller& controller, double period);

/// The controller that it is while in contact and free to pull: what linear criteria speak of.
Controller keep_in_contact(Controller controller);

/// Stiffness and virtual damping of the wall that the controller renders, from the position or
/// behind a wave line; none without a wall.
struct WallValues {
  double stiffness = 0;  ///< [N.m/rad, N/m]
  double damping = 0;    ///< [N.m.s/rad, N.s/m]
};
std::optional<WallValues> find_wall_values(const Controller& controller);

/// A controller while it runs: sampled signal in, command out. Allocates only when constructed.
class RunningController {
 public:
  /// `position`: where an environment that keeps a position of its own starts [m, rad].
  RunningController(const Controller& controller, double period, double position = 0);

  double step(double y) {
    if (wall_) return wall_->step(y);
    return wave_ ? wave_->step(y) : 0.0;
  }

 private:
  std::optional<VirtualWallController> wall_;
  std::optional<RunningWaveController> wave_;
};

}  // namespace gyrator
