#include "gyrator/controllers/virtual_wall.hpp"

namespace gyrator {

DiscreteStateSpace make_wall_law(const VirtualWall& wall, double period) {
  return in_parallel(make_gain(wall.stiffness),
                     scaled(make_velocity_law(wall.velocity, period), wall.damping));
}

VirtualWallController::VirtualWallController(const VirtualWall& wall, double period)
    : wall_(wall), velocity_(wall.velocity, period) {}

}  // namespace gyrator
