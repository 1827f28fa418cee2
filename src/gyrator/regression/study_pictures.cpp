#include "gyrator/regression/study_pictures.hpp"

#include "gyrator/core/error.hpp"
#include "gyrator/core/text.hpp"
#include "gyrator/documents/output_file.hpp"
#include "gyrator/plots/html.hpp"
#include "gyrator/regression/figure_check.hpp"
#include "gyrator/studies/report.hpp"
#include "gyrator/studies/result_figures.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
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

std::string name_of_point(const RunAnswer& run, std::size_t point) {
  return run.run->vary.empty() ? run.run->name : fmt::format("{}.{}", run.run->name, point);
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

bool can_draw(const StudyFigure& figure, const StudyAnswers& answers) {
  return std::all_of(figure.curves.begin(), figure.curves.end(), [&](const StudyCurve& curve) {
    return std::any_of(answers.runs.begin(), answers.runs.end(),
                       [&](const RunAnswer& run) { return run.run->name == curve.run; });
  });
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

std::string write_study_page(const StudyAnswers& answers, const std::vector<CheckRow>& rows) {
  const RegressionStudy& study = *answers.study;
  std::string body = "<h1>" + html_escape(study.name) + "</h1>\n" + html_paragraph(study.about);
  for (std::size_t i = 0; i < study.figures.size(); ++i) {
    if (!can_draw(study.figures[i], answers)) continue;
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
      const std::string name = name_of_point(run, k);
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
    if (!can_draw(figure, answers)) continue;
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
