#pragma once

#include "gyrator/documents/document_spec.hpp"

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <nlohmann/json.hpp>

namespace gyrator {

inline constexpr const char* regression_schema_name = "gyrator/regression/1";

/// Which differences count as a regression.
enum class Side { both, below, above };

/// What a value may differ from its reference r:  |v - r| <= absolute + relative |r|   (study-1)
struct FigureTolerance {
  double absolute = 0;  ///< in the figure's SI unit
  double relative = 0;
  Side side = Side::both;
};

/// A value that a paper states.
struct PublishedValue {
  nlohmann::json value;  ///< a number, or a list of them for a varied run
  FigureTolerance tolerance;
  std::string source;
};

/// A figure of a run's answer and what it is to be.
struct Expectation {
  std::string name;       ///< in tables and in the baseline
  std::string figure;     ///< its path in the answer (answer_path.hpp)
  std::string unit;       ///< "" where it has none
  nlohmann::json equals;  ///< null: not asked for
  bool is_none = false;   ///< the answer's null is expected: nothing bounds it
  std::optional<double> at_least, at_most;
  std::optional<FigureTolerance> tolerance;  ///< against the baseline; none: not compared with it
  std::optional<PublishedValue> published;
};

struct TubeColumn {
  std::string name;
  double absolute = 0;  ///< in the column's SI unit
  double relative = 0;  ///< share of what the reference spans in this column
};

/// What a trace may differ from its reference (trace_tube.hpp).
struct TraceExpectation {
  std::vector<TubeColumn> columns;
  double time_s = 0;
};

/// A value of the model that the run takes on one after another.
struct VariedValue {
  std::string path;
  std::vector<nlohmann::json> values;
};

/// A command of this program on a model, and what it is to answer.
struct RegressionRun {
  std::string name;
  std::string command;
  std::string model;  ///< as the study names it, relative to the study's file
  nlohmann::json set = nlohmann::json::object();  ///< path → value
  std::vector<VariedValue> vary;                  ///< in lockstep
  std::vector<std::string> arguments;
  std::vector<int> exit_codes;  ///< of each point
  std::optional<std::uint64_t> seed;
  std::vector<Expectation> expect;
  std::optional<TraceExpectation> trace;
  std::optional<double> energy_residual;  ///< largest share of the largest energy

  /// How often the command runs: once per varied value.
  std::size_t points() const { return vary.empty() ? 1 : vary.front().values.size(); }
  /// The key that `seed` stands for.
  const char* seed_path() const { return command == "design" ? "seed" : "simulation.seed"; }
};

struct StudyCurve {
  std::string run, x, y, title, style;
  double x_scale = 1, y_scale = 1;
};

struct PublishedPoints {
  std::string title, source;
  std::vector<double> x, y;
};

struct StudyAxis {
  std::string label, unit;
  bool logarithmic = false;
  std::optional<double> min, max;
};

struct StudyFigure {
  std::string name, title, caption;
  StudyAxis x, y;
  std::vector<StudyCurve> curves;
  std::vector<PublishedPoints> published;
};

/// Models, commands on them, and figures that must not change (docs/studies.md).
struct RegressionStudy {
  std::string file;  ///< as given
  std::string name, about;
  std::vector<RegressionRun> runs;
  std::vector<StudyFigure> figures;
};

/// The study file as a table: reader, JSON Schema (schemas/regression.schema.json) and manual.
const Member& regression_format();

/// Whether a document says that it is a regression study, by its key "schema".
bool is_regression_study(const nlohmann::json& document);

/// The study in a file. Throws bad_input, with file and JSON pointer, for what is not as the table
/// says, and for what only makes sense otherwise: names that occur twice, lists of unequal length,
/// a tolerance in another unit than the figure's, a trace of a command that has none.
RegressionStudy load_regression_study(const std::string& path);
RegressionStudy parse_regression_study(const nlohmann::json& document, const std::string& file);

}  // namespace gyrator
