#pragma once

#include "gyrator/studies/motion_terms.hpp"
#include "gyrator/studies/schematic_parts.hpp"

#include <string>

namespace gyrator {

/// Values with their units, as drawings print them.
inline std::string ohms(double value) {
  return print_quantity(value, dimension::resistance);
}
inline std::string hertz(double value) {
  return print_quantity(value, dimension::frequency);
}
inline std::string seconds(const Rational& time) {
  return print_quantity(time.to_double(), dimension::time);
}

/// The motion's own words, letters and units in a drawing.
struct SchematicTerms {
  explicit SchematicTerms(Motion motion)
      : units(units_of(motion)), rotary(motion == Motion::rotary) {}

  std::string inertia(double value) const { return print_quantity(value, units.inertia); }
  std::string damping(double value) const { return print_quantity(value, units.damping); }
  std::string stiffness(double value) const { return print_quantity(value, units.stiffness); }
  std::string effort(double value) const { return print_quantity(value, units.effort); }
  std::string mass_letter() const { return rotary ? "J" : "m"; }
  std::string mass_word() const { return rotary ? "inertia" : "mass"; }
  std::string effort_letter() const { return rotary ? "τ" : "F"; }
  std::string effort_word() const { return rotary ? "torque" : "force"; }
  std::string velocity_letter() const { return rotary ? "ω" : "v"; }

  Part make_mass(const std::string& what, const std::string& index, double value) const {
    return {Symbol::mass, what, mass_letter() + index, {inertia(value)}};
  }
  Part make_damper(const std::string& what, const std::string& index, double value) const {
    return {Symbol::damper, what, "b" + index, {damping(value)}};
  }
  Part make_spring(const std::string& what, const std::string& index, double value) const {
    return {Symbol::spring, what, "k" + index, {stiffness(value)}};
  }

  const MotionUnits& units;
  bool rotary;
};

}  // namespace gyrator
