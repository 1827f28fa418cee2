#include "gyrator/studies/model_format.hpp"

#include "gyrator/circuits/drive.hpp"
#include "gyrator/studies/controller_format.hpp"
#include "gyrator/studies/motion_terms.hpp"
#include "gyrator/studies/operator_format.hpp"
#include "gyrator/studies/sampling_format.hpp"

#include <utility>

namespace gyrator {
namespace {

using nlohmann::json;

ObjectSpec thermal_spec() {
  return {"thermal",
          "How the winding warms, C_th dh/dt = R i^2 - h/R_th, h its temperature rise.",
          {
              member::quantity("resistance", dimension::thermal_resistance)
                  .required()
                  .above(0)
                  .doc("From winding to ambient, R_th."),
              member::quantity("capacity", dimension::thermal_capacity)
                  .required()
                  .above(0)
                  .doc("Of the winding, C_th."),
          }};
}

ObjectSpec motor_spec(const MotionTerms& terms) {
  return {"motor",
          "A permanent-magnet motor: e = K_t w, tau = K_t i behind its winding.",
          {
              member::quantity(terms.motor_constant_name, terms.motor_constant)
                  .required()
                  .above(0)
                  .doc("Effort per current, and back-EMF per velocity."),
              member::quantity("resistance", dimension::resistance)
                  .required()
                  .above(0, "a winding has resistance")
                  .doc("Of the winding, terminal to terminal."),
              member::quantity("inductance", dimension::inductance)
                  .by_default(0)
                  .at_least(0)
                  .doc("Of the winding; 0 leaves it out."),
              member::quantity("temperature_coefficient", dimension::temperature_coefficient)
                  .by_default(copper_temperature_coefficient)
                  .at_least(0)
                  .doc("Of the resistance; copper by default."),
              member::quantity("temperature_rise", dimension::temperature)
                  .by_default(0)
                  .doc("How much warmer the winding is than when \"resistance\" was measured; "
                       "negative: colder. The amplifier's scale does not follow it."),
              member::object("thermal", thermal_spec())
                  .doc("Absent: the winding stays at \"temperature_rise\". Present: `simulate` "
                       "starts there and warms it."),
          }};
}

// The same in "mechanics" and in the list "damping".
ObjectSpec high_pass_damper_spec(const MotionTerms& terms) {
  return {"high_pass_damper",
          "A damper from the operator port to a floating inertia: damps high frequencies only.",
          {
              member::quantity(terms.inertia_name, terms.inertia)
                  .required()
                  .above(0)
                  .doc("Of the floating body."),
              member::quantity("damping", terms.damping)
                  .required()
                  .above(0)
                  .doc("Between port and floating body."),
          }};
}

ObjectSpec mechanics_spec(const MotionTerms& terms) {
  const ObjectSpec transmission{
      "transmission",
      "A compliant transmission; the operator then holds the load, not the motor.",
      {
          member::quantity("stiffness", terms.stiffness)
              .required()
              .above(0)
              .doc("Of the transmission."),
          member::quantity("damping", terms.damping)
              .by_default(0)
              .at_least(0)
              .doc("Parallel to the stiffness."),
          member::quantity(terms.load_inertia_name, terms.inertia)
              .required()
              .above(0)
              .doc("Beyond the compliance."),
      }};
  const ObjectSpec stops{
      "stops",
      "Elastic stops at the operator port, e = k q + d dq/dt beyond them, never pulling. Only "
      "`simulate` knows them. Give lower, upper or both.",
      {
          member::quantity("lower", terms.position).doc("Position; absent: none."),
          member::quantity("upper", terms.position).doc("Position; absent: none."),
          member::quantity("stiffness", terms.stiffness).required().above(0).doc("Of each stop."),
          member::quantity("damping", terms.damping).by_default(0).at_least(0).doc("Of each stop."),
      }};
  return {"mechanics",
          "What moves.",
          {
              member::quantity(terms.inertia_name, terms.inertia)
                  .required()
                  .above(0, "the operator port must have an inertia")
                  .doc("Of the motor and all that is rigid with it."),
              member::quantity("damping", terms.damping)
                  .by_default(0)
                  .at_least(0)
                  .doc("Viscous, to ground."),
              member::quantity("coulomb_friction", terms.effort)
                  .by_default(0)
                  .at_least(0)
                  .doc("Sliding level at the motor; the linear tools leave it out, but for the "
                       "criterion quantized_coulomb."),
              member::quantity("stiction", terms.effort)
                  .at_least(0)
                  .doc("Effort at which a resting motor breaks away; at least, and by default, "
                       "coulomb_friction. Only `simulate` knows it."),
              member::quantity("stribeck_velocity", terms.velocity)
                  .by_default(0)
                  .at_least(0)
                  .doc("Up to which friction falls along a line from stiction, which must be above "
                       "it, to coulomb_friction; 0: at once."),
              member::object("stops", stops).doc("Hard stops at the port."),
              member::object("transmission", transmission).doc("Compliant transmission to a load."),
              member::object("high_pass_damper", high_pass_damper_spec(terms))
                  .doc("Damper with a floating inertia; may stand in \"damping\" as well."),
          }};
}

std::vector<ObjectSpec> amplifier_specs() {
  const auto bandwidth = [] {
    return member::quantity("bandwidth", dimension::frequency)
        .above(0)
        .doc("-3 dB frequency; absent: ideal.");
  };
  const auto current_limit = [](const char* what) {
    return member::quantity("current_limit", dimension::current).above(0).doc(what);
  };
  const auto voltage_limit = [](const char* what) {
    return member::quantity("voltage_limit", dimension::voltage).above(0).doc(what);
  };
  return {{"ideal",
           "Produces the commanded effort at the shaft itself, whatever the circuit: A = 1.",
           {}},
          {"current",
           "Regulates a current with a first-order closed loop.",
           {
               bandwidth(),
               member::choice("sense", {"total", "motor"})
                   .by_default("total")
                   .doc("Which current: all that the amplifier delivers, or what passes the "
                        "winding (which removes "
                        "the damping of a circuit across the motor within the bandwidth)."),
               current_limit("Largest current that is asked for; absent: none."),
               voltage_limit("Largest terminal voltage, the excess flows into the supply rails "
                             "(0.01 ohm); absent: none."),
           }},
          {"voltage",
           "Applies a voltage behind an output resistance.",
           {
               bandwidth(),
               member::quantity("output_resistance", dimension::resistance)
                   .by_default(0)
                   .at_least(0)
                   .doc("In series with the output."),
               current_limit("Beyond it the output gives way, 1000 V per A; absent: none."),
               voltage_limit("Largest voltage that is asked for; absent: none."),
           }}};
}

Member cutoff_frequency(const char* name) {
  return member::quantity(name, dimension::frequency).above(0);
}

// Circuits around the motor terminals.
std::vector<ObjectSpec> branch_specs(const MotionTerms& terms) {
  return {{"resistor",
           "A resistor across the motor terminals.",
           {
               member::quantity("resistance", dimension::resistance)
                   .required()
                   .above(0)
                   .doc("Across the terminals."),
           }},
          {"rc",
           "Resistor and capacitor in series across the motor terminals.",
           {
               member::quantity("resistance", dimension::resistance)
                   .required()
                   .at_least(0)
                   .doc("In series with the capacitor; 0 leaves it out."),
               member::quantity("capacitance", dimension::capacitance)
                   .required()
                   .above(0)
                   .doc("Blocks the damping at low frequency; acts as the inertia K_t^2 C there."),
           }},
          {"netlist",
           "A circuit with two terminals from a SPICE file, across the motor.",
           {
               member::text("file").required().doc("Path, relative to the model file."),
               member::text("subckt").by_default("").doc(
                   "Name of the subcircuit; absent: the file's only one."),
               member::boolean("allow_negative")
                   .by_default(false)
                   .doc("Take negative resistances, as parts that supply energy."),
           }},
          {"wave",
           "A wave-variable drive: resistance between a voltage amplifier and the motor, so that "
           "source and resistance carry waves of this impedance. At most one.",
           {
               member::quantity("impedance", terms.damping)
                   .required()
                   .above(0)
                   .doc("Wave impedance b_w; the whole source resistance is K_t^2/b_w, the "
                        "amplifier's output_resistance included."),
           }},
          {"clamp",
           "A bidirectional suppressor across the motor terminals: conducts beyond its voltage.",
           {
               member::quantity("voltage", dimension::voltage)
                   .required()
                   .above(0)
                   .doc("From which on it conducts, either way."),
               member::quantity("resistance", dimension::resistance)
                   .by_default(0.1)
                   .above(0)
                   .doc("Of what flows beyond."),
           }}};
}

// Feedback around the amplifier.
std::vector<ObjectSpec> feedback_specs(const MotionTerms& terms) {
  return {
      {"resistance_cancellation",
       "A voltage in series with the motor that rises with its current, so that the winding "
       "appears as R_m - R_c.",
       {
           member::quantity("resistance", dimension::resistance).at_least(0).doc("Cancelled, R_c."),
           member::number("fraction")
               .at_least(0)
               .doc("R_c as a part of the winding's resistance at the reference temperature."),
           cutoff_frequency("bandwidth").doc("-3 dB frequency of the feedback; absent: ideal."),
       },
       {{"resistance", "fraction"}}},
      {"back_emf",
       "Active electrical damping: back-EMF estimated from terminal voltage and current, fed "
       "back to the command.",
       {
           member::quantity("damping", terms.damping)
               .required()
               .at_least(0)
               .doc("Added within the band."),
           member::quantity("resistance_estimate", dimension::resistance)
               .at_least(0)
               .doc("Of the winding; absent: the motor's at the reference temperature."),
           member::quantity("inductance_estimate", dimension::inductance)
               .at_least(0)
               .doc("Of the winding; absent: the motor's."),
           cutoff_frequency("low_pass").doc("-3 dB frequency; absent: none."),
           cutoff_frequency("high_pass").doc("-3 dB frequency; absent: none."),
       }},
      {"held_impedance",
       "The virtual wall's stiffness and damping act in an analog loop around the position "
       "sensor; the controller holds gains and centre.",
       {
           cutoff_frequency("bandwidth").doc("-3 dB frequency of the loop; absent: ideal."),
       }},
      {"torque_sensed_damper",
       "A viscous damper at the port whose effort is measured and, low-passed, added to the "
       "command: felt at high frequency only.",
       {
           member::quantity("damping", terms.damping).required().above(0).doc("Of the damper."),
           cutoff_frequency("cutoff").required().doc("Of the low-pass in the cancellation."),
       }}};
}

std::vector<ObjectSpec> damping_specs(const MotionTerms& terms) {
  std::vector<ObjectSpec> specs = branch_specs(terms);
  for (auto& spec : feedback_specs(terms)) specs.push_back(std::move(spec));
  specs.push_back(
      {"eddy_current_brake",
       "A viscous damper at the port that can be switched off.",
       {
           member::quantity("damping", terms.damping).required().above(0).doc("While it is on."),
           member::boolean("on").by_default(true).doc("Whether it is."),
       }});
  specs.push_back(high_pass_damper_spec(terms));
  specs.push_back(
      {"friction_brake",
       "A friction brake at the port, controlled to imitate a damper up to its holding effort.",
       {
           member::quantity("damping", terms.damping).required().above(0).doc("Imitated."),
           member::quantity("effort", terms.effort).required().above(0).doc("Largest, holding."),
       }});
  return specs;
}

ObjectSpec simulation_spec(const MotionTerms& terms) {
  return {"simulation",
          "What `simulate` runs.",
          {
              member::time("duration").by_default("0.5 s").above(0).doc("Simulated time."),
              member::quantity("initial_velocity", terms.velocity)
                  .by_default(0)
                  .doc("Of all inertias at the first sample."),
              member::quantity("initial_position", terms.position)
                  .by_default(0)
                  .doc("At the first sample."),
              member::quantity("external_effort", terms.effort)
                  .by_default(0)
                  .doc("Constant effort on the port, beside the operator."),
              member::variant("gesture", gesture_specs(terms))
                  .doc("What the hand wants over time; adds to external_effort."),
              member::integer("seed").by_default(1).at_least(0).doc(
                  "Of noise, jitter and random gestures: the same seed gives the same run."),
          }};
}

// What the linear analyses leave out is not varied either.
const std::vector<std::string>& untoleranced_names() {
  static const std::vector<std::string> names{
      "thermal", "coulomb_friction", "stiction",      "stribeck_velocity",
      "stops",   "current_limit",    "voltage_limit", "voltage",
      "effort"};
  return names;
}

ObjectSpec with_tolerances(ObjectSpec spec) {
  return allow_tolerances(std::move(spec), untoleranced_names());
}

std::vector<ObjectSpec> with_tolerances(std::vector<ObjectSpec> specs) {
  for (ObjectSpec& spec : specs) {
    if (spec.name != "clamp") spec = with_tolerances(std::move(spec));
  }
  return specs;
}

ObjectSpec model_spec(const MotionTerms& terms) {
  return {
      terms.name,
      terms.motion == Motion::rotary ? "A rotary device: N.m and rad."
                                     : "A linear device: N and m.",
      {
          member::choice("schema", {model_schema_name})
              .by_default(model_schema_name)
              .doc("Version of the format."),
          member::text("name").by_default("unnamed").doc("Shown in reports."),
          member::object("motor", with_tolerances(motor_spec(terms)))
              .doc("Needed by every amplifier but ideal."),
          member::object("mechanics", with_tolerances(mechanics_spec(terms)))
              .required()
              .doc("What moves."),
          member::variant("amplifier", with_tolerances(amplifier_specs()))
              .by_default({{"kind", "current"}})
              .doc("The command is an effort, scaled so that at DC the blocked effort equals it."),
          member::variant("damping", with_tolerances(damping_specs(terms)))
              .list()
              .by_default(json::array())
              .doc("What damps the device, in any mixture: circuits across the motor, feedback "
                   "around the amplifier, dampers at the port."),
          member::object("sensor", sensor_spec(terms))
              .by_default(json::object())
              .doc("The position sensor."),
          member::object("sampling", sampling_spec()).required().doc("The controller's clock."),
          member::object("dac", dac_spec(terms))
              .by_default(json::object())
              .doc("The converter between controller and amplifier."),
          member::variant("controller", make_controller_specs(terms))
              .by_default({{"kind", "none"}})
              .doc("What computes the command."),
          member::variant("operator", operator_specs(terms, terms.inertia_name))
              .by_default({{"kind", "free"}})
              .doc("Who holds the port in `simulate` and `zwidth --criterion coupled`."),
          member::object("simulation", simulation_spec(terms))
              .by_default(json::object())
              .doc("What `simulate` runs."),
      }};
}

}  // namespace

const Member& model_format() {
  static const Member format =
      member::variant("model",
                      {model_spec(terms_of(Motion::rotary)), model_spec(terms_of(Motion::linear))},
                      "motion")
          .required()
          .doc("A haptic display with its sampled controller.");
  return format;
}

}  // namespace gyrator
