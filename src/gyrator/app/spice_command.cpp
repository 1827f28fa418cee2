#include "gyrator/core/error.hpp"
#include "gyrator/documents/output_file.hpp"
#include "gyrator/studies/results.hpp"
#include "gyrator/studies/spice_check.hpp"

#include <filesystem>
#include <memory>
#include <optional>

#include <fmt/core.h>

#include "commands.hpp"
#include "common_options.hpp"
#include "usage_errors.hpp"

namespace gyrator::app {
namespace {

struct Options {
  CommonOptions common;  // of which MODEL, --json, -o and --quiet
  bool check = false;
  std::string from = "0.1", to = "1e4", duration, largest_step;
  int points_per_decade = 20;
};

// What the deck's own files begin with: the file's name as far as ngspice takes it unquoted.
std::string choose_data_name(const Options& options) {
  const std::string& path =
      options.common.output.empty() ? options.common.model : options.common.output;
  std::string name = std::filesystem::path(path).stem().string();
  for (char& c : name) {
    const bool kept = (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9');
    const bool upper = c >= 'A' && c <= 'Z';
    c = kept ? c : upper ? static_cast<char>(c - 'A' + 'a') : '_';
  }
  return name.empty() ? "gyrator" : name;
}

SpiceRequest make_request(const Options& options) {
  SpiceRequest request;
  request.from_hz = parse_option("--from", options.from, dimension::frequency);
  request.to_hz = parse_option("--to", options.to, dimension::frequency);
  if (!(request.from_hz > 0)) {
    throw Error(ErrorCode::bad_input, "--from",
                fmt::format("{:g} Hz: must be above 0 Hz", request.from_hz));
  }
  if (!(request.to_hz > request.from_hz)) {
    throw Error(
        ErrorCode::bad_input, "--to",
        fmt::format("{:g} Hz: must be above --from, {:g} Hz", request.to_hz, request.from_hz));
  }
  request.points_per_decade = options.points_per_decade;
  if (!options.duration.empty())
    request.duration = parse_option_time("--duration", options.duration);
  if (!options.largest_step.empty())
    request.largest_step = parse_option_time("--max-step", options.largest_step);
  request.data_name = choose_data_name(options);
  request.quiet = options.common.quiet;
  return request;
}

std::string describe(const Model& model, const std::vector<SpiceDeviation>& check) {
  bool agrees = true;
  for (const auto& d : check) agrees = agrees && d.agrees();
  std::string text = fmt::format("{}: ngspice {}\n\n{:<12}{:>16}{:>12}  {}\n", model.name,
                                 agrees ? "agrees" : "DISAGREES", "quantity", "worst deviation",
                                 "allowed", "where");
  for (const auto& d : check) {
    text += fmt::format("{:<12}{:>16.2e}{:>12.0e}  {}{}\n", d.quantity, d.worst, d.tolerance,
                        d.over_time ? fmt::format("{:g} s", d.at) : describe_frequency(d.at),
                        d.agrees() ? "" : "  <- too far");
  }
  return text;
}

int run(const Options& options) {
  check_outputs(options.common);
  const SpiceRequest request = make_request(options);
  const Model model = load_model(options.common.model);
  const SpiceDeck deck = make_spice_deck(model, request);
  std::optional<std::vector<SpiceDeviation>> check;
  if (options.check) check = check_spice_deck(model, request, deck);

  const std::string& file = options.common.output;
  if (!file.empty()) write_text_file(file, deck.text);
  std::string text = check ? describe(model, *check)
                     : file.empty()
                         ? deck.text
                         : fmt::format("{}: run it with `ngspice -b`; it writes {} and {}\n", file,
                                       deck.impedance_file, deck.motion_file);
  const nlohmann::json result = make_spice_result(model, deck, check);
  CommonOptions printed = options.common;
  printed.output.clear();  // holds the netlist, not the result
  deliver(printed, result, text);
  return check && !result["agrees"].get<bool>() ? 1 : 0;
}

}  // namespace

void add_spice_command(CLI::App& app, int& exit_code) {
  auto options = std::make_shared<Options>();
  CLI::App* command = app.add_subcommand(
      "spice",
      "The continuous plant as a netlist that ngspice runs unchanged: impedance Z, actuation path "
      "A, and the motion under the held command");
  command->add_option("MODEL", options->common.model, "Model file (JSON)")
      ->required()
      ->check(not_empty());
  command->add_flag("--json", options->common.json, "Print one JSON object and nothing else");
  command
      ->add_option("-o,--output", options->common.output,
                   "Write the netlist to a file instead of standard output")
      ->type_name("FILE")
      ->check(not_empty());
  command->add_flag("--check", options->check,
                    "Run ngspice and compare: Z and A to 1e-6 of their magnitude, the motion to "
                    "1e-4 of its largest; exit code 1 where they differ by more");
  command->add_option("--from", options->from, "Lowest frequency of the AC analysis (Hz)")
      ->capture_default_str();
  command->add_option("--to", options->to, "Highest frequency (Hz)")->capture_default_str();
  command
      ->add_option("--points-per-decade", options->points_per_decade,
                   "Frequencies to a factor of ten")
      ->capture_default_str()
      ->check(whole_number_between(1, 10000));
  command
      ->add_option("--duration", options->duration,
                   "Length of the transient instead of the model's")
      ->type_name("TIME")
      ->check(not_empty());
  command
      ->add_option("--max-step", options->largest_step,
                   "Largest step of the transient instead of one by the plant's poles")
      ->type_name("TIME")
      ->check(not_empty());
  command->add_flag("--quiet", options->common.quiet,
                    "No text and no progress, only files and the exit code");
  command->footer(
      "Accuracy of ngspice 39 on what is written: Z and A to rounding, the motion to about 1e-5.\n"
      "Example:\n  gyrator spice examples/rc_display.json -o rc_display.cir --check");
  command->callback([options, &exit_code] { exit_code = run(*options); });
}

}  // namespace gyrator::app
