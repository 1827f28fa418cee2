#include "gyrator/studies/motion_terms.hpp"

namespace gyrator {
namespace {

const MotionUnits rotary_units{
    dimension::inertia,          dimension::rotary_damping,  dimension::rotary_stiffness,
    dimension::torque,           dimension::torque_constant, dimension::angle,
    dimension::angular_velocity, dimension::angle_quantum,   dimension::angular_acceleration};
const MotionUnits linear_units{
    dimension::mass,     dimension::linear_damping, dimension::linear_stiffness,
    dimension::force,    dimension::force_constant, dimension::length,
    dimension::velocity, dimension::length_quantum, dimension::acceleration};

const MotionTerms rotary_terms{rotary_units, Motion::rotary, "rotary",
                               "inertia",    "load_inertia", "torque_constant"};
const MotionTerms linear_terms{linear_units, Motion::linear, "linear",
                               "mass",       "load_mass",    "force_constant"};

}  // namespace

const MotionTerms& terms_of(Motion motion) {
  return motion == Motion::rotary ? rotary_terms : linear_terms;
}

const MotionUnits& units_of(Motion motion) {
  return terms_of(motion);
}

const nlohmann::json& find_either(const nlohmann::json& object, const char* rotary,
                                  const char* linear) {
  return object[object.contains(rotary) ? rotary : linear];
}

const nlohmann::json& find_inertia(const nlohmann::json& object) {
  return find_either(object, "inertia", "mass");
}

}  // namespace gyrator
