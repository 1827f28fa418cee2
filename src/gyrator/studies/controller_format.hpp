#pragma once

#include "gyrator/controllers/controller.hpp"
#include "gyrator/core/rational.hpp"
#include "gyrator/documents/document_spec.hpp"
#include "gyrator/studies/motion_terms.hpp"

#include <optional>
#include <vector>

#include <nlohmann/json.hpp>

namespace gyrator {

/// The kinds of the model file's key "controller".
std::vector<ObjectSpec> make_controller_specs(const MotionTerms& terms);

/// The rest of the model that a controller's defaults come from.
struct ControllerSurroundings {
  Rational period;
  double quantum = 0;                     ///< of the sensor [m, rad]
  double inertia = 0;                     ///< that the port has by itself [kg, kg.m^2]
  std::optional<Rational> slow_period{};  ///< of a slower environment
};

/// From a validated document: every key is there, of the right type, in SI units. What takes its
/// scales from the drive (wave, pre-emphasis) is connected by the model file afterwards.
Controller parse_controller(const nlohmann::json& document,
                            const ControllerSurroundings& surroundings);

}  // namespace gyrator
