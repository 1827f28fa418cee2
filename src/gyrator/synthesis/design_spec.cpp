#include "gyrator/synthesis/design_spec.hpp"

#include "gyrator/core/error.hpp"
#include "gyrator/documents/document_reader.hpp"
#include "gyrator/documents/json_text.hpp"
#include "gyrator/studies/limit_sampler.hpp"
#include "gyrator/studies/motion_terms.hpp"

#include <algorithm>
#include <filesystem>

#include <fmt/core.h>

namespace gyrator {
namespace {

using nlohmann::json;

constexpr int dampings_of_a_range = 5;

[[noreturn]] void refuse(const std::string& place, const std::string& message) {
  throw Error(ErrorCode::bad_input, place, message);
}

std::vector<BoundedFigure> make_bounded_figures(Motion motion) {
  const MotionUnits& units = units_of(motion);
  return {
      {"max_stiffness", units.stiffness, true, false,
       [](const DesignFigures& f) { return f.max_stiffness; },
       "Largest passive stiffness, at least."},
      {"apparent_inertia", units.inertia, false, false,
       [](const DesignFigures& f) { return f.apparent_inertia; },
       "That the circuit adds to the rotor's below its corner (K_t² C of an rc), at most."},
      {"damping_below_5_hz", units.damping, false, false,
       [](const DesignFigures& f) { return f.damping_below_5_hz; },
       "Damping felt in slow motion, the device's own included, at most."},
      {"resistor_power", dimension::power, false, true,
       [](const DesignFigures& f) { return f.extremes.resistor_power; },
       "Peak in the resistor during `operation`, at most."},
      {"capacitor_voltage", dimension::voltage, false, true,
       [](const DesignFigures& f) { return f.extremes.capacitor_voltage; },
       "Peak across the capacitor during `operation`, at most."},
      {"amplifier_voltage", dimension::voltage, false, true,
       [](const DesignFigures& f) { return f.extremes.amplifier_voltage; },
       "Peak that the amplifier must give during `operation`, at most."},
      {"amplifier_current", dimension::current, false, true,
       [](const DesignFigures& f) { return f.extremes.amplifier_current; },
       "The same of its current."},
  };
}

ObjectSpec constraints_spec(Motion motion) {
  ObjectSpec spec{"constraints", "What a design must keep.", {}};
  for (const BoundedFigure& figure : list_bounded_figures(motion)) {
    const char* end = figure.is_minimum ? "min" : "max";
    spec.members.push_back(
        member::object(figure.name,
                       {"bound",
                        "A bound.",
                        {member::quantity(end, figure.unit).required().above(0).doc("The bound.")}})
            .doc(figure.meaning));
  }
  return spec;
}

ObjectSpec ranges_spec(Motion motion) {
  ObjectSpec spec{"ranges", "Where values are looked for.", {}};
  for (const Topology& topology : list_topologies(motion)) {
    for (const DesignVariable& variable : topology.variables) {
      spec.members.push_back(member::quantity(name_of(topology, variable), variable.unit)
                                 .above(0)
                                 .list(2, 2)
                                 .doc(variable.meaning + " Lowest and highest value."));
    }
  }
  return spec;
}

std::vector<std::string> topology_names() {
  std::vector<std::string> names;
  for (const Topology& topology : list_topologies(Motion::rotary)) names.push_back(topology.name);
  return names;
}

std::vector<std::string> series_names() {
  std::vector<std::string> names;
  for (const auto& series : preferred_series_names()) names.emplace_back(series.name);
  names.emplace_back("none");
  return names;
}

ObjectSpec objective_spec(const MotionUnits& units) {
  return {"objective",
          "What is best.",
          {member::choice("maximize", {"stiffness"}).doc("The stiffest passive wall."),
           member::choice("minimize", {"apparent_inertia"})
               .doc("The least inertia that carries a wall of `stiffness`."),
           member::quantity("stiffness", units.stiffness)
               .above(0)
               .doc("Of the wanted wall; with maximize: at least."),
           member::quantity("virtual_damping", units.damping)
               .doc("B of the wall; absent: the model's."),
           member::quantity("virtual_damping_to", units.damping)
               .doc("Other end of a range of B; the mean of the limit over it is what counts.")},
          {{"maximize", "minimize"}}};
}

ObjectSpec operation_spec(const MotionUnits& units) {
  return {"operation",
          "At which the extremes are taken: motion and wall at once, in the worst phase.",
          {member::quantity("speed", units.velocity).by_default(0).at_least(0).doc("Amplitude."),
           member::quantity("effort", units.effort)
               .by_default(0)
               .at_least(0)
               .doc("Amplitude of what the wall commands."),
           member::quantity("frequency", dimension::frequency)
               .by_default(10)
               .above(1e-3)
               .doc("Up to which both may alternate.")}};
}

ObjectSpec make_format(Motion motion) {
  const MotionTerms& terms = terms_of(motion);
  const auto tolerance = [](const char* name, double value) {
    return member::number(name).by_default(value).at_least(0).below(1);
  };
  return {
      terms.name,
      "What `gyrator design` is asked for.",
      {
          member::choice("schema", {design_schema_name}).required().doc("Version of the format."),
          member::text("model").required().doc("Model file of the device, relative to this one's."),
          member::object("objective", objective_spec(terms))
              .by_default({{"maximize", "stiffness"}})
              .doc("What is best."),
          member::choice("topologies", topology_names())
              .list(1)
              .by_default(topology_names())
              .doc("Dampings to choose from."),
          member::choice("series", series_names())
              .by_default("E24")
              .doc("Preferred values of the parts; none: any value."),
          member::object("ranges", ranges_spec(motion))
              .by_default(json::object())
              .doc("Where values are looked for."),
          member::object("constraints", constraints_spec(motion))
              .by_default(json::object())
              .doc("What a design must keep, at every temperature."),
          member::object("operation", operation_spec(terms))
              .by_default(json::object())
              .doc("For the constraints on power, voltage and current."),
          member::quantity("winding_rise", dimension::temperature)
              .list(2, 2)
              .doc("Coldest and warmest winding, above the reference temperature; the worst over "
                   "it counts. Absent: the model's."),
          member::boolean("bipolar_capacitor")
              .by_default(true)
              .doc("Whether bipolar capacitors can be had; false: two polarised ones back to back, "
                   "of twice the value each."),
          member::object("tolerance", {"tolerance",
                                       "Of the parts, for the yield.",
                                       {tolerance("resistance", 0.01).doc("± of resistors."),
                                        tolerance("capacitance", 0.2).doc("± of capacitors.")}})
              .by_default(json::object())
              .doc("Of the parts, for the yield; the model's own tolerances count too."),
          member::number("rated_share")
              .by_default(0.9)
              .above(0)
              .at_most(1)
              .doc("Of max_stiffness: what a stiffest design promises, in the model file and for "
                   "the yield."),
          member::integer("samples").by_default(1000).at_least(1).at_most(1e6).doc(
              "Devices drawn for the yield."),
          member::integer("designs").by_default(3).at_least(1).at_most(100).doc("To report."),
          member::integer("seed").by_default(1).at_least(0).doc("The same gives the same."),
      }};
}

// The device alone: what the design chooses is taken out.
json strip_designed(json model) {
  if (!model.contains("damping") || !model["damping"].is_array()) return model;
  const auto names = topology_names();
  json kept = json::array();
  for (const json& damping : model["damping"]) {
    const bool chosen = damping.is_object() && damping.contains("kind") &&
                        std::find(names.begin(), names.end(), damping["kind"]) != names.end();
    if (!chosen) kept.push_back(damping);
  }
  model["damping"] = std::move(kept);
  return model;
}

std::string kind_of(const json& model, const char* key, const char* fallback) {
  if (!model.contains(key) || !model[key].is_object()) return fallback;
  return model[key].value("kind", fallback);
}

Model load_device(const std::string& path) {
  const json document = strip_designed(load_json_file(path));
  Model model = parse_model(document, path);
  if (!model.device.drive.motor)
    refuse(path + ": /motor", "missing: without a motor there is nothing to damp electrically");
  const std::string kind = kind_of(document, "controller", "virtual_wall");
  if (kind != "virtual_wall" && kind != "predictive_wall") {
    refuse(path + ": /controller/kind",
           fmt::format("\"{}\": a design needs a wall whose stiffness it can set: virtual_wall or "
                       "predictive_wall",
                       kind));
  }
  return model;
}

void read_ranges(DesignSpec& spec, const json& read) {
  const Motor& motor = *spec.model.device.drive.motor;
  for (const Topology* topology : spec.topologies) {
    for (const DesignVariable& variable : topology->variables) {
      const std::string name = name_of(*topology, variable);
      DesignRange range{variable.low(motor), variable.high(motor)};
      if (const json& given = read["ranges"].value(name, json()); !given.is_null())
        range = {given[0], given[1]};
      if (range.low > range.high)
        refuse(spec.file + ": /ranges/" + name, "the lowest value is above the highest");
      spec.ranges[name] = range;
    }
  }
}

void read_objective(DesignSpec& spec, const json& read) {
  const json& objective = read["objective"];
  const std::string place = spec.file + ": /objective";
  const double first = objective["virtual_damping"].is_null()
                           ? require_wall(spec.model).damping
                           : objective["virtual_damping"].get<double>();
  spec.damping = {first};
  if (const json& to = objective["virtual_damping_to"]; !to.is_null()) {
    if (to.get<double>() <= first)
      refuse(place + "/virtual_damping_to",
             fmt::format("{:g}: must be above virtual_damping, {:g}", to.get<double>(), first));
    for (int i = 1; i < dampings_of_a_range; ++i)
      spec.damping.push_back(first + (to.get<double>() - first) * i / (dampings_of_a_range - 1));
  }
  if (!objective["minimize"].is_null()) spec.objective = DesignObjective::lightest;
  const json& stiffness = objective["stiffness"];
  if (spec.objective == DesignObjective::lightest && stiffness.is_null())
    refuse(place, "minimize needs the wanted wall: add \"stiffness\"");
  if (!stiffness.is_null())
    spec.constraints.push_back(
        {&list_bounded_figures(spec.model.device.motion).front(), stiffness.get<double>()});
}

void read_constraints(DesignSpec& spec, const json& read) {
  for (const BoundedFigure& figure : list_bounded_figures(spec.model.device.motion)) {
    const json& bound = read["constraints"].value(figure.name, json());
    if (bound.is_null()) continue;
    spec.constraints.push_back({&figure, bound[figure.is_minimum ? "min" : "max"]});
    const bool still = spec.operation.speed == 0 && spec.operation.effort == 0;
    if (figure.is_extreme && still)
      refuse(spec.file + ": /operation",
             fmt::format("missing: {} is bounded at a given speed or effort", figure.name));
  }
}

}  // namespace

const std::vector<BoundedFigure>& list_bounded_figures(Motion motion) {
  static const std::vector<BoundedFigure> rotary = make_bounded_figures(Motion::rotary);
  static const std::vector<BoundedFigure> linear = make_bounded_figures(Motion::linear);
  return motion == Motion::rotary ? rotary : linear;
}

const Member& design_format() {
  static const Member format =
      member::variant("design", {make_format(Motion::rotary), make_format(Motion::linear)},
                      "motion")
          .kind_by_default("rotary")
          .doc("What `gyrator design` is asked for.");
  return format;
}

DesignSpec load_design_spec(const std::string& path) {
  return parse_design_spec(load_json_file(path), path);
}

DesignSpec parse_design_spec(const json& document, const std::string& path) {
  const json read = read_document(document, design_format(), path);
  DesignSpec spec;
  spec.file = path;
  spec.source = document;
  const auto model_path =
      std::filesystem::path(path).parent_path() / read["model"].get<std::string>();
  spec.model = load_device(model_path.string());
  const std::string motion = terms_of(spec.model.device.motion).name;
  if (read["motion"] != motion)
    refuse(path + ": /motion", fmt::format("\"{}\": the model's motion is {}",
                                           read["motion"].get<std::string>(), motion));
  for (const Topology& topology : list_topologies(spec.model.device.motion)) {
    const json& wanted = read["topologies"];
    if (std::find(wanted.begin(), wanted.end(), topology.name) != wanted.end())
      spec.topologies.push_back(&topology);
  }
  for (const auto& [series, name] : preferred_series_names())
    if (read["series"] == name) spec.series = series;
  const json& operation = read["operation"];
  spec.operation = {operation["speed"], operation["effort"], operation["frequency"]};
  if (const json& rise = read["winding_rise"]; !rise.is_null()) {
    spec.winding_rise = DesignRange{rise[0], rise[1]};
    const double own = spec.model.device.drive.motor->temperature_rise;
    if (own < spec.winding_rise->low || own > spec.winding_rise->high)
      refuse(path + ": /winding_rise",
             fmt::format("must include the model's own temperature_rise, {}",
                         format_quantity(own, dimension::temperature)));
  }
  read_ranges(spec, read);
  read_objective(spec, read);
  read_constraints(spec, read);
  spec.bipolar_capacitor = read["bipolar_capacitor"];
  spec.tolerances = {{DesignPart::resistor, read["tolerance"]["resistance"]},
                     {DesignPart::capacitor, read["tolerance"]["capacitance"]},
                     {DesignPart::setting, 0.0}};
  spec.rated_share = read["rated_share"];
  spec.samples = read["samples"];
  spec.count = read["designs"];
  spec.seed = read["seed"];
  return spec;
}

json make_designed_model(const DesignSpec& spec, const Topology& topology,
                         const std::vector<json>& values) {
  json model = spec.model.source;
  json damping{{"kind", topology.name}};
  for (std::size_t i = 0; i < values.size(); ++i) damping[topology.variables[i].key] = values[i];
  if (!model.contains("damping")) model["damping"] = json::array();
  model["damping"].push_back(std::move(damping));
  const std::string kind = kind_of(model, "amplifier", "current");
  const std::string wanted = topology.voltage_drive ? "voltage"
                             : kind == "voltage"    ? "current"
                                                    : kind;
  if (kind != wanted) {
    json amplifier{{"kind", wanted}};
    if (model.contains("amplifier") && model["amplifier"].contains("bandwidth"))
      amplifier["bandwidth"] = model["amplifier"]["bandwidth"];
    model["amplifier"] = std::move(amplifier);
  }
  return model;
}

}  // namespace gyrator
