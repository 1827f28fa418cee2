#include "gyrator/synthesis/design_spec.hpp"

#include "gyrator/core/error.hpp"
#include "gyrator/documents/document_kind.hpp"
#include "gyrator/documents/document_reader.hpp"
#include "gyrator/documents/json_text.hpp"
#include "gyrator/passivity/held_limit.hpp"
#include "gyrator/studies/limit_sampler.hpp"
#include "gyrator/studies/motion_terms.hpp"
#include "gyrator/synthesis/digital_stage.hpp"

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

// The device alone: what the design chooses is taken out.
json strip_designed(json model) {
  if (!model.contains("damping") || !model["damping"].is_array()) return model;
  const auto& topologies = list_topologies(Motion::rotary);  // the same names as linear
  json kept = json::array();
  for (const json& damping : model["damping"]) {
    const bool chosen =
        damping.is_object() && damping.contains("kind") &&
        std::any_of(topologies.begin(), topologies.end(),
                    [&](const Topology& topology) { return damping["kind"] == topology.name; });
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

// Whether the model's own controller has the stage.
bool has_pre_emphasis(const Model& model) {
  return model.source.contains("/controller/pre_emphasis"_json_pointer) &&
         model.source.at("/controller/pre_emphasis"_json_pointer).is_object();
}

DesignRange read_range(const json& given, const Unit& unit, const std::string& place) {
  const DesignRange range{given[0], given[1]};
  if (range.low > range.high) {
    refuse(place, fmt::format("{} to {}: the lowest value is above the highest",
                              format_quantity(range.low, unit), format_quantity(range.high, unit)));
  }
  return range;
}

std::vector<SoughtValue> read_ranges(const DesignSpec& spec, const Topology& topology,
                                     const json& read) {
  const Motor& motor = *spec.model.device.drive.motor;
  std::vector<SoughtValue> values;
  for (const DesignVariable& variable : topology.variables) {
    const std::string name = name_of(topology, variable);
    DesignRange range{variable.low(motor), variable.high(motor)};
    if (const json& given = read["ranges"].value(name, json()); !given.is_null())
      range = read_range(given, variable.unit, spec.file + ": /ranges/" + name);
    values.push_back({name, variable.part, variable.unit, range});
  }
  return values;
}

// The cut-offs that may be chosen; none where the estimator stays as it is.
std::optional<SoughtValue> read_cutoff(const DesignSpec& spec, const json& digital) {
  const json& given = digital["velocity_cutoff"];
  if (given.is_null()) return std::nullopt;
  const std::string place = spec.file + ": /digital/velocity_cutoff";
  const DesignRange range = read_range(given, dimension::frequency, place);
  const Controller controller = spec.model.sampled_controller();
  const auto* wall = std::get_if<VirtualWall>(&controller.law);
  if (!wall)
    refuse(place, "only a virtual_wall of the sampled controller has an estimator to be chosen");
  try {
    check_velocity_estimator(with_cutoff(wall->velocity, range.high),
                             spec.model.sampling.period.to_double());
  } catch (const Error& error) {
    refuse(place, error.message());
  }
  return SoughtValue{velocity_cutoff_name, DesignPart::setting, dimension::frequency, range};
}

// Every topology as the model's controller would drive it, and with what may be changed there.
void read_options(DesignSpec& spec, const json& read) {
  const json& digital = read["digital"];
  const json& emphasis = digital["pre_emphasis"];
  std::vector<bool> stages;
  if (emphasis.is_null()) {
    stages = {has_pre_emphasis(spec.model)};
  } else if (emphasis.get<bool>()) {
    stages = {false, true};
  } else {
    stages = {false};
  }
  if (stages.back() && find_held_impedance(spec.model.device))
    refuse(spec.file + ": /digital/pre_emphasis",
           "true with held_impedance: no command is left to emphasize");
  const auto cutoff = read_cutoff(spec, digital);
  const json& wanted = read["topologies"];
  for (const Topology& topology : list_topologies(spec.model.device.motion)) {
    if (std::find(wanted.begin(), wanted.end(), topology.name) == wanted.end()) continue;
    for (const bool stage : stages) {
      DesignOption option{&topology, stage, false, read_ranges(spec, topology, read)};
      spec.options.push_back(option);
      if (!cutoff) continue;
      option.velocity_filter = true;
      option.values.push_back(*cutoff);
      spec.options.push_back(option);
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
  constexpr double most_emphasis = 10;
  const std::string gain = "emphasis_gain";
  if (!mentions_pre_emphasis(spec) || !read["constraints"].value(gain, json()).is_null()) return;
  for (const BoundedFigure& figure : list_bounded_figures(spec.model.device.motion))
    if (gain == figure.name) spec.constraints.push_back({&figure, most_emphasis});
}

void set_digital_stage(json& model, const DesignOption& option, const json& last_value) {
  if (!option.pre_emphasis) {
    if (model.contains("controller")) model["controller"].erase("pre_emphasis");
  } else if (!model["controller"].contains("pre_emphasis")) {
    model["controller"]["pre_emphasis"] = json::object();
  }
  if (!option.velocity_filter) return;
  json& controller = model["controller"];
  if (!controller.contains("velocity") || controller["velocity"]["kind"] != "butterworth")
    controller["velocity"] = {{"kind", "filtered_difference"}};
  controller["velocity"]["cutoff"] = last_value;
}

}  // namespace

DesignSpec load_design_spec(const std::string& path) {
  return parse_design_spec(load_json_file(path), path);
}

DesignSpec parse_design_spec(const json& document, const std::string& path) {
  check_document_kind(document, design_schema_name, path);
  const json read = read_document(document, design_format(), path);
  DesignSpec spec;
  spec.file = path;
  spec.source = document;
  const auto model_path =
      std::filesystem::path(path).parent_path() / read["model"].get<std::string>();
  if (!std::filesystem::exists(model_path)) {
    refuse(path + ": /model", fmt::format("'{}': there is no such file beside the spec",
                                          read["model"].get<std::string>()));
  }
  spec.model = load_device(model_path.string());
  const std::string motion = terms_of(spec.model.device.motion).name;
  if (read["motion"] != motion)
    refuse(path + ": /motion", fmt::format("\"{}\": the model's motion is {}",
                                           read["motion"].get<std::string>(), motion));
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
  read_options(spec, read);
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

bool mentions_pre_emphasis(const DesignSpec& spec) {
  return std::any_of(spec.options.begin(), spec.options.end(),
                     [](const DesignOption& option) { return option.pre_emphasis; });
}

json make_designed_model(const DesignSpec& spec, const DesignOption& option,
                         const std::vector<json>& values) {
  json model = spec.model.source;
  const Topology& topology = *option.topology;
  json damping{{"kind", topology.name}};
  for (std::size_t i = 0; i < topology.variables.size(); ++i)
    damping[topology.variables[i].key] = values[i];
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
  set_digital_stage(model, option, values.back());
  return model;
}

}  // namespace gyrator
