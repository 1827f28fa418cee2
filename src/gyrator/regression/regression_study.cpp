#include "gyrator/regression/regression_study.hpp"

#include "gyrator/core/error.hpp"
#include "gyrator/core/quantity.hpp"
#include "gyrator/core/text.hpp"
#include "gyrator/documents/document_reader.hpp"
#include "gyrator/documents/json_text.hpp"
#include "gyrator/regression/answer_path.hpp"

#include <algorithm>
#include <cctype>
#include <cmath>

#include <fmt/core.h>

namespace gyrator {
namespace {

using nlohmann::json;

[[noreturn]] void refuse(const std::string& place, const std::string& message) {
  throw Error(ErrorCode::bad_input, place, message);
}

// Names become file names.
void check_name(const std::string& name, const std::string& place) {
  const bool is_plain = !name.empty() && std::all_of(name.begin(), name.end(), [](char c) {
    return std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '_' || c == '-';
  });
  if (!is_plain)
    refuse(place, fmt::format("'{}': a name is made of letters, digits, '_' and '-'", name));
}

void check_once(const std::vector<std::string>& names, const std::string& place) {
  if (const auto twice = find_repeated(names))
    refuse(place, fmt::format("'{}': is there twice: names tell apart", *twice));
}

// Answers are in SI units: a tolerance in "mN" would be read for one in N.
Dimension read_si_unit(const std::string& unit, const std::string& place) {
  try {
    const Quantity one = parse_quantity("1 " + unit);
    if (one.value != 1) {
      refuse(place, fmt::format("'{}': is {} SI units: answers are in SI units", unit,
                                format_number(one.value)));
    }
    return one.dimension.value_or(Dimension{});
  } catch (const Error& error) {
    throw Error(error.code(), place, error.message());
  }
}

double read_absolute(const json& given, const std::string& unit, const std::string& place) {
  double value = 0;
  if (given.is_number()) {
    value = given.get<double>();
  } else if (given.is_string()) {
    try {
      const Quantity quantity = parse_quantity(given.get<std::string>());
      value = quantity.value;
      if (quantity.dimension && !unit.empty()) {
        Dimension found = *quantity.dimension;
        Dimension expected = read_si_unit(unit, place);
        found.angle = expected.angle = 0;
        if (found != expected) {
          refuse(place, fmt::format("'{}' is {}: the figure is in {}", given.get<std::string>(),
                                    describe_dimension(*quantity.dimension), unit));
        }
      }
    } catch (const Error& error) {
      throw Error(error.code(), place, error.message());
    }
  } else {
    refuse(place, fmt::format("found {}: a number in SI units or a text with a unit is expected",
                              given.dump()));
  }
  if (!(value >= 0)) refuse(place, fmt::format("{}: must be at least 0", format_number(value)));
  return value;
}

FigureTolerance read_tolerance(const json& given, const std::string& unit,
                               const std::string& place) {
  FigureTolerance tolerance;
  tolerance.absolute = read_absolute(given["absolute"], unit, place + "/absolute");
  tolerance.relative = given["relative"];
  if (given.contains("side") && given["side"] != "both")
    tolerance.side = given["side"] == "below" ? Side::below : Side::above;
  return tolerance;
}

PublishedValue read_published(const json& given, const std::string& unit,
                              const std::string& place) {
  const json& value = given["value"];
  const bool is_list =
      value.is_array() && !value.empty() &&
      std::all_of(value.begin(), value.end(), [](const json& v) { return v.is_number(); });
  if (!value.is_number() && !is_list)
    refuse(place + "/value", "a number, or a list of numbers for a varied run, is expected");
  PublishedValue published{value, read_tolerance(given, unit, place), given["source"]};
  if (published.tolerance.absolute == 0 && published.tolerance.relative == 0)
    refuse(place, R"(needs "absolute" or "relative": how near the published value is to be)");
  return published;
}

Expectation read_expectation(const json& given, const FigureTolerance& usual,
                             const std::string& place) {
  Expectation expectation;
  expectation.figure = given["figure"];
  try {
    check_answer_path(expectation.figure);
  } catch (const Error& error) {
    refuse(place + "/figure", error.message());
  }
  expectation.name = given["name"].is_null() ? expectation.figure : std::string(given["name"]);
  if (expectation.name.empty()) refuse(place + "/name", "is empty");
  if (!given["unit"].is_null()) {
    expectation.unit = given["unit"];
    read_si_unit(expectation.unit, place + "/unit");
  }
  expectation.equals = given["equals"];
  expectation.is_none = given["none"];
  if (!given["at_least"].is_null()) expectation.at_least = given["at_least"].get<double>();
  if (!given["at_most"].is_null()) expectation.at_most = given["at_most"].get<double>();
  const bool is_fixed = !expectation.equals.is_null() || expectation.is_none ||
                        expectation.at_least || expectation.at_most;
  if (!given["tolerance"].is_null()) {
    expectation.tolerance =
        read_tolerance(given["tolerance"], expectation.unit, place + "/tolerance");
  } else if (!is_fixed) {
    expectation.tolerance = usual;
  }
  if (!given["published"].is_null())
    expectation.published =
        read_published(given["published"], expectation.unit, place + "/published");
  return expectation;
}

TraceExpectation read_trace(const json& given, const std::string& place) {
  static const ObjectSpec column_spec{
      "column",
      "Tolerance of a column.",
      {member::anything("absolute").by_default(0).doc("With its unit."),
       member::number("relative").by_default(0).at_least(0).doc("Share of the span.")}};
  TraceExpectation trace;
  trace.time_s = given["time"];
  const json& columns = given["columns"];
  if (!columns.is_object() || columns.empty())
    refuse(place + "/columns",
           "at least one column with its tolerance is expected, such as "
           "{\"position\": {\"absolute\": \"1e-6 rad\"}}");
  for (const auto& [name, value] : columns.items()) {
    const std::string at = fmt::format("{}/columns/{}", place, name);
    json read;
    try {
      read = read_document(value, column_spec, "");
    } catch (const Error& error) {
      refuse(at + (error.place() == "/" ? "" : error.place()), error.message());
    }
    TubeColumn column{name, read_absolute(read["absolute"], "", at + "/absolute"),
                      read["relative"]};
    if (column.absolute == 0 && column.relative == 0)
      refuse(at, R"(needs "absolute" or "relative": how wide the tube is)");
    trace.columns.push_back(std::move(column));
  }
  return trace;
}

std::vector<VariedValue> read_vary(const json& given, const std::string& place) {
  std::vector<VariedValue> vary;
  if (given.is_null()) return vary;
  if (!given.is_object() || given.empty())
    refuse(place,
           "paths with lists of values are expected, such as "
           "{\"sampling.delay\": [\"50 ms\", \"100 ms\"]}");
  for (const auto& [path, values] : given.items()) {
    const std::string at = fmt::format("{}/{}", place, path);
    if (!values.is_array() || values.empty())
      refuse(at, "a list of at least one value is expected");
    if (!vary.empty() && vary.front().values.size() != values.size()) {
      refuse(at, fmt::format("has {} and '{}' {}: paths vary in lockstep, value by value",
                             describe_count(values.size(), "value"), vary.front().path,
                             vary.front().values.size()));
    }
    vary.push_back({path, values.get<std::vector<json>>()});
  }
  return vary;
}

std::vector<int> read_exit_codes(const json& given, std::size_t points, const std::string& place) {
  const json list = given.is_array() ? given : json(std::vector<json>(points, given));
  if (list.size() != points) {
    refuse(place, fmt::format("has {} for {} of the run", describe_count(list.size(), "exit code"),
                              describe_count(points, "value")));
  }
  std::vector<int> codes;
  for (const json& code : list) {
    const bool is_code = code.is_number_integer() && code >= 0 && code <= 255;
    if (!is_code)
      refuse(place, fmt::format("found {}: a number from 0 to 255 is expected", code.dump()));
    codes.push_back(code.get<int>());
  }
  return codes;
}

void check_arguments(const RegressionRun& run, const std::string& place) {
  for (const std::string& argument : run.arguments) {
    for (const char* taken : {"--json", "-o", "--output", "--csv"}) {
      const std::string option = taken;
      const bool is_glued = option.size() == 2 && argument.starts_with(option);
      if (argument == option || is_glued || argument.starts_with(option + "="))
        refuse(place, fmt::format("'{}': the study itself keeps the answers", argument));
    }
  }
}

// A seed that is told twice would be one of the two, silently.
void check_seed(const RegressionRun& run, const std::string& place) {
  if (!run.seed) return;
  const std::string path = run.seed_path();
  const bool is_varied =
      std::any_of(run.vary.begin(), run.vary.end(), [&](const auto& v) { return v.path == path; });
  if (run.set.contains(path) || is_varied) {
    refuse(place, fmt::format(R"('{}' is in "{}" too: one of them is enough)", path,
                              is_varied ? "vary" : "set"));
  }
  for (const std::string& argument : run.arguments)
    if (argument == "--seed" || argument.starts_with("--seed="))
      refuse(place, "'--seed' is in \"arguments\" too: one of them is enough");
}

RegressionRun read_run(const json& given, const FigureTolerance& usual, const std::string& place) {
  RegressionRun run;
  run.name = given["name"];
  check_name(run.name, place + "/name");
  run.command = given["command"];
  run.model = given["model"];
  if (!given["set"].is_null()) run.set = given["set"];
  if (!run.set.is_object())
    refuse(place + "/set",
           "paths with values are expected, such as {\"controller.stiffness\": "
           "\"8 N/m\"}");
  run.vary = read_vary(given["vary"], place + "/vary");
  for (const VariedValue& varied : run.vary)
    if (run.set.contains(varied.path))
      refuse(place + "/vary/" + varied.path, "is in \"set\" too: one of them is enough");
  run.arguments = given["arguments"].get<std::vector<std::string>>();
  check_arguments(run, place + "/arguments");
  run.exit_codes = read_exit_codes(given["exit_code"], run.points(), place + "/exit_code");
  if (!given["seed"].is_null()) run.seed = given["seed"].get<std::uint64_t>();
  check_seed(run, place + "/seed");
  std::vector<std::string> names;
  for (std::size_t i = 0; i < given["expect"].size(); ++i) {
    run.expect.push_back(
        read_expectation(given["expect"][i], usual, fmt::format("{}/expect/{}", place, i)));
    names.push_back(run.expect.back().name);
  }
  check_once(names, place + "/expect");
  if (!given["trace"].is_null()) run.trace = read_trace(given["trace"], place + "/trace");
  if (!given["energy"].is_null()) run.energy_residual = given["energy"]["residual"].get<double>();
  if (run.command != "simulate" && (run.trace || run.energy_residual)) {
    refuse(place + (run.trace ? "/trace" : "/energy"),
           fmt::format("is of the command simulate only: '{}' has no motion", run.command));
  }
  return run;
}

StudyAxis read_axis(const json& given) {
  StudyAxis axis{given["label"], given["unit"], given["logarithmic"], {}, {}};
  if (!given["min"].is_null()) axis.min = given["min"].get<double>();
  if (!given["max"].is_null()) axis.max = given["max"].get<double>();
  return axis;
}

StudyFigure read_figure(const json& given, const std::vector<std::string>& runs,
                        const std::string& place) {
  StudyFigure figure{given["name"],
                     given["title"],
                     given["caption"],
                     read_axis(given["x"]),
                     read_axis(given["y"]),
                     {},
                     {}};
  check_name(figure.name, place + "/name");
  for (std::size_t i = 0; i < given["curves"].size(); ++i) {
    const json& curve = given["curves"][i];
    const std::string at = fmt::format("{}/curves/{}", place, i);
    if (std::find(runs.begin(), runs.end(), curve["run"]) == runs.end())
      refuse(at + "/run", describe_unknown_name("run", std::string(curve["run"]), runs));
    for (const char* axis : {"x", "y"}) {
      try {
        check_answer_path(curve[axis].get<std::string>());
      } catch (const Error& error) {
        refuse(at + "/" + axis, error.message());
      }
    }
    figure.curves.push_back({curve["run"], curve["x"], curve["y"], curve["title"], curve["style"],
                             curve["x_scale"], curve["y_scale"]});
  }
  for (std::size_t i = 0; i < given["published"].size(); ++i) {
    const json& points = given["published"][i];
    figure.published.push_back({points["title"], points["source"], points["x"], points["y"]});
    if (points["x"].size() != points["y"].size())
      refuse(fmt::format("{}/published/{}", place, i), "x and y must have the same length");
  }
  return figure;
}

}  // namespace

bool is_regression_study(const json& document) {
  if (!document.is_object()) return false;
  const auto schema = document.find("schema");
  return schema != document.end() && schema->is_string() &&
         schema->get<std::string>().starts_with("gyrator/regression/");
}

RegressionStudy load_regression_study(const std::string& path) {
  const json document = load_json_file(path);
  if (!is_regression_study(document)) {
    throw Error(
        ErrorCode::bad_input, path,
        fmt::format(R"(is no regression study: one says "schema": "{}")", regression_schema_name));
  }
  return parse_regression_study(document, path);
}

RegressionStudy parse_regression_study(const json& document, const std::string& file) {
  const json read = read_document(document, regression_format(), file);
  RegressionStudy study;
  study.file = file;
  study.name = read["name"];
  study.about = read["about"];
  const FigureTolerance usual = read_tolerance(read["tolerance"], "", file + ": /tolerance");
  std::vector<std::string> runs;
  for (std::size_t i = 0; i < read["runs"].size(); ++i) {
    study.runs.push_back(read_run(read["runs"][i], usual, fmt::format("{}: /runs/{}", file, i)));
    runs.push_back(study.runs.back().name);
  }
  check_once(runs, file + ": /runs");
  std::vector<std::string> figures;
  for (std::size_t i = 0; i < read["figures"].size(); ++i) {
    study.figures.push_back(
        read_figure(read["figures"][i], runs, fmt::format("{}: /figures/{}", file, i)));
    figures.push_back(study.figures.back().name);
  }
  check_once(figures, file + ": /figures");
  return study;
}

}  // namespace gyrator
