#pragma once

#include "gyrator/regression/baseline.hpp"
#include "gyrator/regression/study_runner.hpp"

#include <filesystem>
#include <map>
#include <string>
#include <vector>

namespace gyrator {

/// What `study update` would write beside a study.
struct StudyUpdate {
  std::string study_file;
  Baseline baseline;
  std::map<std::filesystem::path, std::string> traces;  ///< reference traces: file → text
  std::vector<std::filesystem::path> stale;             ///< traces that no run has any more
  std::vector<std::string> changes;                     ///< a line each, old → new

  bool is_empty() const { return changes.empty(); }
};

/// The baseline that these answers make, with units, tolerances and provenance; what a filter left
/// out stays as it was. Traces are thinned (thin_trace).
/// Throws bad_input, naming run and figure, for an answer that can be no reference: another exit
/// code than expected, a figure that is not there or breaks its own bounds, a trace that would be
/// larger than 200 kB.
StudyUpdate plan_update(const StudyAnswers& answers, bool whole);

/// Writes baseline and traces of one study, prepared in full before the first takes its name: a
/// full disk or a folder that cannot be written leaves all as it was.
void write_update(const StudyUpdate& update);

}  // namespace gyrator
