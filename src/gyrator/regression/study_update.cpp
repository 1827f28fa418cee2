#include "gyrator/regression/study_update.hpp"

#include "gyrator/core/error.hpp"
#include "gyrator/core/text.hpp"
#include "gyrator/documents/input_file.hpp"
#include "gyrator/documents/output_file.hpp"
#include "gyrator/regression/figure_check.hpp"
#include "gyrator/version.hpp"

#include <algorithm>
#include <cmath>
#include <memory>
#include <set>
#include <sys/utsname.h>
#include <utility>

#include <fmt/core.h>

namespace gyrator {
namespace {

using nlohmann::json;
namespace fs = std::filesystem;

constexpr std::size_t most_trace_bytes = 200'000;

[[noreturn]] void refuse(const StudyAnswers& answers, const RunAnswer& run,
                         const std::string& message) {
  throw Error(ErrorCode::bad_input, fmt::format("{}: {}", answers.study->file, run.run->name),
              message + ": it can be no reference");
}

std::string describe_machine() {
  utsname name{};
  if (uname(&name) != 0) return "unknown";
  return fmt::format("{} {}", name.machine, name.sysname);
}

json make_provenance(const RunAnswer& run) {
  json provenance{{"program", fmt::format("gyrator {}", version)},
                  {"machine", describe_machine()},
                  {"command", run.run->command},
                  {"model", run.run->model},
                  {"model_sha256", run.model_sha256}};
  if (!run.run->arguments.empty()) provenance["arguments"] = join(run.run->arguments, " ");
  if (!run.files.empty()) provenance["files_sha256"] = run.files;
  if (!run.run->set.empty()) provenance["set"] = run.run->set;
  for (const VariedValue& varied : run.run->vary) provenance["vary"][varied.path] = varied.values;
  if (run.run->seed) provenance["seed"] = *run.run->seed;
  const json& answer = run.points.front().answer;
  if (answer.is_object() && answer.contains("engine")) provenance["engine"] = answer["engine"];
  return provenance;
}

void check_usable(const StudyAnswers& answers, const RunAnswer& run) {
  for (std::size_t k = 0; k < run.points.size(); ++k) {
    const PointAnswer& point = run.points[k];
    if (point.exit_code == run.run->exit_codes[k]) continue;
    refuse(answers, run,
           fmt::format("ended with {}, expected {}: {}", point.exit_code, run.run->exit_codes[k],
                       first_error(point)));
  }
}

BaselineRun make_run(const StudyAnswers& answers, const RunAnswer& run) {
  check_usable(answers, run);
  BaselineRun base{make_provenance(run), {}};
  for (const Expectation& expectation : run.run->expect) {
    json value;
    try {
      value = find_run_figure(run, expectation.figure);
    } catch (const Error& error) {
      refuse(answers, run, expectation.name + ": " + error.message());
    }
    if (const auto violation = find_violation(value, expectation))
      refuse(answers, run, expectation.name + ": " + violation->reason);
    if (!expectation.tolerance) continue;
    base.figures[expectation.name] = {value, expectation.unit,
                                      describe_tolerance(*expectation.tolerance, expectation.unit)};
  }
  return base;
}

std::string write_trace_text(const TraceTable& trace, const TraceExpectation& tube) {
  std::string text = "time_s";
  for (const TubeColumn& column : tube.columns) text += "," + column.name;
  text += "\n";
  for (std::size_t i = 0; i < trace.time_s.size(); ++i) {
    text += format_number(trace.time_s[i]);
    for (const auto& column : trace.columns) text += "," + format_number(column[i]);
    text += "\n";
  }
  return text;
}

void add_traces(const StudyAnswers& answers, const RunAnswer& run, StudyUpdate& update) {
  if (!run.run->trace) return;
  for (std::size_t k = 0; k < run.points.size(); ++k) {
    const PointAnswer& point = run.points[k];
    if (!point.trace)
      refuse(answers, run,
             "trace: " + (point.trace_problem.empty() ? "there is none" : point.trace_problem));
    std::string text = write_trace_text(thin_trace(*point.trace, *run.run->trace), *run.run->trace);
    if (text.size() > most_trace_bytes) {
      refuse(answers, run,
             fmt::format("its trace needs {} kB, thinned as far as its tube allows, and at most "
                         "{} kB go into a baseline (a wider tube, a shorter run or fewer columns)",
                         text.size() / 1000, most_trace_bytes / 1000));
    }
    update.traces[reference_trace_name(update.study_file, *run.run, k)] = std::move(text);
  }
}

std::string describe_relative_change(const json& before, const json& after) {
  if (!before.is_number() || !after.is_number()) return {};
  const double from = before.get<double>();
  const double to = after.get<double>();
  if (from == 0) return {};
  return fmt::format(" ({:+.3g} %)", 100 * (to - from) / std::abs(from));
}

// Two values so that they can be told apart.
std::pair<std::string, std::string> describe_pair(const json& before, const json& after,
                                                  const std::string& unit) {
  std::string from = describe_figure(before, unit);
  std::string to = describe_figure(after, unit);
  if (from != to || !before.is_number() || !after.is_number()) return {from, to};
  return {format_number(before.get<double>()), format_number(after.get<double>())};
}

class ChangeList {
 public:
  ChangeList(const std::string& run, std::vector<std::string>& lines) : run_(run), lines_(lines) {}

