#include "gyrator/sweeps/sweep_study.hpp"

#include "gyrator/core/error.hpp"
#include "gyrator/documents/document_reader.hpp"
#include "gyrator/documents/json_text.hpp"
#include "gyrator/sweeps/sweep_analyses.hpp"

#include <array>
#include <filesystem>
#include <utility>

#include <fmt/core.h>

namespace gyrator {
namespace {

using nlohmann::json;

ObjectSpec variation_spec() {
  return {"variation",
          "A value of the model that varies: a list of values, or a range.",
          {
              member::text("path").required().doc(
                  "Where it stands in the model: \"damping.0.capacitance\", items of lists by "
                  "their number from 0."),
              member::anything("values").doc("List of values, with units as in the model."),
              member::anything("from").doc("First value of a range, with its unit."),
              member::anything("to").doc("Last value."),
              member::integer("points").at_least(1).at_most(1e8).doc(
                  "How many values of the range a grid has."),
              member::choice("scale", {"linear", "log"})
                  .by_default("linear")
                  .doc("How the range is divided."),
          },
          {{"values", "from"}},
          {{"values", "to"}, {"values", "points"}}};
}

std::vector<ObjectSpec> sampling_specs() {
  const auto samples = [] {
    return member::integer("samples").required().at_least(1).at_most(1e8).doc("How many.");
  };
  return {{"grid", "Every combination of the values; the last variation changes fastest.", {}},
          {"sobol", "The first points of the Sobol sequence.", {samples()}},
          {"random",
           "Evenly distributed points.",
           {samples(), member::integer("seed").by_default(1).at_least(0).doc(
                           "The same seed gives the same points.")}}};
}

std::vector<std::string> analysis_names() {
  std::vector<std::string> names;
  for (const SweepAnalysis& analysis : sweep_analyses()) names.emplace_back(analysis.name);
  return names;
}

VariationText read_variation(const json& entry, const std::string& place) {
  VariationText text;
  text.place = place;
  text.path = entry["path"];
  text.logarithmic = entry["scale"] == "log";
  const auto refuse = [&](const char* message) {
    throw Error(ErrorCode::bad_input, place, message);
  };
  if (!entry["values"].is_null()) {
    if (!entry["values"].is_array() || entry["values"].empty())
      refuse("\"values\" must be a list of at least one value");
    for (const json& value : entry["values"]) text.values.push_back(value);
    return text;
  }
  if (entry["to"].is_null()) refuse("\"from\" without \"to\": give both ends of the range");
  text.from = entry["from"];
  text.to = entry["to"];
  if (!entry["points"].is_null()) text.points = entry["points"];
  return text;
}

}  // namespace

std::string_view name_of(SamplingKind kind) {
  constexpr std::array<std::string_view, 3> names{"grid", "sobol", "random"};
  return names.at(static_cast<std::size_t>(kind));
}

const Member& study_format() {
  static const Member format = member::object(
      "study",
      {"study",
       "A sweep: a model, what varies in it, and the analysis of each point.",
       {
           member::choice("schema", {study_schema_name}).required().doc("Version of the format."),
           member::text("model").required().doc("Model file, relative to the study's."),
           member::choice("analysis", analysis_names()).required().doc("Of each point."),
           member::object("vary", variation_spec()).list(1).required().doc("What varies."),
           member::variant("sampling", sampling_specs())
               .by_default({{"kind", "grid"}})
               .doc("Which points are computed."),
           member::quantity("timeout", dimension::time)
               .above(0)
               .doc("Of one point; one that takes longer is recorded as timed out. Absent: none."),
           member::boolean("keep_going")
               .by_default(false)
               .doc("Record points that fail and go on with the rest, instead of stopping."),
       }});
  return format;
}

bool is_study(const json& document) {
  if (!document.is_object()) return false;
  const auto schema = document.find("schema");
  return schema != document.end() && schema->is_string() &&
         schema->get<std::string>().starts_with("gyrator/study/");
}

SweepStudy load_study(const std::string& path) {
  SweepStudy study = parse_study(load_json_file(path), path);
  study.model_file = (std::filesystem::path(path).parent_path() / study.model_file).string();
  study.model_text = load_json_text(study.model_file);
  return study;
}

SweepStudy parse_study(const json& document, const std::string& path) {
  const json read = read_document(document, study_format(), path);
  SweepStudy study;
  study.file = path;
  study.model_file = read["model"];
  study.analysis = read["analysis"];
  for (std::size_t i = 0; i < read["vary"].size(); ++i)
    study.vary.push_back(read_variation(read["vary"][i], fmt::format("{}: /vary/{}", path, i)));
  const json& sampling = read["sampling"];
  if (sampling["kind"] != "grid") {
    study.sampling = sampling["kind"] == "sobol" ? SamplingKind::sobol : SamplingKind::random;
    study.samples = sampling["samples"];
    if (sampling.contains("seed")) study.seed = sampling["seed"];
  }
  if (!read["timeout"].is_null()) study.timeout_s = read["timeout"];
  study.keep_going = read["keep_going"];
  return study;
}

json describe_study(const SweepStudy& study) {
  json sampling{{"kind", name_of(study.sampling)}};
  if (study.sampling != SamplingKind::grid) sampling["samples"] = study.samples;
  if (study.sampling == SamplingKind::random) sampling["seed"] = study.seed;
  json vary = json::array();
  for (const VariationText& text : study.vary) vary.push_back(describe_variation(text));
  return {{"schema", study_schema_name},
          {"model", std::filesystem::path(study.model_file).filename().string()},
          {"analysis", study.analysis},
          {"vary", std::move(vary)},
          {"sampling", std::move(sampling)}};
}

}  // namespace gyrator
