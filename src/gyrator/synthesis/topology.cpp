#include "gyrator/synthesis/topology.hpp"

#include "gyrator/studies/motion_terms.hpp"

namespace gyrator {
namespace {

double tenth_of_winding(const Motor& motor) {
  return motor.resistance / 10;
}
double hundred_windings(const Motor& motor) {
  return motor.resistance * 100;
}

// Below, the damping of a shorted winding, K_t²/R_m, is the natural scale.
double shorted_damping(const Motor& motor) {
  return motor.torque_constant * motor.torque_constant / motor.resistance;
}

DesignVariable resistance(const char* meaning) {
  return {"resistance",     DesignPart::resistor, dimension::resistance,
          tenth_of_winding, hundred_windings,     meaning};
}

std::vector<Topology> make_topologies(Motion motion) {
  return {
      {"resistor",
       false,
       {resistance("Resistor across the motor.")},
       [](const Motor&, std::span<const double> x) -> Damping { return ResistorDamping{x[0]}; }},
      {"rc",
       false,
       {resistance("Resistor in series with the capacitor, across the motor."),
        {"capacitance", DesignPart::capacitor, dimension::capacitance,
         [](const Motor&) { return 1e-6; }, [](const Motor&) { return 1e-2; },
         "Capacitor in series with it."}},
       [](const Motor&, std::span<const double> x) -> Damping {
         return RcDamping{x[0], x[1]};
       }},
      {"resistance_cancellation",
       true,
       {{"fraction", DesignPart::setting, dimension::none, [](const Motor&) { return 0.05; },
         [](const Motor&) { return 0.95; }, "Share of the cold winding that is cancelled."}},
       [](const Motor& motor, std::span<const double> x) -> Damping {
         return ResistanceCancellation{x[0] * motor.resistance, {}};
       }},
      {"back_emf",
       false,
       {{"damping", DesignPart::setting, units_of(motion).damping,
         [](const Motor& motor) { return shorted_damping(motor) / 100; },
         [](const Motor& motor) { return shorted_damping(motor) * 100; },
         "Damping that the feedback of the back-EMF adds."}},
       [](const Motor& motor, std::span<const double> x) -> Damping {
         return BackEmfDamping{x[0], motor.resistance, motor.inductance, {}, {}};
       }},
  };
}

}  // namespace

const std::vector<Topology>& list_topologies(Motion motion) {
  static const std::vector<Topology> rotary = make_topologies(Motion::rotary);
  static const std::vector<Topology> linear = make_topologies(Motion::linear);
  return motion == Motion::rotary ? rotary : linear;
}

std::string name_of(const Topology& topology, const DesignVariable& variable) {
  return topology.name + "." + variable.key;
}

}  // namespace gyrator
