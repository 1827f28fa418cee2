// identify: the motor and the amplifier behind Modbus, from experiments, as a model file.
#include "gyrator/amplifiers/modbus_bench.hpp"
#include "gyrator/amplifiers/settings_guard.hpp"
#include "gyrator/core/error.hpp"
#include "gyrator/documents/csv.hpp"
#include "gyrator/documents/json_text.hpp"
#include "gyrator/documents/output_file.hpp"
#include "gyrator/studies/identification_result.hpp"
#include "gyrator/studies/model_file.hpp"
#include "gyrator/studies/motion_terms.hpp"

#include <memory>
#include <optional>

#include <fmt/core.h>

#include "commands.hpp"
#include "common_options.hpp"
#include "device_options.hpp"
#include "usage_errors.hpp"

namespace gyrator::app {
namespace {

using nlohmann::json;

struct IdentifyOptions {
  CommonOptions common;  // its output is the result, its model the base
  DeviceOptions device;
  std::string written_model, motion = "rotary", period = "1 ms", name;
  std::string share = "30 %", slow = "1 Hz";
};

IdentificationOptions make_identification_options(const IdentifyOptions& options) {
  IdentificationOptions made;
  made.current_share = parse_option("--share", options.share, dimension::none);
  if (!(made.current_share >= 0.02 && made.current_share <= 0.9))
    throw Error(ErrorCode::bad_input, "--share", options.share + ": must be from 2 % to 90 %");
  made.slow_frequency_hz = parse_option("--slow", options.slow, dimension::frequency);
  if (!(made.slow_frequency_hz >= 0.2 && made.slow_frequency_hz <= 5))
    throw Error(ErrorCode::bad_input, "--slow", options.slow + ": must be from 0.2 to 5 Hz");
  return made;
}

// With a base its motion and name hold.
IdentifiedModelOptions make_model_options(const IdentifyOptions& options,
                                          const std::optional<Model>& base) {
  IdentifiedModelOptions made;
  made.motion = base                         ? base->device.motion
                : options.motion == "linear" ? Motion::linear
                                             : Motion::rotary;
  if (base) made.name = base->name;
  if (!options.name.empty()) made.name = options.name;
  made.period = options.period;
  (void)parse_option_time("--period", options.period);
  return made;
}

void write_sines(const std::string& path, const json& result) {
  const std::vector<std::string> names{"frequency_hz",          "amplitude",
                                       "impedance_real",        "impedance_imag",
                                       "fitted_impedance_real", "fitted_impedance_imag",
                                       "current_real",          "current_imag",
                                       "fitted_current_real",   "fitted_current_imag"};
  std::vector<std::vector<double>> columns;
  for (const std::string& name : names) {
    std::vector<double> column;
    for (const json& value : result["sines"][name])
      column.push_back(value.is_null() ? std::nan("") : value.get<double>());
    columns.push_back(std::move(column));
  }
  write_csv(path, names, columns);
}

void run_plan(const IdentifyOptions& options, const IdentifiedModelOptions& model,
              AmplifierSession& session, ModbusBench& bench) {
  const std::vector<PlannedStep> plan =
      plan_identification(bench.limits(), make_identification_options(options));
  AmplifierPort& port = session.port();
  const std::vector<std::string> disturbing = find_disturbing_settings(bench);
  // As the bench does before the first setting.
  if (!disturbing.empty() && bench.has_setting("enable")) port.write("enable", 0);
  for (const std::string& name : disturbing) port.write(name, 0);
  json result = make_identification_plan_result(plan, model.motion, model.name);
  json registers = json::array();
  std::string names;
  for (const std::string& name : find_experiment_registers(session.profile())) {
    const DeviceRegister& place = session.profile().at(name);
    registers.push_back(
        {{"register", name}, {"address", describe_address(place.table, place.address)}});
    names += fmt::format("  {:<24}  {}\n", name, describe_address(place.table, place.address));
  }
  result["registers"] = std::move(registers);
  std::string text = describe_plan(plan);
  text += "\nSwitched off for the time of the experiments, and put back afterwards:\n" +
          (port.plan().empty() ? std::string("  nothing\n") : describe_changes(port.plan()));
  text += "\nWritten for each experiment, and put back afterwards:\n" + names;
  text +=
      "\nDry run: nothing was written and nothing moved. With --apply the motor turns, freely and "
      "fast,\nboth ways: take off whatever is on its shaft or must not be driven.\n";
  result.update(describe_session(port.plan(), false, session.restore()));
  CommonOptions common = options.common;
  common.svg.clear();  // nothing was measured that could be drawn
  common.png.clear();
  deliver(common, std::move(result), text);
}

std::string describe_found(const json& result, const std::string& written) {
  std::string text = result["model_name"].get<std::string>() + ": ";
  text += identification_sentence(result) + "\n\n" + describe_parameters(result);
  if (!result["winding_temperature"].is_null())
    text += fmt::format("\nWinding at {:.1f} K on the mean.\n",
                        result["winding_temperature"].get<double>());
  if (!written.empty()) text += "\n" + written + "\n";
  return text;
}

void warn_of_unknown(const json& result) {
  for (const json& p : result["parameters"]) {
    if (p["identifiable"].get<bool>()) continue;
    print_note(fmt::format("gyrator: warning: {} is not identifiable: {}\n",
                           p["name"].get<std::string>(), p["note"].get<std::string>()));
  }
}

void run_experiments(const IdentifyOptions& options, const IdentifiedModelOptions& model,
                     const std::optional<Model>& base, AmplifierSession& session,
                     ModbusBench& bench) {
  double begun = 0;
  const Identification found =
      identify(bench, make_identification_options(options), [&](const Experiment& experiment) {
        if (!options.common.quiet)
          print_note(fmt::format("{:7.1f} s  {}: {}\n", begun, experiment.purpose,
                                 describe(experiment.excitation)));
        begun += experiment.excitation.duration;
      });
  const SessionEnd end = session.restore();
  json result = make_identification_result(found, model.motion, model.name);
  result.update(describe_session({}, true, end));
  result["statistics"] = describe_statistics(session.port().statistics());
  if (!options.common.quiet) warn_of_unknown(result);
  if (!options.common.csv.empty()) write_sines(options.common.csv, result);
  CommonOptions common = options.common;
  // What was measured is kept, whether or not it makes a model.
  const std::optional<json> source = base ? std::optional(base->source) : std::nullopt;
  if (!options.written_model.empty()) {
    try {
      const json document = make_identified_model(found, source, model);
      (void)parse_model(document, options.written_model);
      result["identified_model"] = document;
      write_text_file(options.written_model, document.dump(2) + "\n");
    } catch (const Error&) {
      deliver(common, result, describe_found(result, ""));
      throw;
    }
  }
  deliver(common, std::move(result), describe_found(result, options.written_model));
}

void run_identify(const IdentifyOptions& options) {
  const std::vector<NamedFile> inputs{{"--model", options.common.model},
                                      {"--profile", options.device.profile}};
  CommonOptions drawn = options.common;
  drawn.output.clear();
  check_outputs(drawn, inputs);
  std::vector<NamedFile> taken = inputs;
  taken.insert(taken.end(), {{"--csv", drawn.csv}, {"--svg", drawn.svg}, {"--png", drawn.png}});
  check_files(taken, {{"--output", options.written_model}, {"--result", options.common.output}});
  std::optional<Model> base;
  if (!options.common.model.empty()) base = load_model(options.common.model);
  if (base && !base->device.drive.motor)
    throw Error(ErrorCode::bad_input, options.common.model,
                "has no motor: a base for an identified model needs one");
  const IdentifiedModelOptions model = make_model_options(options, base);
  (void)make_identification_options(options);
  const auto session = open_session(make_device_setup(options.device, "identify"));
  ModbusBench bench(session->port());
  if (options.device.apply) {
    run_experiments(options, model, base, *session, bench);
  } else {
    run_plan(options, model, *session, bench);
  }
}

void add_file_options(CLI::App& command, IdentifyOptions& options) {
  const auto add = [&](const char* name, std::string& path, const char* help) {
    command.add_option(name, path, help)->type_name("FILE")->check(not_empty());
  };
  add("--model", options.common.model,
      "Base: the model file whose motor, friction, bandwidth and delay are replaced");
  add("-o,--output", options.written_model, "Write the identified model");
  add("--result", options.common.output,
      "Write the result with all measurements as JSON, for `gyrator report`");
  add("--csv", options.common.csv, "Write the sines, measured and fitted");
  add("--svg", options.common.svg, "Draw measurements, fits and residuals as SVG");
  add("--png", options.common.png, "Draw them as PNG");
  command.add_flag("--json", options.common.json, "Print one JSON object and nothing else");
  command.add_flag("--quiet", options.common.quiet,
                   "No text and no progress, only files and the exit code");
}

}  // namespace

void add_identify_command(CLI::App& app, int&) {
  auto options = std::make_shared<IdentifyOptions>();
  CLI::App* command = app.add_subcommand(
      "identify", "Measure motor and amplifier behind Modbus, with intervals, as a model file");
  add_writing_device_options(*command, options->device);
  add_file_options(*command, *options);
  command
      ->add_option("--share", options->share,
                   "Of the current limit, the largest amplitude of a sine, by default 30 %")
      ->type_name("PERCENT");
  command->add_option("--slow", options->slow,
                      "Frequency of the sines for friction, by default 1 Hz");
  command->add_option("--motion", options->motion, "Without --model: rotary or linear")
      ->check(CLI::IsMember({"rotary", "linear"}))
      ->capture_default_str();
  command->add_option("--period", options->period,
                      "Without --model: of the controller, by default 1 ms");
  command->add_option("--name", options->name, "Of the model, by default the base's");
  command->footer(
      "Example:\n  gyrator identify --connect tcp://127.0.0.1:1502 --profile gyrator_twin --apply "
      "-o motor.json\n\nWithout --apply: the plan, nothing is written and nothing moves. The shaft "
      "must be free to turn.\n\nExit codes: 0 done, 2 bad input, 3 the model asked for lacks what "
      "could not be identified, 4 device or communication failure, or refused for safety.");
  command->callback([options] { run_identify(*options); });
}

}  // namespace gyrator::app
