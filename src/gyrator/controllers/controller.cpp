#include "gyrator/controllers/controller.hpp"

#include <algorithm>

namespace gyrator {
namespace {

// Direct, proxy, equivalent impedance: a deformable object, touched in one way or another.
template <class T>
concept RendersObject = requires(const T& law) {
  law.scene;
};

// What a criterion makes of each law. One overload per law of the list.

DiscreteStateSpace contact_law(const NoController& /*none*/, double /*period*/) {
  return make_gain(0);
}
DiscreteStateSpace contact_law(const VirtualWall& wall, double period) {
  return make_wall_law(wall, period);
}
DiscreteStateSpace contact_law(const WaveController& wave, double period) {
  return make_wave_law(wave, period);
}
DiscreteStateSpace contact_law(const VirtualCoupling& coupling, double period) {
  return make_coupling_law(coupling, period);
}
DiscreteStateSpace contact_law(const RendersObject auto& rendering, double period) {
  return make_deformable_law(rendering, period);
}

DiscreteStateSpace contact_law(const PredictiveWall& wall, double period) {
  return make_predictive_law(wall, period);
}

bool is_linear(const NoController& /*none*/) {
  return true;
}
bool is_linear(const VirtualWall& wall) {
  return !wall.unilateral && is_linear(wall.velocity);
}
bool is_linear(const WaveController& wave) {
  const auto* behind = std::get_if<WaveWall>(&wave.environment);
  return !(behind && behind->unilateral);
}

bool is_linear(const VirtualCoupling& coupling) {
  return !(coupling.wall && coupling.wall->unilateral) && !has_own_rate(coupling.update);
}
bool is_linear(const RendersObject auto& rendering) {
  return !rendering.scene.unilateral && !has_own_rate(rendering.scene.update);
}
bool is_linear(const EquivalentImpedance& rendering) {
  return !rendering.scene.unilateral;  // its update changes nothing that is felt in contact
}
bool is_linear(const PredictiveWall& wall) {
  return !wall.unilateral && wall.device.constant_effort == 0;
}

void stay_in_contact(NoController& /*none*/) {}
void stay_in_contact(VirtualWall& wall) {
  wall.unilateral = wall.no_pull = false;
}
void stay_in_contact(WaveController& wave) {
  if (auto* wall = std::get_if<WaveWall>(&wave.environment)) wall->unilateral = false;
}
void stay_in_contact(VirtualCoupling& coupling) {
  if (coupling.wall) coupling.wall->unilateral = false;
}
void stay_in_contact(RendersObject auto& rendering) {
  rendering.scene.unilateral = false;
}

void stay_in_contact(PredictiveWall& wall) {
  wall.unilateral = false;
  wall.device.constant_effort = 0;
}

std::optional<WallValues> wall_values(const NoController& /*none*/) {
  return std::nullopt;
}
std::optional<WallValues> wall_values(const VirtualWall& wall) {
  return WallValues{wall.stiffness, wall.damping};
}
std::optional<WallValues> wall_values(const WaveController& wave) {
  if (const auto* wall = std::get_if<WaveWall>(&wave.environment))
    return WallValues{wall->stiffness, wall->damping};
  return std::nullopt;
}
std::optional<WallValues> wall_values(const VirtualCoupling& /*coupling*/) {
  return std::nullopt;  // the wall is felt through coupling and tool
}
std::optional<WallValues> wall_values(const RendersObject auto& /*rendering*/) {
  return std::nullopt;
}

std::optional<WallValues> wall_values(const PredictiveWall& wall) {
  return WallValues{wall.stiffness, wall.damping};
}

// The energies of the law in closed form, for a passivity control around it; none for most.

template <class T>
std::optional<ReferenceWall> reference_wall(const T& /*law*/) {
  return std::nullopt;
}
std::optional<ReferenceWall> reference_wall(const VirtualWall& wall) {
  // Negative damping is a source: the reference of what should be passive has none.
  return ReferenceWall{wall.stiffness, std::max(wall.damping, 0.0), wall.unilateral, wall.no_pull};
}
std::optional<ReferenceWall> reference_wall(const PredictiveWall& wall) {
  return ReferenceWall{wall.stiffness, wall.damping, wall.unilateral};
}

// H(z) of a wrapper, from command to command; none where it is not linear.

std::optional<DiscreteStateSpace> linear_wrapper(const PreEmphasis& stage) {
  return stage.filter;
}
template <class T>
std::optional<DiscreteStateSpace> linear_wrapper(const T& /*not linear*/) {
  return std::nullopt;
}

bool is_nonlinear(const Wrapper& wrapper) {
  return !std::visit([](const auto& w) { return linear_wrapper(w); }, wrapper);
}

}  // namespace

DiscreteStateSpace make_output_law(const Controller& controller) {
  DiscreteStateSpace output = make_gain(1);
  for (const auto& wrapper : controller.wrappers) {
    if (const auto law = std::visit([](const auto& w) { return linear_wrapper(w); }, wrapper))
      output = in_series(output, *law);
  }
  return output;
}

DiscreteStateSpace make_contact_law(const Controller& controller, double period) {
  const DiscreteStateSpace law =
      std::visit([&](const auto& l) { return contact_law(l, period); }, controller.law);
  return controller.wrappers.empty() ? law : in_series(law, make_output_law(controller));
}

std::optional<DiscreteStateSpace> find_linear_law(const Controller& controller, double period) {
  if (!std::visit([](const auto& l) { return is_linear(l); }, controller.law)) return std::nullopt;
  if (has_nonlinear_wrapper(controller)) return std::nullopt;
  return make_contact_law(controller, period);
}

Controller keep_in_contact(Controller controller) {
  std::visit([](auto& law) { stay_in_contact(law); }, controller.law);
  std::erase_if(controller.wrappers, is_nonlinear);
  return controller;
}

bool has_nonlinear_wrapper(const Controller& controller) {
  return std::any_of(controller.wrappers.begin(), controller.wrappers.end(), is_nonlinear);
}

bool reads_position(const Law& law) {
  return !std::holds_alternative<NoController>(law) && !std::holds_alternative<WaveController>(law);
}

bool has_contact(const Law& law) {
  const auto is_surface = [](const auto& l) {
    if constexpr (requires { l.unilateral; }) return l.unilateral;
    return false;
  };
  return std::visit(is_surface, law);
}

std::optional<WallValues> find_wall_values(const Controller& controller) {
  return std::visit([](const auto& law) { return wall_values(law); }, controller.law);
}

RunningController::RunningController(const Controller& controller, double period, double position)
    : law_(make_law(controller.law, period, position)) {
  for (const auto& wrapper : controller.wrappers)
    wrappers_.push_back(make_wrapper(wrapper, controller.law, period));
}

RunningController::RunningLaw RunningController::make_law(const Law& law, double period,
                                                          double position) {
  if (const auto* wall = std::get_if<VirtualWall>(&law))
    return VirtualWallController(*wall, period);
  if (const auto* wave = std::get_if<WaveController>(&law))
    return RunningWaveController(*wave, period, position);
  if (const auto* coupling = std::get_if<VirtualCoupling>(&law))
    return RunningVirtualCoupling(*coupling, period);
  if (const auto* direct = std::get_if<DirectRendering>(&law))
    return RunningHeldRendering(*direct, period);
  if (const auto* proxy = std::get_if<ProxyRendering>(&law))
    return RunningHeldRendering(*proxy, period);
  if (const auto* equivalent = std::get_if<EquivalentImpedance>(&law))
    return RunningEquivalentImpedance(*equivalent, period);
  if (const auto* wall = std::get_if<PredictiveWall>(&law))
    return RunningPredictiveWall(*wall, period);
  return Idle{};
}

RunningController::RunningWrapper RunningController::make_wrapper(const Wrapper& wrapper,
                                                                  const Law& law, double period) {
  if (const auto* stage = std::get_if<PreEmphasis>(&wrapper)) return RunningPreEmphasis(*stage);
  if (const auto* control = std::get_if<PassivityControl>(&wrapper)) {
    const auto wall = std::visit([](const auto& l) { return reference_wall(l); }, law);
    return RunningPassivityControl(*control, wall, period);
  }
  const auto course = [&](const auto& effect) -> std::vector<double> {
    if constexpr (requires { make_effect_course(effect, period); })
      return make_effect_course(effect, period);
    return {};
  };
  return RunningContactEffect(std::visit(course, wrapper), period);
}

namespace {

// A law or wrapper that has something to tell says so by these two members.
template <class T>
concept TellsSignals = requires(const T& running, std::vector<std::string>& names, double* value) {
  running.append_signal_names(names);
  value = running.write_signals(value);
};

}  // namespace

std::vector<std::string> RunningController::signal_names() const {
  std::vector<std::string> names;
  const auto append = [&](const auto& running) {
    if constexpr (TellsSignals<std::decay_t<decltype(running)>>) running.append_signal_names(names);
  };
  std::visit(append, law_);
  for (const auto& wrapper : wrappers_) std::visit(append, wrapper);
  return names;
}

void RunningController::read_signals(std::vector<double>& values) const {
  double* next = values.data();
  const auto write = [&](const auto& running) {
    if constexpr (TellsSignals<std::decay_t<decltype(running)>>) next = running.write_signals(next);
  };
  std::visit(write, law_);
  for (const auto& wrapper : wrappers_) std::visit(write, wrapper);
}

}  // namespace gyrator
