#include "gyrator/lanes/lane_design.hpp"

#include "gyrator/circuits/state_space.hpp"
#include "gyrator/lanes/lane_program.hpp"

#include <cmath>
#include <limits>

#include <fmt/core.h>

namespace gyrator {
namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();
constexpr Eigen::Index most_lane_states = 64;
constexpr std::int64_t most_lane_delay = 10000;  // periods: commands under way are kept for each

bool is_zero(const Eigen::RowVectorXd& row) {
  return row.size() == 0 || row.isZero(0);
}

std::string find_plant_obstacle(const Plant& plant) {
  if (plant.nonlinear)
    return fmt::format("the element {} is not linear", plant.nonlinear->named_by);
  if (plant.states() < 1 || plant.states() > most_lane_states)
    return fmt::format("the plant has {} states, lanes take 1 to {}", plant.states(),
                       most_lane_states);
  if (!is_zero(plant.sensor_position.input) || !is_zero(plant.port_velocity.input) ||
      !is_zero(plant.port_position.input))
    return "a signal of the plant jumps with the command";
  return {};
}

// A signal that is one state times a factor becomes that state, counted in the signal's own unit:
// the kernel reads it then as it is.
void scale_to_signal(LanePlant& lane, const Eigen::RowVectorXd& signal) {
  Eigen::Index at = 0;
  if ((signal.array() != 0).count() != 1) return;
  signal.cwiseAbs().maxCoeff(&at);
  const double factor = signal(at);
  if (factor == 1) return;
  lane.propagate.row(at) *= factor;
  lane.propagate.col(at) /= factor;
  lane.scale(at) *= factor;
  for (auto* row : {&lane.sensed, &lane.position, &lane.velocity}) (*row)(at) /= factor;
}

}  // namespace

LanePlant make_lane_plant(const Plant& plant, const Sampling& sampling) {
  if (const std::string obstacle = find_plant_obstacle(plant); !obstacle.empty())
    throw Error(ErrorCode::bad_input, "model", obstacle);
  LanePlant lane;
  lane.delay = split_delay(sampling);
  lane.plant = plant;
  lane.sensed = plant.sensor_position.state;
  lane.position = plant.port_position.state;
  lane.velocity = plant.port_velocity.state;
  lane.largest_push = plant.B.col(1).cwiseAbs().maxCoeff();
  const Eigen::Index n = plant.states();
  lane.propagate.resize(n, n + 3);
  const HeldStep second = discretize_held(plant.A, plant.B, lane.delay.period - lane.delay.rest);
  if (lane.delay.rest > 0) {
    const HeldStep first = discretize_held(plant.A, plant.B, lane.delay.rest);
    lane.propagate << second.phi * first.phi, second.phi * first.gamma.col(0), second.gamma.col(0),
        second.phi * first.gamma.col(1) + second.gamma.col(1);
  } else {
    lane.propagate << second.phi, Eigen::VectorXd::Zero(n), second.gamma.col(0),
        second.gamma.col(1);
  }
  lane.scale = Eigen::VectorXd::Ones(n);
  scale_to_signal(lane, plant.sensor_position.state);
  scale_to_signal(lane, Eigen::RowVectorXd(lane.velocity));
  return lane;
}

std::optional<LaneLaw> find_lane_law(const Controller& controller, double period) {
  if (std::holds_alternative<NoController>(controller.law) && controller.wrappers.empty())
    return LaneLaw{make_gain(0), -infinity, -infinity, Eigen::VectorXd(0)};
  const auto* wall = std::get_if<VirtualWall>(&controller.law);
  if (!wall || !controller.wrappers.empty()) return std::nullopt;
  const auto velocity =
      find_linear_law(VirtualWall{.damping = 1, .velocity = wall->velocity}, period);
  if (!velocity) return std::nullopt;
  LaneLaw lane{make_wall_law(*wall, period), -infinity, -infinity, {}};
  lane.settled_at_one = lane.law.settled_state(1);
  if (wall->unilateral) {
    lane.contact_threshold = 0;
    if (wall->no_pull) lane.least_effort = 0;
  }
  return lane;
}

std::string find_lane_obstacle(const Plant& plant, const Controller& controller,
                               const LaneScene& scene) {
  if (std::string obstacle = find_plant_obstacle(plant); !obstacle.empty()) return obstacle;
  if (scene.sampling.jitter > Rational(0)) return "the sampling clock jitters";
  if (split_delay(scene.sampling).whole > most_lane_delay)
    return fmt::format("the delay is longer than {} periods", most_lane_delay);
  const auto law = find_lane_law(controller, scene.sampling.period.to_double());
  if (!law) return "the controller is more than a wall with a linear velocity";
  if (law->law.states() > most_lane_states - 1)
    return fmt::format("the controller has {} states, lanes take up to {}", law->law.states(),
                       most_lane_states - 1);
  return {};
}

}  // namespace gyrator
