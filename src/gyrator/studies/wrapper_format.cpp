#include "gyrator/studies/wrapper_format.hpp"

#include "gyrator/core/error.hpp"

#include <fmt/core.h>

namespace gyrator {
namespace {

using nlohmann::json;

std::vector<ObjectSpec> transient_specs(const MotionTerms& terms) {
  const bool rotary = terms.motion == Motion::rotary;
  const Unit acceleration = rotary ? dimension::angular_acceleration : dimension::acceleration;
  return {
      {"decaying_sine",
       "Opposing acceleration A v e^(-B t) sin(w t).",
       {
           member::number("velocity_change")
               .by_default(1)
               .above(0)
               .doc(
                   "Of the device when the transient is over, in velocities of impact; from this A "
                   "follows. 1 stops a free device."),
           member::quantity("decay_time", dimension::time).required().above(0).doc("1/B."),
           member::quantity("frequency", dimension::frequency)
               .required()
               .above(0)
               .doc("w/2 pi; below half the sampling rate."),
       }},
      {"recorded",
       "Opposing acceleration as measured, linear between samples, from the moment of contact on.",
       {
           member::quantity("acceleration", acceleration).list(2).required().doc("The samples."),
           member::quantity("time_step", dimension::time).required().above(0).doc("Between them."),
           member::quantity("velocity", terms.velocity)
               .required()
               .above(0)
               .doc("Of the impact at which it was recorded; others are played in proportion."),
       }}};
}

std::vector<ObjectSpec> effect_specs(const MotionTerms& terms) {
  return {{"braking_pulse",
           "A constant push at contact, g times the velocity of impact.",
           {
               member::quantity("damping", terms.damping)
                   .required()
                   .above(0)
                   .doc("g; inertia over sampling period stops the device in one sample."),
               member::quantity("duration", dimension::time)
                   .by_default(0)
                   .at_least(0)
                   .doc("Rounded to samples, at least one."),
               member::quantity(terms.inertia_name, terms.inertia)
                   .above(0)
                   .doc("Of what moves: the pulse is cut to what stops it. Without: no limit."),
           }},
          {"event_transient",
           "A decaying sine at contact, in proportion to the velocity of impact [8.49].",
           {
               member::quantity("gain", terms.damping)
                   .required()
                   .above(0)
                   .doc("Amplitude at its start per velocity of impact, A(v)/v."),
               member::quantity("decay_time", dimension::time).required().above(0).doc("1/B."),
               member::quantity("frequency", dimension::frequency)
                   .required()
                   .above(0)
                   .doc("w/2 pi; below half the sampling rate."),
           }},
          {"acceleration_matching",
           "An acceleration transient at contact, through the inverse of the device.",
           {
               member::quantity(terms.inertia_name, terms.inertia)
                   .required()
                   .above(0)
                   .doc("Of the device."),
               member::quantity("damping", terms.damping)
                   .by_default(0)
                   .at_least(0)
                   .doc("Of the device."),
               member::variant("transient", transient_specs(terms))
                   .required()
                   .doc("What is felt of a real impact."),
           }}};
}

Wrapper parse_effect(const json& e) {
  if (e["kind"] == "braking_pulse") {
    BrakingPulse pulse{.damping = e["damping"], .duration = e["duration"]};
    if (const json& inertia = find_inertia(e); !inertia.is_null()) pulse.inertia = inertia;
    return pulse;
  }
  if (e["kind"] == "event_transient")
    return EventTransient{e["gain"], e["decay_time"], e["frequency"]};
  AccelerationMatching matching{.inertia = find_inertia(e), .damping = e["damping"]};
  const json& t = e["transient"];
  if (t["kind"] == "decaying_sine")
    matching.transient = DecayingSine{t["velocity_change"], t["decay_time"], t["frequency"]};
  else
    matching.transient = RecordedTransient{t["acceleration"], t["time_step"], t["velocity"]};
  return matching;
}

ObjectSpec passivity_spec(std::vector<ObjectSpec> laws, const MotionTerms& terms) {
  return {
      "passivity",
      "Time-domain passivity control around another controller: damping where its observed energy "
      "falls short.",
      {
          member::variant("controller", std::move(laws))
              .required()
              .doc("What is wrapped; it must compute its command from a position."),
          member::choice("observer", {"simple", "reference"})
              .by_default("simple")
              .doc("simple: the energy so far and one step ahead must not be negative [8.32]; "
                   "reference: it must follow the stored and dissipated energy of the law in "
                   "continuous time [8.35]."),
          member::quantity("max_damping", terms.damping)
              .above(0)
              .doc("Most damping that is added; without: what stops the device in one sample, its "
                   "inertia over the sampling period."),
          member::quantity("max_effort", terms.effort)
              .above(0)
              .doc("Most effort that is added; what it leaves of a shortfall stays for later."),
      }};
}

// A law that may have a surface at position zero.
bool may_have_contact(const ObjectSpec& law) {
  return law.name == "virtual_wall" || law.name == "predictive_wall";
}

// Validated: a law without the key can have none.
const json& find_contact_effects(const json& law) {
  static const json none = json::array();
  const auto found = law.find("contact_effects");
  return found == law.end() ? none : *found;
}

bool is_passivity(const json& controller) {
  return controller["kind"] == "passivity";
}

}  // namespace

std::vector<ObjectSpec> add_wrapper_specs(std::vector<ObjectSpec> laws, const MotionTerms& terms) {
  for (ObjectSpec& law : laws) {
    if (!may_have_contact(law)) continue;
    law.members.push_back(member::variant("contact_effects", effect_specs(terms))
                              .list()
                              .by_default(json::array())
                              .doc("What is added at each contact, from the inside out; needs a "
                                   "surface at position zero."));
  }
  laws.push_back(passivity_spec(laws, terms));
  return laws;
}

const json& find_wrapped_law(const json& controller) {
  return is_passivity(controller) ? controller["controller"] : controller;
}

std::string find_law_place(const json& controller) {
  return is_passivity(controller) ? "/controller/controller" : "/controller";
}

std::vector<Wrapper> parse_wrappers(const json& controller,
                                    const ControllerSurroundings& surroundings) {
  std::vector<Wrapper> wrappers;
  for (const json& effect : find_contact_effects(find_wrapped_law(controller)))
    wrappers.push_back(parse_effect(effect));
  if (!is_passivity(controller)) return wrappers;
  PassivityControl control;
  if (controller["observer"] == "reference")
    control.observer = PassivityControl::Observer::reference;
  control.max_damping = controller["max_damping"].is_null()
                            ? surroundings.inertia / surroundings.period.to_double()
                            : controller["max_damping"].get<double>();
  if (!controller["max_effort"].is_null()) control.max_effort = controller["max_effort"];
  wrappers.emplace_back(control);
  return wrappers;
}

void check_wrappers(const Controller& controller, const json& document, double period) {
  const json& law = find_wrapped_law(document);
  const json& effects = find_contact_effects(law);
  const std::string kind = law["kind"];
  const std::string place = find_law_place(document).substr(1);
  if (is_passivity(document) && !reads_position(controller.law)) {
    throw Error(ErrorCode::bad_input, place + "/kind",
                fmt::format("\"{}\" cannot be wrapped by passivity: it computes no command from a "
                            "position, so that no energy can be observed; use a wall",
                            kind));
  }
  if (!effects.empty() && !has_contact(controller.law)) {
    throw Error(ErrorCode::bad_input, place + "/contact_effects",
                fmt::format("\"{}\" has no moment of contact here: contact effects need a surface "
                            "at position zero, such as virtual_wall with \"unilateral\": true, or "
                            "predictive_wall",
                            kind));
  }
  for (std::size_t i = 0; i < effects.size(); ++i) {
    try {
      std::visit(
          [&](const auto& effect) {
            if constexpr (requires { make_effect_course(effect, period); })
              make_effect_course(effect, period);
          },
          controller.wrappers[i]);
    } catch (const Error& error) {
      const std::string key = error.place().substr(error.place().rfind('/') + 1);
      const bool nested = effects[i].contains("transient");
      throw Error(
          error.code(),
          fmt::format("{}/contact_effects/{}{}/{}", place, i, nested ? "/transient" : "", key),
          error.message());
    }
  }
}

ObjectSpec make_predictive_wall_spec(const MotionTerms& terms) {
  const ObjectSpec device{
      "device",
      "What the controller knows of the device, for its prediction.",
      {
          member::quantity(terms.inertia_name, terms.inertia).required().above(0).doc("It moves."),
          member::quantity("damping", terms.damping).by_default(0).at_least(0).doc("Viscous."),
          member::quantity("constant_effort", terms.effort)
              .by_default(0)
              .doc("That acts on it, such as a weight; positive into the wall."),
      }};
  return {"predictive_wall",
          "A unilateral spring and damper that predicts the device between samples. Takes the "
          "command to act without delay.",
          {
              member::quantity("stiffness", terms.stiffness)
                  .required()
                  .at_least(0)
                  .doc("Virtual stiffness K."),
              member::quantity("damping", terms.damping)
                  .by_default(0)
                  .at_least(0)
                  .doc("Virtual damping B."),
              member::object("device", device).required().doc("Model of the device."),
              member::choice("prediction", {"half_sample", "none"})
                  .by_default("half_sample")
                  .doc("Where in contact the wall is rendered: where the device will be half a "
                       "period later, or where it is sensed."),
              member::boolean("dead_beat")
                  .by_default(true)
                  .doc("Corrects entry and exit: where the surface is crossed between samples, two "
                       "commands bring the device to where the continuous wall would."),
          }};
}

Law parse_predictive_wall(const json& c) {
  const json& d = c["device"];
  return PredictiveWall{.stiffness = c["stiffness"],
                        .damping = c["damping"],
                        .device = {find_inertia(d), d["damping"], d["constant_effort"]},
                        .prediction = c["prediction"] == "none"
                                          ? PredictiveWall::Prediction::none
                                          : PredictiveWall::Prediction::half_sample,
                        .dead_beat = c["dead_beat"]};
}

}  // namespace gyrator
