#pragma once

#include "gyrator/core/quantity.hpp"
#include "gyrator/mechanics/device.hpp"

#include <nlohmann/json.hpp>

namespace gyrator {

/// The units of a motion: N.m and rad, or N and m.
struct MotionUnits {
  Unit inertia, damping, stiffness, effort, motor_constant, position, velocity, quantum,
      acceleration;
};
const MotionUnits& units_of(Motion motion);

/// The two motions differ in units and in the names of mass and motor constant; nothing else.
struct MotionTerms : MotionUnits {
  Motion motion;
  const char* name;
  const char* inertia_name;
  const char* load_inertia_name;
  const char* motor_constant_name;
};
const MotionTerms& terms_of(Motion motion);

/// What a validated document has under the motion's own name: of the two keys the one that is
/// there.
const nlohmann::json& find_either(const nlohmann::json& object, const char* rotary,
                                  const char* linear);
/// "inertia" or "mass".
const nlohmann::json& find_inertia(const nlohmann::json& object);

}  // namespace gyrator
