#include "gyrator/studies/controller_format.hpp"

#include "gyrator/studies/environment_format.hpp"
#include "gyrator/studies/velocity_format.hpp"
#include "gyrator/studies/wrapper_format.hpp"

#include <utility>

namespace gyrator {
namespace {

using nlohmann::json;

std::vector<ObjectSpec> wave_environment_specs(const MotionTerms& terms) {
  return {{"matched", "Absorbs every wave: a damper of the wave impedance.", {}},
          {"virtual_wall",
           "Spring and damper by the trapezoidal rule, at position zero of the environment's own "
           "motion, which starts at initial_position.",
           {
               member::quantity("stiffness", terms.stiffness)
                   .required()
                   .at_least(0)
                   .doc("Virtual stiffness K."),
               member::quantity("damping", terms.damping)
                   .by_default(0)
                   .doc("Virtual damping B; above minus the wave impedance."),
               member::boolean("unilateral")
                   .by_default(false)
                   .doc("Active only for positions of the environment > 0."),
           }}};
}

WaveEnvironment environment_of(const json& e) {
  if (e["kind"] == "matched") return MatchedEnvironment{};
  return WaveWall{e["stiffness"], e["damping"], e["unilateral"]};
}

Law parse_law(const json& c, const ControllerSurroundings& surroundings) {
  if (auto law = parse_environment(c, surroundings.period, surroundings.slow_period)) return *law;
  if (c["kind"] == "none") return NoController{};
  if (c["kind"] == "predictive_wall") return parse_predictive_wall(c);
  if (c["kind"] == "wave") return WaveController{.environment = environment_of(c["environment"])};
  return VirtualWall{c["stiffness"], c["damping"],
                     parse_velocity_estimator(c["velocity"], surroundings.quantum), c["unilateral"],
                     c["no_pull"]};
}

ObjectSpec pre_emphasis_spec() {
  return {"pre_emphasis",
          "The discrete inverse of the actuation path, applied to the command.",
          {
              member::quantity("band", dimension::frequency)
                  .above(0)
                  .doc("Edge of the band in which it inverts; absent: half the sampling rate."),
          }};
}

// Those that simulate nothing behind the loop.
std::vector<ObjectSpec> make_law_specs(const MotionTerms& terms) {
  return {{"none", "The command stays zero.", {}},
          {"virtual_wall",
           "Spring and damper computed from the sampled position, at position zero.",
           {
               member::quantity("stiffness", terms.stiffness)
                   .required()
                   .at_least(0)
                   .doc("Virtual stiffness K."),
               member::quantity("damping", terms.damping)
                   .by_default(0)
                   .doc("Virtual damping B; negative masks damping of the device."),
               member::variant("velocity", velocity_specs(terms))
                   .by_default({{"kind", "difference"}})
                   .doc("How velocity is estimated."),
               member::boolean("unilateral").by_default(false).doc("Active only for position > 0."),
               member::boolean("no_pull").by_default(false).doc(
                   "A unilateral wall that never pulls inwards."),
           }},
          {"wave",
           "The digital end of a wave-variable drive: reads the outgoing wave, averaged over each "
           "period, and answers with the incoming one. Needs the damping kind wave.",
           {
               member::variant("environment", wave_environment_specs(terms))
                   .required()
                   .doc("What lies behind the wave line."),
           }},
          make_predictive_wall_spec(terms)};
}

}  // namespace

std::vector<ObjectSpec> make_controller_specs(const MotionTerms& terms) {
  std::vector<ObjectSpec> laws = make_law_specs(terms);
  for (auto& spec : make_environment_specs(terms)) laws.push_back(std::move(spec));
  std::vector<ObjectSpec> specs = add_wrapper_specs(std::move(laws), terms);
  for (auto& spec : specs) {
    if (spec.name == "none" || spec.name == "wave") continue;
    spec.members.push_back(member::object("pre_emphasis", pre_emphasis_spec())
                               .doc("Output stage that undoes the drive's lag; absent: none."));
  }
  return specs;
}

Controller parse_controller(const json& c, const ControllerSurroundings& surroundings) {
  return {parse_law(find_wrapped_law(c), surroundings), parse_wrappers(c, surroundings)};
}

}  // namespace gyrator
