#pragma once

#include "gyrator/regression/regression_study.hpp"

#include <filesystem>
#include <map>
#include <optional>
#include <string>

#include <nlohmann/json.hpp>

namespace gyrator {

inline constexpr const char* baseline_schema_name = "gyrator/baseline/1";

/// A figure as it was when the baseline was written.
struct BaselineFigure {
  nlohmann::json value;
  std::string unit;
  std::string tolerance;  ///< in words, as it was then
};

/// The figures of a run, and what they came from.
struct BaselineRun {
  nlohmann::json provenance;  ///< program, machine, command, model_sha256, files, set, engine
  std::map<std::string, BaselineFigure> figures;
};

/// What a study's figures were: STUDY.baseline.json beside the study. Keys are sorted and every
/// value has a line of its own, so that version control shows what has changed.
struct Baseline {
  std::string study;
  std::map<std::string, BaselineRun> runs;
};

/// "studies/delay/study.baseline.json" of "studies/delay/study.json".
std::string baseline_name(const std::string& study_file);

/// The reference trace of a run's point, "study.baseline/RUN.csv", or "RUN.2.csv" where it varies.
std::filesystem::path reference_trace_name(const std::string& study_file, const RegressionRun& run,
                                           std::size_t point);

/// None where there is no such file. Throws bad_input for what is no baseline.
std::optional<Baseline> load_baseline(const std::string& study_file);

Baseline parse_baseline(const nlohmann::json& document, const std::string& file);
std::string write_baseline_text(const Baseline& baseline);

}  // namespace gyrator
