#include "gyrator/studies/report.hpp"

#include "gyrator/core/error.hpp"
#include "gyrator/core/interrupt.hpp"
#include "gyrator/documents/output_file.hpp"
#include "gyrator/plots/html.hpp"
#include "gyrator/plots/interactive_figure.hpp"
#include "gyrator/studies/report_sections.hpp"
#include "gyrator/studies/result_fields.hpp"
#include "gyrator/studies/result_figures.hpp"
#include "gyrator/studies/schematic.hpp"

#include <algorithm>
#include <filesystem>
#include <optional>
#include <set>
#include <system_error>

#include <fmt/format.h>

namespace gyrator {
namespace {

using nlohmann::json;

/// What errors call each result: its own name, or its place in the list.
std::vector<std::string> complete_names(std::vector<std::string> names, std::size_t count) {
  for (std::size_t i = names.size(); i < count; ++i)
    names.push_back(fmt::format("report: result {} of {}", i + 1, count));
  return names;
}

/// Runs `make` and puts the result's name in front of whatever it throws.
template <typename Make>
auto in_result(const std::string& name, const Make& make) {
  try {
    return make();
  } catch (const Error& error) {
    if (error.code() == ErrorCode::interrupted) throw;
    throw Error(error.code(), name + ": " + error.place(), error.message());
  }
}

/// The boundaries that belong to the passivity result: of the same model, or null.
json zwidth_of_same_model(const std::vector<json>& results, const json& passivity) {
  for (const auto& result : results)
    if (optional_text(result, "command") == "zwidth" && has(result, "boundaries") &&
        result.value("model", json()) == passivity.value("model", json()))
      return result;
  return nullptr;
}

/// What the first passivity result whose criteria disagree shows.
struct Finding {
  std::string words;
  std::optional<Figure> figure = {};
  std::string caption = {};
};

Finding make_finding(const std::string& words, const json& passivity, const json& zwidth) {
  Finding finding{words};
  const bool run =
      has(passivity, "counterexample") && has(passivity["counterexample"], "simulation");
  if (!run && zwidth.is_null()) return finding;
  finding.figure = finding_figure(passivity, zwidth);
  if (!zwidth.is_null())
    finding.caption =
        "Largest stiffness over virtual damping by the rules; in the shaded region the textbook "
        "calls passive what is not. ";
  if (run)
    finding.caption +=
        "The run of the operator that shows it: the motion should die out and grows instead.";
  return finding;
}

std::optional<Finding> find_finding(const std::vector<json>& results,
                                    const std::vector<std::string>& names) {
  for (std::size_t i = 0; i < results.size(); ++i) {
    const auto& result = results[i];
    if (optional_text(result, "command") != "passivity") continue;
    auto finding = in_result(names[i], [&]() -> std::optional<Finding> {
      const auto words = finding_in_words(result);
      if (words.empty()) return {};
      return make_finding(words, result, zwidth_of_same_model(results, result));
    });
    if (finding) return finding;
  }
  return {};
}

std::string finding_html(const std::vector<json>& results, const std::vector<std::string>& names) {
  const auto finding = find_finding(results, names);
  if (!finding) return {};
  std::string box =
      "<section class=\"finding\">\n<h2>The finding</h2>\n" + html_paragraph(finding->words);
  if (finding->figure)
    box += html_interactive_figure(*finding->figure, "finding", finding->caption);
  return box + "</section>\n";
}

/// A result's model as a schematic; none where this program reads the model no longer (a result of
/// another version, a file beside it that is gone).
std::string draw_device(const json& model, const std::string& name) {
  try {
    return draw_schematic(parse_model(model, name)).svg;
  } catch (const Error& error) {
    if (error.code() != ErrorCode::bad_input) throw;
    return {};
  }
}

/// The schematics of the results' models, each once.
std::vector<std::string> draw_devices(const std::vector<json>& results,
                                      const std::vector<std::string>& names) {
  std::vector<std::string> drawings;
  std::vector<json> drawn;
  for (std::size_t i = 0; i < results.size(); ++i) {
    const json model = results[i].value("model", json());
    if (model.is_null() || std::find(drawn.begin(), drawn.end(), model) != drawn.end()) continue;
    drawn.push_back(model);
    if (auto svg = draw_device(model, names[i]); !svg.empty()) drawings.push_back(std::move(svg));
  }
  return drawings;
}

std::string devices_html(const std::vector<json>& results, const std::vector<std::string>& names) {
  std::string html;
  for (const auto& svg : draw_devices(results, names))
    html += html_figure(svg,
                        "The device: amplifier, circuits across the motor, motor, mechanics and "
                        "operator from left to right; below, the computer that closes the loop.");
  return html;
}

std::string summary_html(const std::vector<json>& results, const std::vector<std::string>& names) {
  std::string html;
  for (std::size_t i = 0; i < results.size(); ++i) {
    const auto sentence = in_result(names[i], [&] { return verdict_sentence(results[i]); });
    if (sentence.empty()) continue;
    html += fmt::format("<p class=\"verdict{}\">{}</p>\n", is_bad_news(results[i]) ? " bad" : "",
                        html_escape(sentence));
  }
  return html + devices_html(results, names) + finding_html(results, names);
}

std::string section_html(const json& result, std::size_t index) {
  const auto section = report_section(result);
  const auto name = optional_text(result, "model_name");
  std::string html = fmt::format(
      "<section>\n<h2>{}</h2>\n{}",
      html_escape(name.empty() ? section.title : section.title + ": " + name), section.html);
  auto figure = result_figure(result);
  figure.title.clear();  // the heading says it
  if (!figure.panels.empty())
    html += html_interactive_figure(figure, fmt::format("result_{}", index + 1), section.caption);
  return html + "</section>\n";
}

std::string command_line_of(const json& result) {
  const auto at = result.find("command_line");
  if (at == result.end() || at->is_null()) return {};
  if (at->is_string()) return at->get<std::string>();
  std::string line;
  for (const auto& word : *at)
    line += (line.empty() ? "" : " ") + (word.is_string() ? word.get<std::string>() : word.dump());
  return line;
}

/// Models and command lines, each once, and the program that made the results.
std::string origin_html(const std::vector<json>& results) {
  std::string lines;
  std::set<std::string> programs;
  std::vector<json> models;
  for (const auto& result : results) {
    const auto line = command_line_of(result);
    if (!line.empty()) lines += line + "\n";
    if (const auto program = optional_text(result, "program"); !program.empty())
      programs.insert(program);
    const json model = result.value("model", json());
    if (!model.is_null() && std::find(models.begin(), models.end(), model) == models.end())
      models.push_back(model);
  }
  std::string html = "<section>\n<h2>How this was made</h2>\n";
  if (!lines.empty()) html += "<h3>Commands</h3>\n<pre>" + html_escape(lines) + "</pre>\n";
  for (const auto& model : models) {
    const auto name = optional_text(model, "name");
    // A model's text may hold broken UTF-8: shown as '?' rather than refused.
    html += "<h3>Model" + html_escape(name.empty() ? "" : ": " + name) + "</h3>\n<pre>" +
            html_escape(model.dump(2, ' ', false, json::error_handler_t::replace)) + "</pre>\n";
  }
  html += "</section>\n";
  if (!programs.empty())
    html += fmt::format("<footer>Made with {}.</footer>\n",
                        html_escape(fmt::format("{}", fmt::join(programs, ", "))));
  return html;
}

std::string title_of_page(const std::vector<json>& results) {
  for (const auto& result : results)
    if (auto name = optional_text(result, "model_name"); !name.empty()) return name;
  return "Results";
}

}  // namespace

std::string report_as_html(const std::vector<json>& results,
                           const std::vector<std::string>& names_given) {
  if (results.empty())
    throw Error(ErrorCode::bad_input, "report", "no results given; a report needs at least one");
  const auto names = complete_names(names_given, results.size());
  const auto title = title_of_page(results);
  std::string body = "<h1>" + html_escape(title) + "</h1>\n" + summary_html(results, names);
  for (std::size_t i = 0; i < results.size(); ++i) {
    throw_if_interrupted("report");
    body += in_result(names[i], [&] { return section_html(results[i], i); });
  }
  return html_page(title + " – gyrator", body + origin_html(results), PageScript::figures);
}

void write_report(const std::vector<json>& results, const std::string& path,
                  const std::vector<std::string>& names) {
  OutputFile file(path);  // first: a name that cannot be written is told before the work
  file.stream() << report_as_html(results, names);
  file.commit();
}

std::vector<std::string> write_report_figures(const std::vector<json>& results,
                                              const std::string& folder,
                                              const std::vector<std::string>& names_given) {
  std::error_code failure;
  std::filesystem::create_directories(folder, failure);
  if (failure) throw Error(ErrorCode::bad_input, folder, failure.message());
  const auto names = complete_names(names_given, results.size());
  std::vector<std::string> paths;
  const auto path_of = [&](const std::string& name) {
    paths.push_back((std::filesystem::path(folder) / (name + ".svg")).string());
    return paths.back();
  };
  int device = 0;
  for (const auto& svg : draw_devices(results, names)) {
    ++device;
    write_text_file(path_of(device == 1 ? "device" : fmt::format("device-{}", device)), svg);
  }
  if (const auto finding = find_finding(results, names); finding && finding->figure)
    render_figure(*finding->figure, path_of("finding"));
  for (std::size_t i = 0; i < results.size(); ++i) {
    throw_if_interrupted("report");
    const auto figure = in_result(names[i], [&] { return result_figure(results[i]); });
    if (!figure.panels.empty())
      render_figure(figure,
                    path_of(fmt::format("{}-{}", i + 1, optional_text(results[i], "command"))));
  }
  return paths;
}

}  // namespace gyrator
