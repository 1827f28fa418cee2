#include "gyrator/regression/study_check.hpp"

#include "gyrator/core/error.hpp"
#include "gyrator/core/text.hpp"
#include "gyrator/regression/figure_check.hpp"
#include "gyrator/regression/trace_tube.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include <fmt/core.h>

namespace gyrator {
namespace {

using nlohmann::json;
namespace fs = std::filesystem;

// " (sampling.delay = 0.05)" of a point of a run that varies.
std::string describe_point(const RunAnswer& run, std::size_t point) {
  const std::string text = describe_varied(run, point);
  return text.empty() ? "" : " (" + text + ")";
}

class StudyCheck {
 public:
  explicit StudyCheck(const StudyAnswers& answers)
      : study_(*answers.study), answers_(answers), baseline_(load_baseline(study_.file)) {}

  std::vector<CheckRow> check(bool whole) {
    for (const RunAnswer& run : answers_.runs) {
      const std::size_t first = rows_.size();
      check_exit(run);
      for (const Expectation& expectation : run.run->expect) check_figure(run, expectation);
      if (run.run->trace) check_trace(run);
      if (run.run->energy_residual) check_energy(run);
      rows_[first].seconds = run.seconds();
    }
    note_stale(whole);
    return std::move(rows_);
  }

 private:
  CheckRow& add(const std::string& run, const std::string& figure) {
    rows_.push_back({study_.file, study_.name, run, figure, {}, {}, {}, RowOutcome::passed, {}, 0});
    return rows_.back();
  }

  static void fail(CheckRow& row, const std::string& reason) {
    row.outcome = RowOutcome::failed;
    if (!row.explanation.empty()) row.explanation += "; ";
    row.explanation +=
        row.explanation.empty() ? fmt::format("{} of {}: {}", row.figure, row.run, reason) : reason;
  }

  const BaselineRun* find_baseline_run(const std::string& run) const {
    if (!baseline_) return nullptr;
    const auto found = baseline_->runs.find(run);
    return found == baseline_->runs.end() ? nullptr : &found->second;
  }

  std::string describe_update(const std::string& run) const {
    return fmt::format("`gyrator study update {} --filter {}` writes it", study_.file, run);
  }

  void check_exit(const RunAnswer& run) {
    CheckRow& row = add(run.run->name, "exit code");
    std::vector<std::string> now;
    std::vector<std::string> expected;
    for (std::size_t k = 0; k < run.points.size(); ++k) {
      const PointAnswer& point = run.points[k];
      const int wanted = run.run->exit_codes[k];
      now.push_back(point.exit_code < 0 ? "signal" : std::to_string(point.exit_code));
      expected.push_back(std::to_string(wanted));
      if (point.exit_code == wanted) continue;
      const std::string said = first_error(point);
      fail(row, fmt::format("{}{}, expected {}{}", describe_exit(point.exit_code),
                            describe_point(run, k), wanted, said.empty() ? "" : ": " + said));
    }
    row.now = join(now);
    row.expected = join(expected);
  }

  void check_figure(const RunAnswer& run, const Expectation& expectation) {
    CheckRow& row = add(run.run->name, expectation.name);
    json value;
    try {
      value = find_run_figure(run, expectation.figure);
    } catch (const Error& error) {
      row.now = "missing";
      return fail(row, error.message());
    }
    row.now = describe_figure(value, expectation.unit);
    check_fixed(run, value, expectation, row);
    if (expectation.tolerance) check_against_baseline(run, value, expectation, row);
    if (!expectation.published) return;
    const PublishedValue& published = *expectation.published;
    if (const auto difference =
            find_difference(value, published.value, published.tolerance, expectation.unit,
                            "published (" + published.source + ")"))
      fail(row, point_named(run, *difference));
    if (row.expected.empty()) {
      row.expected = describe_figure(published.value, expectation.unit);
      row.allowed = describe_tolerance(published.tolerance, expectation.unit);
    }
  }

  // "[1]: …" of a run that varies tells which value that is.
  static std::string point_named(const RunAnswer& run, const Difference& difference) {
    if (run.run->vary.empty() || !difference.item) return difference.reason;
    const std::string index = fmt::format("[{}]", *difference.item);
    return index + describe_point(run, *difference.item) + difference.reason.substr(index.size());
  }

  static void check_fixed(const RunAnswer& run, const json& value, const Expectation& expectation,
                          CheckRow& row) {
    if (!expectation.equals.is_null()) {
      row.expected = describe_figure(expectation.equals, expectation.unit);
      row.allowed = "exactly";
    } else if (expectation.is_none) {
      row.expected = "none";
    } else {
      std::vector<std::string> bounds;
      if (expectation.at_least)
        bounds.push_back("at least " + describe_figure(*expectation.at_least, expectation.unit));
      if (expectation.at_most)
        bounds.push_back("at most " + describe_figure(*expectation.at_most, expectation.unit));
      row.expected = join(bounds);
    }
    if (const auto violation = find_violation(value, expectation))
      fail(row, point_named(run, *violation));
  }

  void check_against_baseline(const RunAnswer& run, const json& value,
                              const Expectation& expectation, CheckRow& row) {
    const BaselineRun* base = find_baseline_run(run.run->name);
    const auto found = base != nullptr ? base->figures.find(expectation.name)
                                       : std::map<std::string, BaselineFigure>::const_iterator{};
    row.allowed = describe_tolerance(*expectation.tolerance, expectation.unit);
    if (base == nullptr || found == base->figures.end()) {
      const std::string what = !baseline_        ? "there is no baseline"
                               : base == nullptr ? "the baseline has no such run"
                                                 : "the baseline has no such figure";
      row.expected = "missing";
      return fail(row, fmt::format("{}, {}: {}", row.now, what, describe_update(run.run->name)));
    }
    if (row.expected.empty()) row.expected = describe_figure(found->second.value, expectation.unit);
    if (found->second.unit != expectation.unit) {
      return fail(row, fmt::format("is in '{}', in the baseline in '{}': {}", expectation.unit,
                                   found->second.unit, describe_update(run.run->name)));
    }
    const auto difference = find_difference(value, found->second.value, *expectation.tolerance,
                                            expectation.unit, "baseline");
    if (!difference) return;
    fail(row, point_named(run, *difference));
    if (base->provenance.value("model_sha256", "") != run.model_sha256)
      row.explanation += " (the model file is not the one of the baseline)";
  }