  void compare(const std::string& figure, const BaselineFigure* before,
               const BaselineFigure* after) {
    if (before == nullptr) {
      add(figure, "new: " + describe_figure(after->value, after->unit));
    } else if (after == nullptr) {
      add(figure, "removed, was " + describe_figure(before->value, before->unit));
    } else {
      compare_values(figure, before->value, after->value, after->unit);
      if (before->unit != after->unit)
        add(figure, fmt::format("unit '{}' -> '{}'", before->unit, after->unit));
      if (before->tolerance != after->tolerance)
        add(figure, fmt::format("tolerance {} -> {}", before->tolerance, after->tolerance));
    }
  }

  void add(const std::string& figure, const std::string& text) {
    lines_.push_back(fmt::format("{}: {}: {}", run_, figure, text));
  }

 private:
  void compare_values(const std::string& figure, const json& before, const json& after,
                      const std::string& unit) {
    if (before == after) return;
    if (before.is_array() && after.is_array() && before.size() == after.size()) {
      for (std::size_t i = 0; i < after.size(); ++i)
        compare_values(fmt::format("{}[{}]", figure, i), before[i], after[i], unit);
      return;
    }
    const auto [from, to] = describe_pair(before, after, unit);
    add(figure, fmt::format("{} -> {}{}", from, to, describe_relative_change(before, after)));
  }

  const std::string& run_;
  std::vector<std::string>& lines_;
};

void list_changes(const std::string& name, const BaselineRun* before, const BaselineRun* after,
                  std::vector<std::string>& lines) {
  ChangeList changes(name, lines);
  if (before == nullptr) changes.add("run", "new");
  if (after == nullptr) return changes.add("run", "removed");
  const auto find = [](const BaselineRun* run, const std::string& figure) -> const BaselineFigure* {
    if (run == nullptr) return nullptr;
    const auto found = run->figures.find(figure);
    return found == run->figures.end() ? nullptr : &found->second;
  };
  std::set<std::string> figures;
  if (before != nullptr)
    for (const auto& item : before->figures) figures.insert(item.first);
  for (const auto& item : after->figures) figures.insert(item.first);
  for (const std::string& figure : figures)
    changes.compare(figure, find(before, figure), find(after, figure));
  if (before != nullptr && before->provenance != after->provenance) {
    std::vector<std::string> keys;
    for (const auto& [key, value] : after->provenance.items())
      if (before->provenance.value(key, json()) != value) keys.push_back(key);
    for (const auto& item : before->provenance.items())
      if (!after->provenance.contains(item.key())) keys.push_back(item.key());
    changes.add("provenance", "changed: " + join(keys));
  }
}

void list_all_changes(const Baseline& before, const Baseline& after,
                      std::vector<std::string>& lines) {
  std::set<std::string> names;
  for (const auto& item : before.runs) names.insert(item.first);
  for (const auto& item : after.runs) names.insert(item.first);
  const auto find = [](const Baseline& baseline, const std::string& name) {
    const auto found = baseline.runs.find(name);
    return found == baseline.runs.end() ? nullptr : &found->second;
  };
  for (const std::string& name : names)
    list_changes(name, find(before, name), find(after, name), lines);
}

void list_trace_changes(StudyUpdate& update) {
  for (const auto& [path, text] : update.traces) {
    const std::string before = read_text_file_if_any(path);
    if (before == text) continue;
    update.changes.push_back(
        fmt::format("trace {}: {}", path.filename().string(), before.empty() ? "new" : "changed"));
  }
  for (const fs::path& path : update.stale)
    update.changes.push_back(fmt::format("trace {}: removed", path.filename().string()));
}

std::vector<fs::path> find_stale_traces(const StudyUpdate& update) {
  fs::path folder = update.study_file;
  folder.replace_extension(".baseline");
  std::vector<fs::path> stale;
  std::error_code ignored;
  for (const auto& entry : fs::directory_iterator(folder, ignored)) {
    if (entry.path().extension() == ".csv" && !update.traces.contains(entry.path()))
      stale.push_back(entry.path());
  }
  std::sort(stale.begin(), stale.end());
  return stale;
}

}  // namespace

StudyUpdate plan_update(const StudyAnswers& answers, bool whole) {
  StudyUpdate update;
  update.study_file = answers.study->file;
  const Baseline before = load_baseline(update.study_file).value_or(Baseline{});
  if (!whole) update.baseline = before;
  update.baseline.study = answers.study->name;
  for (const RunAnswer& run : answers.runs) {
    update.baseline.runs[run.run->name] = make_run(answers, run);
    add_traces(answers, run, update);
  }
  if (whole) update.stale = find_stale_traces(update);
  list_all_changes(before, update.baseline, update.changes);
  list_trace_changes(update);
  return update;
}

void write_update(const StudyUpdate& update) {
  if (!update.traces.empty()) {
    const fs::path folder = update.traces.begin()->first.parent_path();
    std::error_code failed;
    fs::create_directories(folder, failed);
    if (failed)
      throw Error(ErrorCode::bad_input, folder.string(), "cannot be made: " + failed.message());
  }
  std::vector<std::unique_ptr<OutputFile>> files;
  const auto prepare = [&](const std::string& path, const std::string& text) {
    files.push_back(std::make_unique<OutputFile>(path));
    files.back()->stream() << text;
  };
  for (const auto& [path, text] : update.traces) prepare(path.string(), text);
  prepare(baseline_name(update.study_file), write_baseline_text(update.baseline));
  for (const auto& file : files) {  // a full disk shows before the first takes its name
    file->stream().flush();
    if (!file->stream())
      throw Error(ErrorCode::bad_input, update.study_file, "its baseline cannot be written");
  }
  for (const auto& file : files) file->commit();
  std::error_code ignored;
  for (const fs::path& path : update.stale) fs::remove(path, ignored);
}

}  // namespace gyrator
