#include <memory>
#include <string>
#include <vector>

#include <fmt/core.h>

#include "commands.hpp"
#include "gyrator/core/error.hpp"
#include "gyrator/documents/json_text.hpp"
#include "gyrator/plots/plot.hpp"
#include "gyrator/studies/report.hpp"
#include "gyrator/studies/result_figures.hpp"

namespace gyrator::app {
namespace {

struct Options {
  std::vector<std::string> results;
  std::string output = "report.html";
  std::string finding;
  bool quiet = false;
};

void run(const Options& options) {
  std::vector<nlohmann::json> results;
  nlohmann::json passivity;
  nlohmann::json zwidth;
  for (const auto& path : options.results) {
    results.push_back(load_json_file(path));
    if (!results.back().is_object() || !results.back().contains("command")) {
      throw Error(ErrorCode::bad_input, path,
                  "is not a result: write one with -o, such as `gyrator passivity MODEL -o passivity.json`");
    }
    if (results.back()["command"] == "passivity") passivity = results.back();
    if (results.back()["command"] == "zwidth") zwidth = results.back();
  }
  if (!options.finding.empty()) render_figure(finding_figure(passivity, zwidth), options.finding);
  write_report(results, options.output);
  if (!options.quiet) fmt::print("{}\n", options.output);
}

}  // namespace

void add_report_command(CLI::App& app, int&) {
  auto options = std::make_shared<Options>();
  CLI::App* command = app.add_subcommand("report", "One self-contained HTML page from results that were kept with -o");
  command->add_option("RESULT", options->results, "Result files (JSON)")->required();
  command->add_option("-o,--output", options->output, "The page to write")->capture_default_str()->type_name("FILE");
  command->add_option("--finding", options->finding, "Also draw textbook against exact limit as SVG or PNG")
      ->type_name("FILE");
  command->add_flag("--quiet", options->quiet, "Print nothing");
  command->footer(
      "Example:\n  gyrator passivity model.json -o passivity.json; gyrator report passivity.json -o report.html");
  command->callback([options] { run(*options); });
}

}  // namespace gyrator::app
