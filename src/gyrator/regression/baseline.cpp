#include "gyrator/regression/baseline.hpp"

#include "gyrator/core/error.hpp"
#include "gyrator/documents/document_reader.hpp"
#include "gyrator/documents/json_text.hpp"

#include <fmt/core.h>

namespace gyrator {
namespace {

using nlohmann::json;
namespace fs = std::filesystem;

const ObjectSpec& baseline_spec() {
  static const ObjectSpec spec{
      "baseline",
      "What a study's figures were.",
      {member::choice("schema", {baseline_schema_name}).required().doc("Version of the format."),
       member::text("study").required().doc("Its name."),
       member::anything("runs").required().doc("Run → figures and provenance.")}};
  return spec;
}

const ObjectSpec& run_spec() {
  static const ObjectSpec spec{
      "run",
      "Figures of a run.",
      {member::anything("provenance").required().doc("What they came from."),
       member::anything("figures").required().doc("Name → value, unit and tolerance.")}};
  return spec;
}

const ObjectSpec& figure_spec() {
  static const ObjectSpec spec{"figure",
                               "A value.",
                               {member::anything("value").doc("As it was; null: none."),
                                member::text("unit").by_default("").doc("SI."),
                                member::text("tolerance").by_default("").doc("In words.")}};
  return spec;
}

json read_at(const json& value, const ObjectSpec& spec, const std::string& place) {
  try {
    return read_document(value, spec, "");
  } catch (const Error& error) {
    throw Error(error.code(), place + (error.place() == "/" ? "" : error.place()), error.message());
  }
}

void check_object(const json& value, const std::string& place) {
  if (!value.is_object()) throw Error(ErrorCode::bad_input, place, "an object is expected");
}

}  // namespace

std::string baseline_name(const std::string& study_file) {
  fs::path path = study_file;
  return path.replace_extension(".baseline.json").string();
}

fs::path reference_trace_name(const std::string& study_file, const RegressionRun& run,
                              std::size_t point) {
  fs::path folder = study_file;
  folder.replace_extension(".baseline");
  return folder /
         (run.vary.empty() ? run.name + ".csv" : fmt::format("{}.{}.csv", run.name, point));
}

std::optional<Baseline> load_baseline(const std::string& study_file) {
  const std::string name = baseline_name(study_file);
  std::error_code ignored;
  if (!fs::exists(name, ignored)) return std::nullopt;
  return parse_baseline(load_json_file(name), name);
}

Baseline parse_baseline(const json& document, const std::string& file) {
  const json read = read_document(document, baseline_spec(), file);
  Baseline baseline;
  baseline.study = read["study"];
  check_object(read["runs"], file + ": /runs");
  for (const auto& [name, value] : read["runs"].items()) {
    const std::string place = fmt::format("{}: /runs/{}", file, name);
    const json run = read_at(value, run_spec(), place);
    BaselineRun& entry = baseline.runs[name];
    entry.provenance = run["provenance"];
    check_object(entry.provenance, place + "/provenance");
    check_object(run["figures"], place + "/figures");
    for (const auto& [figure_name, figure_value] : run["figures"].items()) {
      const json figure =
          read_at(figure_value, figure_spec(), fmt::format("{}/figures/{}", place, figure_name));
      entry.figures[figure_name] = {figure["value"], figure["unit"], figure["tolerance"]};
    }
  }
  return baseline;
}

std::string write_baseline_text(const Baseline& baseline) {
  json runs = json::object();
  for (const auto& [name, run] : baseline.runs) {
    json figures = json::object();
    for (const auto& [figure_name, figure] : run.figures) {
      json entry{{"value", figure.value}};
      if (!figure.unit.empty()) entry["unit"] = figure.unit;
      if (!figure.tolerance.empty()) entry["tolerance"] = figure.tolerance;
      figures[figure_name] = std::move(entry);
    }
    runs[name] = {{"provenance", run.provenance}, {"figures", std::move(figures)}};
  }
  const json document{
      {"schema", baseline_schema_name}, {"study", baseline.study}, {"runs", std::move(runs)}};
  return document.dump(1, ' ', false, json::error_handler_t::replace) + "\n";
}

}  // namespace gyrator
