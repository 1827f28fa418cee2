#pragma once

#include "gyrator/controllers/controller.hpp"

#include <string>
#include <vector>

namespace gyrator::testing {

struct NamedLaw {
  std::string name;
  Law law;
};

/// Every kind of law, with parameters of a linear device of about 0.5 kg at 1 kHz: the list over
/// which what holds for all controllers is tested. A new law is a new line.
inline std::vector<NamedLaw> make_law_list() {
  const DeviceModel half_kilo{.inertia = 0.5, .damping = 2};
  return {
      {"none", NoController{}},
      {"spring", VirtualWall{.stiffness = 20e3}},
      {"spring and damper", VirtualWall{.stiffness = 20e3, .damping = 100}},
      {"negative damper", VirtualWall{.stiffness = 2e3, .damping = -10}},
      {"filtered damper",
       VirtualWall{.stiffness = 5e3, .damping = 200, .velocity = FilteredDifferenceEstimator{50}}},
      {"unilateral wall", VirtualWall{.stiffness = 90e3, .unilateral = true}},
      {"unilateral wall without pull",
       VirtualWall{.stiffness = 20e3, .damping = 200, .unilateral = true, .no_pull = true}},
      {"predictive wall", PredictiveWall{.stiffness = 20e3, .damping = 10, .device = half_kilo}},
      {"predictive wall, half sample only",
       PredictiveWall{.stiffness = 20e3, .device = half_kilo, .dead_beat = false}},
      {"wave", WaveController{.impedance = 1,
                              .volts_per_velocity = 1,
                              .volts_per_command = 1,
                              .environment = WaveWall{.stiffness = 1000}}},
  };
}

}  // namespace gyrator::testing
