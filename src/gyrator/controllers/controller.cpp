#include "gyrator/controllers/controller.hpp"

namespace gyrator {

DiscreteStateSpace make_contact_law(const Controller& controller, double period) {
  if (const auto* wave = std::get_if<WaveController>(&controller))
    return make_wave_law(*wave, period);
  const auto* wall = std::get_if<VirtualWall>(&controller);
  return wall ? make_wall_law(*wall, period) : make_gain(0);
}

std::optional<DiscreteStateSpace> find_linear_law(const Controller& controller, double period) {
  const auto* wall = std::get_if<VirtualWall>(&controller);
  if (wall && wall->unilateral) return std::nullopt;
  if (const auto* wave = std::get_if<WaveController>(&controller)) {
    const auto* behind = std::get_if<WaveWall>(&wave->environment);
    if (behind && behind->unilateral) return std::nullopt;
  }
  return make_contact_law(controller, period);
}

Controller keep_in_contact(Controller controller) {
  if (auto* wall = std::get_if<VirtualWall>(&controller)) wall->unilateral = wall->no_pull = false;
  if (auto* wave = std::get_if<WaveController>(&controller)) {
    if (auto* wall = std::get_if<WaveWall>(&wave->environment)) wall->unilateral = false;
  }
  return controller;
}

std::optional<WallValues> find_wall_values(const Controller& controller) {
  if (const auto* wall = std::get_if<VirtualWall>(&controller))
    return WallValues{wall->stiffness, wall->damping};
  if (const auto* wave = std::get_if<WaveController>(&controller)) {
    if (const auto* wall = std::get_if<WaveWall>(&wave->environment))
      return WallValues{wall->stiffness, wall->damping};
  }
  return std::nullopt;
}

RunningController::RunningController(const Controller& controller, double period, double position) {
  if (const auto* wall = std::get_if<VirtualWall>(&controller)) wall_.emplace(*wall, period);
  if (const auto* wave = std::get_if<WaveController>(&controller))
    wave_.emplace(*wave, period, position);
}

}  // namespace gyrator
