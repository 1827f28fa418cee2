#include "gyrator/regression/check_report.hpp"

#include "gyrator/core/text.hpp"
#include "gyrator/version.hpp"

#include <algorithm>
#include <array>
#include <cstddef>
#include <iterator>
#include <utility>

#include <fmt/core.h>

namespace gyrator {
namespace {

using nlohmann::json;

const char* name_of(RowOutcome outcome) {
  if (outcome == RowOutcome::passed) return "pass";
  return outcome == RowOutcome::failed ? "FAIL" : "note";
}

// Characters, not bytes, of UTF-8.
std::size_t width_of(std::string_view text) {
  return static_cast<std::size_t>(std::count_if(text.begin(), text.end(), [](char c) {
    return (static_cast<unsigned char>(c) & 0xC0U) != 0x80U;
  }));
}

using TableRow = std::array<std::string, 6>;

std::string write_table(const std::vector<TableRow>& rows) {
  std::array<std::size_t, 6> widths{};
  for (const TableRow& row : rows)
    for (std::size_t c = 0; c < row.size(); ++c) widths[c] = std::max(widths[c], width_of(row[c]));
  std::string text;
  for (const TableRow& row : rows) {
    std::string line;
    for (std::size_t c = 0; c < row.size(); ++c) {
      line += row[c];
      if (c + 1 < row.size()) line.append(widths[c] - width_of(row[c]) + 2, ' ');
    }
    text += line + "\n";
  }
  return text;
}

// The studies' files, in the order of the rows.
std::vector<std::string> list_studies(const std::vector<CheckRow>& rows) {
  std::vector<std::string> files;
  for (const CheckRow& row : rows)
    if (files.empty() || files.back() != row.study_file) files.push_back(row.study_file);
  return files;
}

std::vector<CheckRow> select_study(const std::vector<CheckRow>& rows, const std::string& file) {
  std::vector<CheckRow> study;
  std::copy_if(rows.begin(), rows.end(), std::back_inserter(study),
               [&](const CheckRow& row) { return row.study_file == file; });
  return study;
}

// "41 figures as expected, 0.8 s", "2 of 13 figures not as expected, 1 note, 0.8 s"
std::string describe_outcome(const std::vector<CheckRow>& rows) {
  const CheckCounts counts = count_rows(rows);
  std::string text = describe_count(counts.rows, "figure");
  text = counts.failed == 0 ? text + " as expected"
                            : fmt::format("{} of {} not as expected", counts.failed, text);
  if (counts.notes > 0) text += ", " + describe_count(counts.notes, "note");
  double seconds = 0;
  for (const CheckRow& row : rows) seconds += row.seconds;
  return text + fmt::format(", {:.1f} s", seconds);
}

std::string write_suite(const std::vector<CheckRow>& rows, const std::string& file) {
  std::string cases;
  std::string name;
  std::size_t tests = 0;
  std::size_t failures = 0;
  double seconds = 0;
  for (const CheckRow& row : rows) {
    if (row.study_file != file) continue;
    name = row.study;
    if (row.outcome == RowOutcome::note) continue;  // no test
    ++tests;
    seconds += row.seconds;
    cases += fmt::format(R"(    <testcase classname="{}" name="{}" file="{}" time="{:.3f}")",
                         escape_xml(row.study + "." + row.run), escape_xml(row.figure),
                         escape_xml(file), row.seconds);
    if (row.outcome == RowOutcome::passed) {
      cases += "/>\n";
      continue;
    }
    ++failures;
    cases += fmt::format(">\n      <failure message=\"{}\">{}</failure>\n    </testcase>\n",
                         escape_xml(row.explanation),
                         escape_xml(fmt::format("now: {}\nexpected: {}\nallowed: {}", row.now,
                                                row.expected, row.allowed)));
  }
  return fmt::format(
      "  <testsuite name=\"{}\" tests=\"{}\" failures=\"{}\" errors=\"0\" skipped=\"0\" "
      "time=\"{:.3f}\">\n{}  </testsuite>\n",
      escape_xml(name), tests, failures, seconds, cases);
}

std::string replace_all(std::string_view text,
                        const std::vector<std::pair<char, std::string_view>>& replacements) {
  std::string result;
  for (const char c : text) {
    const auto found = std::find_if(replacements.begin(), replacements.end(),
                                    [c](const auto& entry) { return entry.first == c; });
    if (found == replacements.end()) {
      result += c;
    } else {
      result += found->second;
    }
  }
  return result;
}

}  // namespace

CheckCounts count_rows(const std::vector<CheckRow>& rows) {
  CheckCounts counts;
  for (const CheckRow& row : rows) {
    if (row.outcome != RowOutcome::note) ++counts.rows;
    if (row.outcome == RowOutcome::failed) ++counts.failed;
    if (row.outcome == RowOutcome::note) ++counts.notes;
  }
  return counts;
}

std::string describe_check(const std::vector<CheckRow>& rows, bool all_rows) {
  std::string text;
  for (const RowOutcome outcome : {RowOutcome::failed, RowOutcome::note})
    for (const CheckRow& row : rows)
      if (row.outcome == outcome)
        text += fmt::format("{}: {}: {}\n", name_of(outcome), row.study_file, row.explanation);
  if (!text.empty()) text += "\n";
  for (const std::string& file : list_studies(rows)) {
    const std::vector<CheckRow> study = select_study(rows, file);
    text += fmt::format("{}: {}\n", file, describe_outcome(study));
    if (!all_rows) continue;
    std::vector<TableRow> table{{"run", "figure", "now", "expected", "allowed", "result"}};
    for (const CheckRow& row : study)
      table.push_back(
          {row.run, row.figure, row.now, row.expected, row.allowed, name_of(row.outcome)});
    text += write_table(table) + "\n";
  }
  const std::size_t studies = list_studies(rows).size();
  if (studies > 1) text += fmt::format("{} studies: {}\n", studies, describe_outcome(rows));
  return text;
}

std::string write_junit(const std::vector<CheckRow>& rows) {
  std::string text =
      "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<testsuites name=\"gyrator study "
      "check\">\n";
  for (const std::string& file : list_studies(rows)) text += write_suite(rows, file);
  return text + "</testsuites>\n";
}

std::string write_github_annotations(const std::vector<CheckRow>& rows) {
  std::string text;
  for (const CheckRow& row : rows) {
    if (row.outcome == RowOutcome::passed) continue;
    text += fmt::format(
        "::{} file={},title={}::{}\n", row.outcome == RowOutcome::failed ? "error" : "warning",
        escape_github_property(row.study_file), escape_github_property(row.study + ": " + row.run),
        escape_github_message(row.explanation));
  }
  return text;
}

json make_check_result(const std::vector<CheckRow>& rows) {
  json list = json::array();
  for (const CheckRow& row : rows) {
    list.push_back({{"study", row.study},
                    {"file", row.study_file},
                    {"run", row.run},
                    {"figure", row.figure},
                    {"now", row.now},
                    {"expected", row.expected},
                    {"allowed", row.allowed},
                    {"result", row.outcome == RowOutcome::passed   ? "pass"
                               : row.outcome == RowOutcome::failed ? "fail"
                                                                   : "note"},
                    {"explanation", row.explanation}});
  }
  const CheckCounts counts = count_rows(rows);
  return {{"command", "study check"},     {"program", fmt::format("gyrator {}", version)},
          {"figures", counts.rows},       {"failed", counts.failed},
          {"passed", counts.failed == 0}, {"rows", std::move(list)}};
}

std::string escape_xml(std::string_view text) {
  std::string valid;
  while (const auto broken = find_invalid_utf8(text)) {
    valid += std::string(text.substr(0, *broken)) + "?";
    text.remove_prefix(*broken + 1);
  }
  valid += text;
  for (char& c : valid) {
    const auto byte = static_cast<unsigned char>(c);
    if (byte < 0x20 && c != '\n' && c != '\t') c = '?';
  }
  return replace_all(valid, {{'&', "&amp;"},
                             {'<', "&lt;"},
                             {'>', "&gt;"},
                             {'"', "&quot;"},
                             {'\'', "&apos;"},
                             {'\n', "&#10;"},
                             {'\t', "&#9;"}});
}

std::string escape_github_message(std::string_view text) {
  return replace_all(text, {{'%', "%25"}, {'\r', "%0D"}, {'\n', "%0A"}});
}

std::string escape_github_property(std::string_view text) {
  return replace_all(text,
                     {{'%', "%25"}, {'\r', "%0D"}, {'\n', "%0A"}, {':', "%3A"}, {',', "%2C"}});
}

}  // namespace gyrator
