#pragma once

#include "gyrator/controllers/controller.hpp"

#include <cstddef>
#include <string>
#include <utility>
#include <variant>
#include <vector>

namespace gyrator::testing {

struct NamedEstimator {
  std::string name;
  VelocityEstimator estimator;
};

/// Every kind of velocity estimator, for positions of millimetres at 1 kHz.
inline std::vector<NamedEstimator> make_estimator_list() {
  return {
      {"difference", DifferenceEstimator{}},
      {"difference over 8", DifferenceEstimator{8}},
      {"filtered difference", FilteredDifferenceEstimator{50}},
      {"butterworth", ButterworthEstimator{2, 100}},
      {"foaw end", AdaptiveWindowEstimator{1e-5, 16, WindowFit::end}},
      {"foaw best", AdaptiveWindowEstimator{1e-5, 32, WindowFit::best}},
      {"levant", LevantEstimator{40}},
  };
}

struct NamedController {
  std::string name;
  Controller controller;
};

inline SlowUpdate make_slow_update() {
  return {.period = Rational(1, 30), .delay = Rational(1, 100), .loss = 0.1};
}

/// A tool of 0.1 kg behind a coupling, free or against a wall.
inline VirtualCoupling make_test_coupling(Integration integration) {
  VirtualCoupling law;
  law.coupling = {2e3, 5};
  law.tool_inertia = 0.1;
  law.tool_damping = 0.1;
  law.integration = integration;
  return law;
}

inline VirtualCoupling make_test_coupling(Integration integration, bool unilateral) {
  VirtualCoupling law = make_test_coupling(integration);
  law.wall = ToolWall{.law = {2e3, 5}, .position = 0, .unilateral = unilateral};
  return law;
}

/// Half a kilogram on a soft spring that a hand can push away.
inline DeformableScene make_test_scene(Integration integration, bool unilateral = true) {
  DeformableScene scene;
  scene.object = {0.5, {300, 2}, 0};
  scene.contact = {300, 2};
  scene.unilateral = unilateral;
  scene.integration = integration;
  return scene;
}

inline DeformableScene make_slow_scene(Integration integration, int substeps = 1) {
  DeformableScene scene = make_test_scene(integration);
  scene.substeps = substeps;
  scene.update = make_slow_update();
  return scene;
}

inline void add_walls(std::vector<NamedController>& list) {
  const auto add = [&](const char* name, const Law& law) {
    list.push_back({name, Controller(law, {})});
  };
  add("spring", VirtualWall{.stiffness = 20e3});
  add("spring and damper", VirtualWall{.stiffness = 20e3, .damping = 100});
  add("negative damper", VirtualWall{.stiffness = 2e3, .damping = -10});
  add("unilateral wall", VirtualWall{.stiffness = 90e3, .unilateral = true});
  add("unilateral wall without pull",
      VirtualWall{.stiffness = 20e3, .damping = 200, .unilateral = true, .no_pull = true});
  for (const NamedEstimator& named : make_estimator_list()) {
    const VirtualWall wall{.stiffness = 5e3, .damping = 200, .velocity = named.estimator};
    add(("damper with " + named.name).c_str(), wall);
  }
}

inline void add_predictive_walls(std::vector<NamedController>& list) {
  const PredictiveWall wall{
      .stiffness = 20e3, .damping = 10, .device = {.inertia = 0.5, .damping = 2}};
  PredictiveWall half_sample = wall;
  half_sample.dead_beat = false;
  PredictiveWall plain = half_sample;
  plain.prediction = PredictiveWall::Prediction::none;
  PredictiveWall bilateral = half_sample;
  bilateral.unilateral = false;
  list.push_back({"predictive wall", wall});
  list.push_back({"predictive wall, half sample only", half_sample});
  list.push_back({"predictive wall, observer only", plain});
  list.push_back({"predictive wall, bilateral", bilateral});
}

inline void add_environments(std::vector<NamedController>& list) {
  for (const auto integration :
       {Integration::explicit_euler, Integration::semi_implicit, Integration::implicit}) {
    const auto add = [&](const std::string& name, const Law& law) {
      list.push_back({name + ", " + std::string(name_of(integration)), Controller(law, {})});
    };
    add("free tool", make_test_coupling(integration));
    add("tool at bilateral wall", make_test_coupling(integration, false));
    add("tool at unilateral wall", make_test_coupling(integration, true));
    add("direct", DirectRendering{make_test_scene(integration)});
    add("direct, bilateral", DirectRendering{make_test_scene(integration, false)});
    add("proxy", ProxyRendering{make_test_scene(integration), 0.1, {2e3, 5}});
    add("equivalent", EquivalentImpedance{make_test_scene(integration)});
  }
  // Explicit steps of 1/30 s would make these objects and tools grow without end by themselves.
  VirtualCoupling coupling = make_test_coupling(Integration::implicit, true);
  coupling.update = make_slow_update();
  list.push_back({"tool at 30 Hz", coupling});
  constexpr auto semi = Integration::semi_implicit;
  constexpr auto implicit = Integration::implicit;
  list.push_back({"direct at 30 Hz", DirectRendering{make_slow_scene(implicit)}});
  list.push_back({"direct at 30 Hz, 16 substeps", DirectRendering{make_slow_scene(semi, 16)}});
  list.push_back({"proxy at 30 Hz", ProxyRendering{make_slow_scene(implicit), 0.1, {300, 2}}});
  list.push_back({"equivalent at 30 Hz", EquivalentImpedance{make_slow_scene(implicit)}});
}

/// What wraps a command, each kind of it, for a device of about 0.5 kg at 1 kHz.
inline std::vector<std::pair<std::string, Wrapper>> make_wrapper_list() {
  constexpr double period = 1e-3;
  const AccelerationMatching recorded{
      .inertia = 0.5,
      .damping = 2,
      .transient =
          RecordedTransient{.acceleration = {5, 8, -3, 1}, .time_step = 2e-3, .velocity = 0.1}};
  const AccelerationMatching sine{.inertia = 0.5, .transient = DecayingSine{0.5, 0.01, 100}};
  return {
      {"pre-emphasis", make_pre_emphasis({-500}, {}, 1000, period)},
      {"braking pulse", BrakingPulse{.damping = 100, .duration = 5e-3, .inertia = 0.5}},
      {"event transient", EventTransient{.gain = 50, .decay_time = 0.01, .frequency_hz = 100}},
      {"recorded acceleration", recorded},
      {"acceleration of a sine", sine},
      {"passivity control", PassivityControl{.max_damping = 500}},
      {"passivity control by reference",
       PassivityControl{PassivityControl::Observer::reference, 500}},
  };
}

/// Every kind of law and of wrapper, with parameters of a linear device of about 0.5 kg at 1 kHz:
/// the list over which what holds for all controllers is tested. A new law is a new line here;
/// law_list_test fails while one is missing.
inline std::vector<NamedController> make_controller_list() {
  std::vector<NamedController> list;
  list.push_back({"none", NoController{}});
  list.push_back({"wave", WaveController{.impedance = 1,
                                         .volts_per_velocity = 1,
                                         .volts_per_command = 1,
                                         .environment = WaveWall{.stiffness = 1000}}});
  add_walls(list);
  add_predictive_walls(list);
  add_environments(list);
  for (const auto& [name, wrapper] : make_wrapper_list()) {
    const VirtualWall wall{.stiffness = 20e3, .damping = 20, .unilateral = true};
    list.push_back({"wall with " + name, Controller(wall, {wrapper})});
  }
  return list;
}

}  // namespace gyrator::testing
