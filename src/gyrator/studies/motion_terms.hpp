#pragma once

#include "gyrator/core/quantity.hpp"
#include "gyrator/mechanics/device.hpp"

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

}  // namespace gyrator
