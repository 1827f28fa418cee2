#include "gyrator/core/error.hpp"
#include "gyrator/documents/json_text.hpp"
#include "gyrator/plots/plot.hpp"
#include "gyrator/studies/report.hpp"
#include "gyrator/studies/result_figures.hpp"

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include <fmt/core.h>

#include "commands.hpp"
#include "common_options.hpp"
#include "usage_errors.hpp"

namespace gyrator::app {
namespace {

struct Options {
  std::vector<std::string> results;
  std::string output = "report.html";
  std::string finding;
  std::string figures;
  bool quiet = false;
};

nlohmann::json load_result(const std::string& path) {
  nlohmann::json result = load_json_file(path);
  if (!result.is_object() || !result.contains("command")) {
    throw Error(
        ErrorCode::bad_input, path,
        "is not a result: write one with -o, such as `gyrator passivity MODEL -o passivity.json`");
  }
  if (!result["command"].is_string()) {
    throw Error(ErrorCode::bad_input, path + ": /command",
                fmt::format("found {}: the name of a command is expected, such as \"passivity\"",
                            result["command"].dump()));
  }
  return result;
}

void check_outputs(const Options& options) {
  if (!options.finding.empty() && !options.finding.ends_with(".svg") &&
      !options.finding.ends_with(".png")) {
    throw Error(ErrorCode::bad_input, "--finding",
                options.finding + ": the name must end in .svg or .png");
  }
  if (!options.figures.empty() && std::filesystem::exists(options.figures) &&
      !std::filesystem::is_directory(options.figures)) {
    throw Error(ErrorCode::bad_input, "--figures", options.figures + ": is no folder");
  }
  std::vector<NamedFile> inputs;
  for (const auto& path : options.results) inputs.push_back({"the result " + path, path});
  check_files(inputs, {{"--output", options.output}, {"--finding", options.finding}});
}

void run(const Options& options) {
  check_outputs(options);
  std::vector<nlohmann::json> results;
  nlohmann::json passivity;
  nlohmann::json zwidth;
  for (const auto& path : options.results) {
    results.push_back(load_result(path));
    if (results.back()["command"] == "passivity") passivity = results.back();
    if (results.back()["command"] == "zwidth") zwidth = results.back();
  }
  write_report(results, options.output, options.results);
  if (!options.finding.empty()) render_figure(finding_figure(passivity, zwidth), options.finding);
  if (!options.figures.empty()) write_report_figures(results, options.figures, options.results);
  if (!options.quiet) fmt::print("{}\n", options.output);
}

}  // namespace

void add_report_command(CLI::App& app, int&) {
  auto options = std::make_shared<Options>();
  CLI::App* command = app.add_subcommand(
      "report", "One self-contained HTML page from results that were kept with -o");
  command->add_option("RESULT", options->results, "Result files (JSON)")
      ->required()
      ->check(not_empty());
  command->add_option("-o,--output", options->output, "The page to write")
      ->capture_default_str()
      ->type_name("FILE")
      ->check(not_empty());
  command
      ->add_option("--finding", options->finding,
                   "Also draw textbook against exact limit as SVG or PNG")
      ->type_name("FILE")
      ->check(not_empty());
  command
      ->add_option("--figures", options->figures,
                   "Also write every figure of the page as an SVG file into this folder")
      ->type_name("DIR")
      ->check(not_empty());
  command->add_flag("--quiet", options->quiet, "Print nothing");
  command->footer(
      "Example:\n  gyrator passivity model.json -o passivity.json; gyrator report passivity.json "
      "-o report.html");
  command->callback([options] { run(*options); });
}

}  // namespace gyrator::app
