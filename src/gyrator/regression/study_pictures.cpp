#include "gyrator/regression/study_pictures.hpp"

#include "gyrator/core/error.hpp"
#include "gyrator/core/text.hpp"
#include "gyrator/documents/output_file.hpp"
#include "gyrator/plots/html.hpp"
#include "gyrator/regression/baseline.hpp"
#include "gyrator/regression/figure_check.hpp"
#include "gyrator/regression/overridden_model.hpp"
#include "gyrator/studies/report.hpp"
#include "gyrator/studies/result_figures.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <optional>
#include <utility>

#include <fmt/core.h>

namespace gyrator {
namespace {

using nlohmann::json;
namespace fs = std::filesystem;

constexpr std::array colours{Colour::blue,   Colour::vermillion, Colour::green, Colour::orange,
                             Colour::purple, Colour::sky,        Colour::grey};

Axis make_axis(const StudyAxis& axis) {
  Axis made{axis.label, axis.unit, axis.logarithmic};
  made.min = axis.min;
  made.max = axis.max;
  return made;
}

CurveStyle style_of(const std::string& name) {
  if (name == "dashed") return CurveStyle::dashed;
  if (name == "dotted") return CurveStyle::dotted;
  if (name == "steps") return CurveStyle::steps;
  return name == "points" ? CurveStyle::points : CurveStyle::line;
}

const RunAnswer& find_run(const StudyAnswers& answers, const std::string& name) {
  const auto found = std::find_if(answers.runs.begin(), answers.runs.end(),
                                  [&](const RunAnswer& run) { return run.run->name == name; });
  if (found == answers.runs.end())
    throw Error(ErrorCode::bad_input, "", fmt::format("the run '{}' was not computed", name));
  return *found;
}

// null is no number: it breaks the line.
std::vector<double> read_numbers(const json& list, double scale) {
  std::vector<double> numbers;
  for (const json& value : list) {
    if (!value.is_number() && !value.is_null())
      throw Error(ErrorCode::bad_input, "",
                  fmt::format("found {}: numbers are drawn", describe_figure(value, "")));
    numbers.push_back(value.is_null() ? std::nan("") : scale * value.get<double>());
  }
  return numbers;
}

std::vector<Curve> make_curves(const StudyCurve& curve, const RunAnswer& run) {
  json x = find_run_figure(run, curve.x);
  json y = find_run_figure(run, curve.y);
  if (!y.is_array()) y = json::array({y});
  if (!x.is_array()) x = json::array({x});
  std::vector<Curve> curves;
  const auto add = [&](const std::string& title, const json& xs, const json& ys) {
    Curve made{title, read_numbers(xs, curve.x_scale), read_numbers(ys, curve.y_scale)};
    made.style = style_of(curve.style);
    if (made.x.size() != made.y.size())
      throw Error(
          ErrorCode::bad_input, "",
          fmt::format("x has {} and y {}", describe_count(made.x.size(), "value"), made.y.size()));
    curves.push_back(std::move(made));
  };
  const bool one_each = !run.run->vary.empty() && !y.empty() && y.front().is_array();
  if (!one_each) {
    add(curve.title, x, y);
    return curves;
  }
  for (std::size_t k = 0; k < y.size(); ++k) {
    const std::string value = describe_varied(run, k);
    add(curve.title.empty() ? value : curve.title + ", " + value, x[k].is_array() ? x[k] : x, y[k]);
  }
  return curves;
}

std::string name_of_point(const RegressionRun& run, std::size_t point) {
  return run.vary.empty() ? run.name : fmt::format("{}.{}", run.name, point);
}

std::string write_rows(const std::vector<CheckRow>& rows) {
  std::vector<std::vector<HtmlCell>> table;
  for (const CheckRow& row : rows) {
    const bool failed = row.outcome == RowOutcome::failed;
    table.push_back({{row.run},
                     {row.figure},
                     {row.now, "number"},
                     {row.expected, "number"},
                     {row.allowed},
                     {failed                            ? row.explanation
                      : row.outcome == RowOutcome::note ? "note"
                                                        : "as expected",
                      failed ? "no" : "yes"}});
  }
  return html_table({"run", "figure", "now", "expected", "allowed", "result"}, table);
}

bool is_computed(const StudyFigure& figure, const StudyAnswers& answers) {
  return std::all_of(figure.curves.begin(), figure.curves.end(), [&](const StudyCurve& curve) {
    return std::any_of(answers.runs.begin(), answers.runs.end(),
                       [&](const RunAnswer& run) { return run.run->name == curve.run; });
  });
}

// Why a figure whose runs were computed cannot be drawn: the first point without an answer.
std::optional<std::string> find_missing_answer(const StudyFigure& figure,
                                               const StudyAnswers& answers) {
  for (const StudyCurve& curve : figure.curves) {
    const RunAnswer& run = find_run(answers, curve.run);
    for (std::size_t k = 0; k < run.points.size(); ++k) {
      const PointAnswer& point = run.points[k];
      if (!point.answer.is_null()) continue;
      const std::string varied = describe_varied(run, k);
      const std::string said = first_error(point);
      return fmt::format("the figure '{}' is not drawn: {}{} gave no answer: {}{}", figure.name,
                         run.run->name, varied.empty() ? "" : " (" + varied + ")",
                         describe_exit(point.exit_code), said.empty() ? "" : ": " + said);
    }
  }
  return std::nullopt;
}

// The files that a study's runs read, with those that these name.
void list_read_files(const fs::path& model, std::vector<fs::path>& files) {
  if (std::find(files.begin(), files.end(), model) != files.end()) return;
  files.push_back(model);
  if (model.extension() != ".json") return;
  try {
    for (const fs::path& named : OverridableModel(model.string()).named_files())
      list_read_files(named, files);
  } catch (const Error&) {  // told with its place when the study is run
  }
}

std::vector<fs::path> list_inputs(const RegressionStudy& study) {
  std::vector<fs::path> inputs{study.file, baseline_name(study.file)};
  for (const RegressionRun& run : study.runs) {
    list_read_files(fs::path(study.file).parent_path() / run.model, inputs);
    if (!run.trace) continue;
    for (std::size_t k = 0; k < run.points(); ++k)
      inputs.push_back(reference_trace_name(study.file, run, k));
  }
  return inputs;
}

// All that write_study_results may write.
std::vector<std::string> list_outputs(const RegressionStudy& study, const std::string& filter) {
  std::vector<std::string> names{"report.html", "results.html"};
  for (const StudyFigure& figure : study.figures) names.push_back(figure.name + ".svg");
  for (const RegressionRun& run : study.runs) {
    if (!is_wanted(study, run, filter)) continue;
    for (std::size_t k = 0; k < run.points(); ++k) {
      names.push_back(name_of_point(run, k) + ".json");
      if (run.command == "simulate") names.push_back(name_of_point(run, k) + ".csv");
    }
  }
  return names;
}

}  // namespace

Figure make_study_figure(const RegressionStudy& study, const StudyFigure& figure,
                         const StudyAnswers& answers) {
  Panel panel{figure.title, make_axis(figure.x), make_axis(figure.y)};
  std::size_t next = 0;
  for (std::size_t i = 0; i < figure.curves.size(); ++i) {
    const StudyCurve& curve = figure.curves[i];
    try {
      for (Curve& made : make_curves(curve, find_run(answers, curve.run))) {
        made.colour = colours.at(next++ % colours.size());
        panel.curves.push_back(std::move(made));
      }
    } catch (const Error& error) {
      throw Error(
          ErrorCode::bad_input,
          fmt::format("{}: figure '{}', curve {} of '{}'", study.file, figure.name, i, curve.run),
          error.message());
    }
  }
  for (const PublishedPoints& points : figure.published) {
    Curve made{points.title, points.x, points.y};
    made.style = CurveStyle::points;
    made.colour = next == 1 ? Colour::vermillion : Colour::black;
    panel.curves.push_back(std::move(made));
  }
  return {"", {std::move(panel)}};
}

std::vector<std::string> list_undrawn_figures(const StudyAnswers& answers) {
  std::vector<std::string> reasons;
  for (const StudyFigure& figure : answers.study->figures) {
    if (!is_computed(figure, answers)) continue;
    if (auto reason = find_missing_answer(figure, answers)) reasons.push_back(std::move(*reason));
  }
  return reasons;
}

void check_results_folder(const RegressionStudy& study, const std::string& folder,
                          const std::string& filter) {
  const std::vector<fs::path> inputs = list_inputs(study);
  for (const std::string& name : list_outputs(study, filter)) {
    const fs::path output = fs::path(folder) / name;
    for (const fs::path& input : inputs) {
      std::error_code missing;  // then it is nothing that could be lost
      if (!fs::equivalent(output, input, missing)) continue;
      throw Error(ErrorCode::bad_input, "--output",
                  fmt::format("'{}': the result {} would overwrite {}, which the study reads: give "
                              "a folder of its own",
                              folder, name, input.string()));
    }
  }
}

std::string write_study_page(const StudyAnswers& answers, const std::vector<CheckRow>& rows) {
  const RegressionStudy& study = *answers.study;
  std::string body = "<h1>" + html_escape(study.name) + "</h1>\n" + html_paragraph(study.about);
  for (std::size_t i = 0; i < study.figures.size(); ++i) {
    if (!is_computed(study.figures[i], answers)) continue;
    if (const auto reason = find_missing_answer(study.figures[i], answers)) {
      body += html_paragraph(*reason);
      continue;
    }
    body += html_figure(figure_as_svg(make_study_figure(study, study.figures[i], answers),
                                      fmt::format("figure{}", i)),
                        study.figures[i].caption);
  }
  return html_page(study.name, body + "<h2>Figures in numbers</h2>\n" + write_rows(rows));
}

std::vector<std::string> write_study_results(const StudyAnswers& answers,
                                             const std::vector<CheckRow>& rows,
                                             const std::string& folder) {
  std::error_code failed;
  fs::create_directories(folder, failed);
  if (failed) throw Error(ErrorCode::bad_input, folder, "cannot be made: " + failed.message());
  std::vector<std::string> written;
  const auto write = [&](const std::string& name, const std::string& text) {
    write_text_file((fs::path(folder) / name).string(), text);
    written.push_back(name);
  };
  const std::vector<std::string> known = known_result_commands();
  std::vector<json> results;
  std::vector<std::string> names;
  for (const RunAnswer& run : answers.runs) {
    for (std::size_t k = 0; k < run.points.size(); ++k) {
      const PointAnswer& point = run.points[k];
      if (point.answer.is_null()) continue;
      const std::string name = name_of_point(*run.run, k);
      write(name + ".json",
            point.answer.dump(1, ' ', false, json::error_handler_t::replace) + "\n");
      if (!point.csv.empty()) write(name + ".csv", point.csv);
      const bool is_known =
          std::find(known.begin(), known.end(), point.answer.value("command", "")) != known.end();
      if (!is_known || k > 0) continue;  // of a run that varies one stands for all
      results.push_back(point.answer);
      names.push_back(name + ".json");
    }
  }
  for (const StudyFigure& figure : answers.study->figures) {
    if (!is_computed(figure, answers) || find_missing_answer(figure, answers)) continue;
    render_figure(make_study_figure(*answers.study, figure, answers),
                  (fs::path(folder) / (figure.name + ".svg")).string());
    written.push_back(figure.name + ".svg");
  }
  write("report.html", write_study_page(answers, rows));
  if (!results.empty()) {
    write_report(results, (fs::path(folder) / "results.html").string(), names);
    written.emplace_back("results.html");
  }
  return written;
}

}  // namespace gyrator
