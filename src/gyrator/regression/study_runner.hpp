#pragma once

#include "gyrator/regression/regression_study.hpp"
#include "gyrator/regression/trace_tube.hpp"

#include <map>
#include <optional>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

namespace gyrator {

/// What the program answered for one of a run's points.
struct PointAnswer {
  nlohmann::json answer;            ///< null where there was none
  int exit_code = 0;                ///< -1: a signal ended it
  std::string errors;               ///< its stderr
  std::optional<TraceTable> trace;  ///< of a run with a tube: its columns
  std::string trace_problem;        ///< why it cannot be read
  std::string csv;                  ///< of `simulate`, where it is kept: the file's text
  nlohmann::json set = nlohmann::json::object();  ///< the values set, path → number in SI units
  double seconds = 0;
};

struct RunAnswer {
  const RegressionRun* run = nullptr;
  std::vector<PointAnswer> points;
  std::string model_sha256;
  std::map<std::string, std::string> files;  ///< SHA-256 of what the model names

  double seconds() const;
};

/// A study and the answers of its runs; of those that the filter left out there are none.
struct StudyAnswers {
  const RegressionStudy* study = nullptr;
  std::vector<RunAnswer> runs;
};

struct StudyRunOptions {
  std::string program;  ///< path of gyrator itself; empty: this process
  std::string filter;   ///< only runs with this text in "STUDY/RUN", study by name, folder or file
  int threads = 0;      ///< 0: all cores; GYRATOR_THREADS limits either
  bool keep_csv = false;
  bool quiet = true;  ///< no progress bar
};

/// Whether a run has the filter's text in "STUDY/RUN", study by name, folder or file.
bool is_wanted(const RegressionStudy& study, const RegressionRun& run, const std::string& filter);

/// Runs the studies' commands as processes of their own, side by side, each on its share of the
/// cores, in the folder of the study's file.
/// Throws bad_input for a model that is missing, for a value that it does not have, and where the
/// filter leaves nothing (with the runs that there are); interrupted after Ctrl-C: nothing is left
/// behind. What the program refuses or how it crashes is an answer.
std::vector<StudyAnswers> run_studies(const std::vector<RegressionStudy>& studies,
                                      const StudyRunOptions& options);

/// A figure of the answers: of a run that varies, the list over its points. "set.PATH" is the
/// varied value. Throws bad_input, without a place, for what an answer does not have.
nlohmann::json find_run_figure(const RunAnswer& run, const std::string& path);

/// "sampling.delay = 0.05, controller.stiffness = 8": what this point of a run that varies is; an
/// object by its kind or, without one, its number. Empty for a run that does not vary.
std::string describe_varied(const RunAnswer& run, std::size_t point);

/// "exit code 2", "ended by a signal".
std::string describe_exit(int code);
/// The first line of what the program said on its stderr.
std::string first_error(const PointAnswer& point);

/// The tube's columns of a trace in a file. Throws bad_input for one that cannot be read, a column
/// that it does not have, and a value that is no number.
TraceTable read_trace_table(const std::string& path, const TraceExpectation& tube);

}  // namespace gyrator
