#include "gyrator/documents/csv.hpp"
#include "gyrator/documents/output_file.hpp"
#include "gyrator/studies/spice_deck.hpp"
#include "gyrator/synthesis/design_result.hpp"

#include <memory>
#include <string>
#include <vector>

#include <fmt/core.h>

#include "commands.hpp"
#include "common_options.hpp"
#include "usage_errors.hpp"

namespace gyrator::app {
namespace {

using nlohmann::json;

struct Options {
  CommonOptions common;
  std::string model_file, spice_file;
};

void write_pareto(const std::string& path, const json& result) {
  std::vector<std::vector<double>> columns(2);
  for (const json& point : result["pareto"]) {
    columns[0].push_back(point["apparent_inertia"]);
    columns[1].push_back(point["max_stiffness"]);
  }
  write_csv(path, {"apparent_inertia", "max_stiffness"}, columns);
}

// What a user would want to know next.
std::string describe_next_steps(const Options& options) {
  const std::string spec = quote_word(options.common.model);
  if (options.model_file.empty())
    return fmt::format(
        "\nnext: gyrator design {} --write-model designed.json\n"
        "      gyrator passivity designed.json\n",
        spec);
  const std::string model = quote_word(options.model_file);
  return fmt::format(
      "\nnext: gyrator passivity {0}\n"
      "      gyrator zwidth {0} --criterion exact_disk,time\n"
      "      gyrator tolerance {0}\n",
      model);
}

void run(const Options& options, int& exit_code) {
  const CommonOptions& common = options.common;
  check_outputs(common, {{"the spec", common.model}});
  check_files({{"the spec", common.model}}, {{"--output", common.output},
                                             {"--csv", common.csv},
                                             {"--svg", common.svg},
                                             {"--png", common.png},
                                             {"--write-model", options.model_file},
                                             {"--spice", options.spice_file}});
  const DesignSpec spec = load_design_spec(common.model);
  const DesignStudy study = run_design_study(spec, common.quiet);
  const json result = make_design_result(spec, study);
  exit_code = study.designs.empty() ? 1 : 0;
  if (!study.designs.empty()) {
    const json& best = study.designs.front().model;
    if (!options.model_file.empty()) write_text_file(options.model_file, best.dump(2) + "\n");
    if (!options.spice_file.empty()) {
      const SpiceDeck deck = make_spice_deck(parse_model(best, spec.model.file), {});
      write_text_file(options.spice_file, deck.text);
    }
  }
  if (!common.csv.empty()) write_pareto(common.csv, result);
  std::string text = describe_design(spec, result);
  if (!study.designs.empty()) text += describe_next_steps(options);
  deliver(common, result, text);
}

}  // namespace

void add_design_command(CLI::App& app, int& exit_code) {
  auto options = std::make_shared<Options>();
  CLI::App* command = app.add_subcommand(
      "design",
      "Chooses damping topology and parts for a wall: stiffest or lightest, what it "
      "costs, and how many of a series keep it");
  command->add_option("SPEC", options->common.model, "What is asked for (JSON, docs/design.md)")
      ->required()
      ->check(not_empty());
  const auto add_file = [&](const char* name, std::string& path, const std::string& help) {
    command->add_option(name, path, help)->type_name("FILE")->check(not_empty());
  };
  command->add_flag("--json", options->common.json, "Print one JSON object and nothing else");
  add_file("-o,--output", options->common.output, "Write the result as JSON");
  add_file("--csv", options->common.csv, "Write the Pareto front");
  add_file("--svg", options->common.svg, "Plot the front and the designs' boundaries");
  add_file("--png", options->common.png, "The same as PNG");
  add_file("--write-model", options->model_file, "Write the best design as a model file");
  add_file("--spice", options->spice_file, "Write the best design as a netlist for ngspice");
  command->add_flag("--quiet", options->common.quiet,
                    "No text and no progress, only files and the exit code");
  command->footer(
      "Example:\n  gyrator design examples/design/re25.json --write-model re25_designed.json\n\n"
      "Exit code 0: there is a design. 1: none keeps the constraints; the one that binds is "
      "named.");
  command->callback([options, &exit_code] { run(*options, exit_code); });
}

}  // namespace gyrator::app
