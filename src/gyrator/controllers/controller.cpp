#include "gyrator/controllers/controller.hpp"

namespace gyrator {

DiscreteStateSpace make_contact_law(const Controller& controller, double period) {
  const auto* wall = std::get_if<VirtualWall>(&controller);
  return wall ? make_wall_law(*wall, period) : make_gain(0);
}

std::optional<DiscreteStateSpace> find_linear_law(const Controller& controller, double period) {
  const auto* wall = std::get_if<VirtualWall>(&controller);
  if (wall && wall->unilateral) return std::nullopt;
  return make_contact_law(controller, period);
}

RunningController::RunningController(const Controller& controller, double period) {
  if (const auto* wall = std::get_if<VirtualWall>(&controller)) wall_.emplace(*wall, period);
}

}  // namespace gyrator
