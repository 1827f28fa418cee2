#pragma once

#include "gyrator/regression/baseline.hpp"
#include "gyrator/regression/study_runner.hpp"

#include <string>
#include <vector>

namespace gyrator {

enum class RowOutcome { passed, failed, note };

/// A figure of a run, as it is and as it is to be.
struct CheckRow {
  std::string study_file, study, run, figure;
  std::string now, expected, allowed;
  RowOutcome outcome = RowOutcome::passed;
  /// In words, with units: "largest K of delayed_spring: 15.2 N/m, baseline 15.84 N/m ±
  /// 0.0001 %: 4.04 % lower"; of what did not pass.
  std::string explanation;
  double seconds = 0;  ///< that the run took, at the run's first row
};

/// Holds the answers of a study against its expectations and its baseline: exit codes, figures,
/// published values, traces, energy; then, as notes, what the baseline has and the study has not
/// (only `whole` studies: a filter leaves runs out).
std::vector<CheckRow> check_study(const StudyAnswers& answers, bool whole);

}  // namespace gyrator
