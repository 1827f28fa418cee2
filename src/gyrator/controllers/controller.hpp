#pragma once

#include "gyrator/controllers/virtual_wall.hpp"

#include <optional>
#include <variant>

namespace gyrator {

/// No controller: the command stays zero.
struct NoController {};

/// The closed list of controllers, as configuration.
using Controller = std::variant<NoController, VirtualWall>;

/// H(z) of the controller, from sampled position to opposing effort; none for a law that is not
/// linear (a unilateral wall). `period` in s.
std::optional<DiscreteStateSpace> find_linear_law(const Controller& controller, double period);

/// The linear law that a criterion judges: H itself, and for a unilateral wall the wall that it
/// is while in contact.
DiscreteStateSpace make_contact_law(const Controller& controller, double period);

/// A controller while it runs: sampled position in, command out. Allocates only when constructed.
class RunningController {
 public:
  RunningController(const Controller& controller, double period);

  double step(double y) { return wall_ ? wall_->step(y) : 0.0; }

 private:
  std::optional<VirtualWallController> wall_;
};

}  // namespace gyrator