  void check_trace(const RunAnswer& run) {
    for (std::size_t k = 0; k < run.points.size(); ++k) {
      const TraceExpectation& tube = *run.run->trace;
      std::vector<std::string> names;
      for (const TubeColumn& column : tube.columns) names.push_back(column.name);
      CheckRow& row = add(run.run->name, "trace" + describe_point(run, k));
      const fs::path file = reference_trace_name(study_.file, *run.run, k);
      row.now = join(names);
      row.expected = file.filename().string();
      row.allowed = describe_tube(tube);
      const PointAnswer& point = run.points[k];
      if (!point.trace) {
        fail(row, point.trace_problem.empty() ? "there is none" : point.trace_problem);
      } else if (std::error_code ignored; !fs::exists(file, ignored)) {
        fail(row, fmt::format("the reference {} is missing: {}", file.string(),
                              describe_update(run.run->name)));
      } else {
        check_tube(*point.trace, file, tube, row);
      }
    }
  }

  static std::string describe_tube(const TraceExpectation& tube) {
    std::vector<std::string> parts;
    for (const TubeColumn& column : tube.columns)
      parts.push_back(describe_tolerance({column.absolute, column.relative, Side::both}, ""));
    if (tube.time_s > 0) parts.push_back(fmt::format("± {:g} s", tube.time_s));
    return join(parts);
  }

  static void check_tube(const TraceTable& trace, const fs::path& file,
                         const TraceExpectation& tube, CheckRow& row) {
    TraceTable reference;
    try {
      reference = read_trace_table(file.string(), tube);
    } catch (const Error& error) {
      return fail(row, error.what());
    }
    const auto exit = find_tube_exit(trace, reference, tube);
    if (!exit) return;
    if (exit->is_start || exit->is_end) {
      return fail(row, fmt::format("{} at {:.9g} s, the reference at {:.9g} s",
                                   exit->is_start ? "starts" : "ends", exit->value, exit->limit));
    }
    fail(row,
         fmt::format("{} leaves the tube at t = {:.6g} s: {:.6g}, allowed {} {:.6g}; at most "
                     "{:.3g} outside",
                     tube.columns[exit->column].name, exit->time_s, exit->value,
                     exit->value > exit->limit ? "up to" : "down to", exit->limit, exit->outside));
  }

  void check_energy(const RunAnswer& run) {
    CheckRow& row = add(run.run->name, "energy residual");
    const double allowed = *run.run->energy_residual;
    row.expected = "0";
    row.allowed = fmt::format("± {} of the largest", format_number(allowed));
    double worst = 0;
    for (std::size_t k = 0; k < run.points.size(); ++k) {
      const json& answer = run.points[k].answer;
      const json energy = answer.is_object() ? answer.value("energy", json()) : json();
      if (!energy.is_object() || !energy.contains("residual")) {
        fail(row, fmt::format("there is no energy ledger{}", describe_point(run, k)));
        continue;
      }
      double largest = 0;
      for (const auto& [name, term] : energy.items())
        if (name != "residual" && term.is_number())
          largest = std::max(largest, std::abs(term.get<double>()));
      const json& residual = energy["residual"];
      const bool is_closed =
          residual.is_number() && std::abs(residual.get<double>()) <= allowed * largest;
      if (residual.is_number() && largest > 0)
        worst = std::max(worst, std::abs(residual.get<double>()) / largest);
      if (is_closed) continue;
      fail(row, fmt::format("{} of a largest energy of {:.6g} J{}: at most {} of it is allowed",
                            describe_figure(residual, "J"), largest, describe_point(run, k),
                            format_number(allowed)));
    }
    row.now = fmt::format("{:.2g}", worst);
  }

  void note_stale(bool whole) {
    if (!baseline_ || !whole) return;
    const auto note = [&](const std::string& run, const std::string& figure) {
      CheckRow& row = add(run, figure);
      row.now = "not computed";
      row.expected = "in the baseline";
      row.outcome = RowOutcome::note;
      row.explanation = fmt::format(
          "{}{}: is in the baseline, but not in the study any more: `gyrator study update {}` "
          "removes it",
          run, figure.empty() ? "" : ": " + figure, study_.file);
    };
    for (const auto& [name, base] : baseline_->runs) {
      const auto found = std::find_if(study_.runs.begin(), study_.runs.end(),
                                      [&, &key = name](const auto& r) { return r.name == key; });
      if (found == study_.runs.end()) {
        note(name, "");
        continue;
      }
      for (const auto& item : base.figures) {
        const bool is_known =
            std::any_of(found->expect.begin(), found->expect.end(),
                        [&](const Expectation& e) { return e.name == item.first && e.tolerance; });
        if (!is_known) note(name, item.first);
      }
    }
  }

  const RegressionStudy& study_;
  const StudyAnswers& answers_;
  std::optional<Baseline> baseline_;
  std::vector<CheckRow> rows_;
};

}  // namespace

std::vector<CheckRow> check_study(const StudyAnswers& answers, bool whole) {
  return StudyCheck(answers).check(whole);
}

}  // namespace gyrator
