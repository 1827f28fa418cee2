#pragma once

#include "gyrator/regression/study_check.hpp"

#include <string>
#include <string_view>
#include <vector>

#include <nlohmann/json.hpp>

namespace gyrator {

struct CheckCounts {
  std::size_t rows = 0, failed = 0, notes = 0;
};
CheckCounts count_rows(const std::vector<CheckRow>& rows);

/// For people: the failures in words first, then a line for each study and, of several, one for
/// all: "studies/delay/study.json: 41 figures as expected, 0.8 s" (what its runs took, added up).
/// With all rows, each study has a table of run, figure, now, expected, allowed and result too.
std::string describe_check(const std::vector<CheckRow>& rows, bool all_rows);

/// JUnit XML: a testsuite for each study, a testcase for each figure of its runs.
std::string write_junit(const std::vector<CheckRow>& rows);

/// Workflow commands of GitHub Actions, a line for each row that did not pass:
/// "::error file=studies/delay/study.json,title=Delay: delayed_spring::largest K of …".
std::string write_github_annotations(const std::vector<CheckRow>& rows);

/// {"command": "study check", "passed", "rows": [...]}
nlohmann::json make_check_result(const std::vector<CheckRow>& rows);

/// A text in an XML document, in an attribute too; what XML has no character for becomes '?'.
std::string escape_xml(std::string_view text);
/// A workflow command's message, and a value of one of its properties.
std::string escape_github_message(std::string_view text);
std::string escape_github_property(std::string_view text);

}  // namespace gyrator
