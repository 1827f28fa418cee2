#include "gyrator/studies/environment_format.hpp"

#include "gyrator/core/error.hpp"

#include <string_view>

#include <fmt/core.h>

namespace gyrator {
namespace {

using nlohmann::json;

constexpr double most_substeps = 10'000;

ObjectSpec spring_damper_spec(const MotionTerms& terms, const char* name, const char* meaning) {
  return {name,
          meaning,
          {
              member::quantity("stiffness", terms.stiffness)
                  .required()
                  .at_least(0)
                  .doc("Of its spring."),
              member::quantity("damping", terms.damping)
                  .by_default(0)
                  .at_least(0)
                  .doc("Of its damper."),
          }};
}

Member integration() {
  return member::choice("integration", {"explicit", "semi_implicit", "implicit"})
      .by_default("semi_implicit")
      .doc(
          "How the simulated bodies are moved on: Euler's method with efforts and velocities from "
          "before the step, with the new velocity, or with new efforts too.");
}

Member substeps() {
  return member::integer("substeps")
      .by_default(1)
      .at_least(1)
      .at_most(most_substeps)
      .doc("Into which every step of the simulated bodies is divided.");
}

Member update() {
  return member::object(
             "update",
             {"update",
              "How often the environment is computed, and how its results reach the fast loop.",
              {
                  member::time("period").above(0).doc(
                      "Of the environment, at least the fast loop's; absent: slow_period of "
                      "sampling, else the loop's own."),
                  member::time("delay").by_default(0).at_least(0).doc(
                      "From the update to where its result is used."),
                  member::number("loss").by_default(0).at_least(0).below(1).doc(
                      "Probability that a result is lost; the loop then keeps the last one."),
                  member::integer("seed").by_default(1).at_least(0).doc("Of the losses."),
              }})
      .by_default(json::object())
      .doc("How often the environment is computed, and how its results reach the fast loop.");
}

ObjectSpec tool_spec(const MotionTerms& terms) {
  return {"tool",
          "The simulated tool.",
          {
              member::quantity(terms.inertia_name, terms.inertia)
                  .required()
                  .above(0)
                  .doc("Of the tool."),
              member::quantity("damping", terms.damping)
                  .by_default(0)
                  .at_least(0)
                  .doc("Of the tool, to ground."),
          }};
}

std::vector<ObjectSpec> tool_environment_specs(const MotionTerms& terms) {
  return {
      {"none", "The tool is free.", {}},
      {"virtual_wall",
       "Spring and damper to ground.",
       {
           member::quantity("stiffness", terms.stiffness)
               .required()
               .at_least(0)
               .doc("Of the wall."),
           member::quantity("damping", terms.damping).by_default(0).at_least(0).doc("Of the wall."),
           member::quantity("position", terms.position).by_default(0).doc("Of its surface."),
           member::boolean("unilateral")
               .by_default(false)
               .doc("Acts for a tool beyond its position only, and only pushes back."),
       }}};
}

ObjectSpec object_spec(const MotionTerms& terms) {
  return {
      "object",
      "A deformable object: the mass of its surface, with spring and damper to ground.",
      {
          member::quantity(terms.inertia_name, terms.inertia)
              .required()
              .above(0)
              .doc("That moves with the surface."),
          member::quantity("damping", terms.damping).by_default(0).at_least(0).doc("To ground."),
          member::quantity("stiffness", terms.stiffness).required().at_least(0).doc("To ground."),
          member::quantity("position", terms.position).by_default(0).doc("Of the surface at rest."),
      }};
}

std::vector<Member> scene_members(const MotionTerms& terms, Member contact) {
  return {member::object("object", object_spec(terms)).required().doc("What is touched."),
          std::move(contact),
          member::boolean("unilateral")
              .by_default(true)
              .doc("The contact acts in penetration only, and only pushes."),
          integration(),
          substeps(),
          update()};
}

SpringDamper spring_damper_of(const json& s) {
  return {s["stiffness"], s["damping"]};
}

Integration integration_of(const json& name) {
  for (const auto kind : {Integration::explicit_euler, Integration::semi_implicit})
    if (name == name_of(kind)) return kind;
  return Integration::implicit;
}

SlowUpdate update_of(const json& u, const Rational& period,
                     const std::optional<Rational>& slow_period) {
  const auto time = [](const json& value) { return Rational::from_text(value.get<std::string>()); };
  SlowUpdate update{slow_period, time(u["delay"]), u["loss"], u["seed"].get<std::uint64_t>()};
  if (!u["period"].is_null()) update.period = time(u["period"]);
  if (update.period == period) update.period.reset();
  return update;
}

}  // namespace

std::vector<ObjectSpec> make_environment_specs(const MotionTerms& terms) {
  const auto contact = [&](const char* doc) {
    return member::object("contact", spring_damper_spec(terms, "contact", doc)).doc(doc);
  };
  const auto coupling = [&](const char* doc) {
    return member::object("coupling", spring_damper_spec(terms, "coupling", doc))
        .required()
        .doc(doc);
  };
  ObjectSpec proxy{"proxy",
                   "A deformable object touched by a simulated tool, which a virtual coupling ties "
                   "to the device: the coupling's effort is held between updates.",
                   scene_members(terms, contact("Between tool and surface; absent: as the "
                                                "coupling."))};
  proxy.members.insert(proxy.members.begin(), coupling("Between device and tool."));
  proxy.members.insert(proxy.members.begin() + 1,
                       member::object("tool", {"tool",
                                               "The simulated tool.",
                                               {member::quantity(terms.inertia_name, terms.inertia)
                                                    .required()
                                                    .above(0)
                                                    .doc("Of the tool.")}})
                           .required()
                           .doc("The simulated tool."));
  return {
      {"virtual_coupling",
       "A spring and damper between the device and a simulated tool, which may meet a wall.",
       {
           coupling("Between device and tool."),
           member::object("tool", tool_spec(terms)).required().doc("The simulated tool."),
           member::variant("environment", tool_environment_specs(terms))
               .by_default({{"kind", "none"}})
               .doc("What the tool meets."),
           integration(),
           substeps(),
           update(),
       }},
      {"direct",
       "A deformable object touched by the device itself: the contact's effort is held between "
       "updates.",
       scene_members(terms, contact("Between device and surface.").required())},
      std::move(proxy),
      {"equivalent_impedance",
       "A deformable object whose impedance, not its effort, is conveyed: the fast loop moves a "
       "copy of it.",
       scene_members(terms, contact("Between device and the fast loop's copy of the object; the "
                                    "stiffer, the nearer to the object itself.")
                                .required())},
  };
}

std::optional<Law> parse_environment(const json& c, const Rational& period,
                                     const std::optional<Rational>& slow_period) {
  const std::string kind = c["kind"];
  if (kind == "virtual_coupling") {
    VirtualCoupling law{spring_damper_of(c["coupling"]),
                        find_inertia(c["tool"]),
                        c["tool"]["damping"],
                        {},
                        integration_of(c["integration"]),
                        c["substeps"],
                        update_of(c["update"], period, slow_period)};
    if (const json& e = c["environment"]; e["kind"] == "virtual_wall")
      law.wall = ToolWall{spring_damper_of(e), e["position"], e["unilateral"]};
    return law;
  }
  if (kind != "direct" && kind != "proxy" && kind != "equivalent_impedance") return std::nullopt;
  const json& o = c["object"];
  const json& contact = c["contact"].is_null() ? c["coupling"] : c["contact"];
  const DeformableScene scene{{find_inertia(o), spring_damper_of(o), o["position"]},
                              spring_damper_of(contact),
                              c["unilateral"],
                              integration_of(c["integration"]),
                              c["substeps"],
                              update_of(c["update"], period, slow_period)};
  if (kind == "direct") return DirectRendering{scene};
  if (kind == "proxy")
    return ProxyRendering{scene, find_inertia(c["tool"]), spring_damper_of(c["coupling"])};
  return EquivalentImpedance{scene};
}

const SlowUpdate* find_update(const Law& law) {
  if (const auto* coupling = std::get_if<VirtualCoupling>(&law)) return &coupling->update;
  if (const auto* direct = std::get_if<DirectRendering>(&law)) return &direct->scene.update;
  if (const auto* proxy = std::get_if<ProxyRendering>(&law)) return &proxy->scene.update;
  if (const auto* equivalent = std::get_if<EquivalentImpedance>(&law))
    return &equivalent->scene.update;
  return nullptr;
}

void check_environment(const Controller& controller, const Rational& period,
                       const std::optional<Rational>& slow_period) {
  const SlowUpdate* update = find_update(controller.law);
  if (!update && slow_period) {
    throw Error(ErrorCode::bad_input, "sampling/slow_period",
                fmt::format("{:g} s: no environment of this controller has a rate of its own; "
                            "virtual_coupling, direct, proxy and equivalent_impedance have",
                            slow_period->to_double()));
  }
  if (!update) return;
  try {
    SlowClock(*update, period);
  } catch (const Error& error) {
    const bool inherited = slow_period && update->period == slow_period;
    const bool of_period = error.place() == "controller/update/period";
    throw Error(error.code(), inherited && of_period ? "sampling/slow_period" : error.place(),
                error.message());
  }
}

}  // namespace gyrator
