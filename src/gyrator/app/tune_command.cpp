// tune: from a wanted wall to the amplifier's settings, raised in steps and measured at each.
#include "gyrator/amplifiers/modbus_bench.hpp"
#include "gyrator/amplifiers/settings_guard.hpp"
#include "gyrator/core/error.hpp"
#include "gyrator/documents/csv.hpp"
#include "gyrator/documents/output_file.hpp"
#include "gyrator/studies/motion_terms.hpp"
#include "gyrator/studies/result_parts.hpp"
#include "gyrator/studies/tuning_result.hpp"

#include <algorithm>
#include <memory>
#include <unistd.h>

#include <fmt/core.h>

#include "commands.hpp"
#include "common_options.hpp"
#include "device_options.hpp"
#include "usage_errors.hpp"

namespace gyrator::app {
namespace {

using nlohmann::json;

struct TuneOptions {
  CommonOptions common;
  DeviceOptions device;
  std::string circuit = "rc";
  std::string margin = "1.2", cancellation, most_cancellation = "0.85", current, watch;
  std::string from = "3 Hz", to = "400 Hz", points = "10";
  std::string tuned_model;
};

TuningOptions make_tuning_options(const TuneOptions& options) {
  TuningOptions tuning;
  TuningTarget& target = tuning.target;
  target.circuit =
      options.circuit == "cancellation" ? TuningCircuit::cancellation : TuningCircuit::rc;
  target.margin = parse_option("--margin", options.margin, dimension::none);
  if (!(target.margin >= 1))
    throw Error(ErrorCode::bad_input, "--margin", options.margin + ": must be at least 1");
  target.most_cancellation =
      parse_option("--most-cancellation", options.most_cancellation, dimension::none);
  if (!(target.most_cancellation > 0 && target.most_cancellation < 1))
    throw Error(ErrorCode::bad_input, "--most-cancellation",
                options.most_cancellation + ": must lie between 0 and 1, such as 0.85");
  if (!options.cancellation.empty()) {
    target.cancellation = parse_option("--cancellation", options.cancellation, dimension::none);
    if (!(*target.cancellation > 0 && *target.cancellation <= target.most_cancellation))
      throw Error(ErrorCode::bad_input, "--cancellation",
                  fmt::format("{}: must be above 0 and at most --most-cancellation, {}",
                              options.cancellation, options.most_cancellation));
    target.circuit = TuningCircuit::cancellation;
  }
  if (!options.current.empty()) {
    tuning.current = parse_option("--current", options.current, dimension::current);
    if (!(tuning.current > 0))
      throw Error(ErrorCode::bad_input, "--current", options.current + ": must be above 0 A");
  }
  tuning.lowest_hz = parse_option("--from", options.from, dimension::frequency);
  tuning.highest_hz = parse_option("--to", options.to, dimension::frequency);
  if (!(tuning.lowest_hz > 0 && tuning.highest_hz > tuning.lowest_hz))
    throw Error(ErrorCode::bad_input, "--from, --to",
                fmt::format("{} to {}: must rise, from above 0 Hz", options.from, options.to));
  const double points = parse_option("--points", options.points, dimension::none);
  tuning.frequencies = static_cast<int>(points);
  if (!(points >= 4 && points <= 100) || tuning.frequencies != points)
    throw Error(ErrorCode::bad_input, "--points",
                options.points + ": must be a whole number from 4 to 100");
  if (!options.watch.empty()) {
    tuning.watch = parse_option("--watch", options.watch, dimension::time);
    if (target.circuit != TuningCircuit::cancellation)
      throw Error(ErrorCode::bad_input, "--watch",
                  "follows a cancelled winding: it goes with --circuit cancellation");
    if (!(tuning.watch >= 0))
      throw Error(ErrorCode::bad_input, "--watch", options.watch + ": must be at least 0 s");
  }
  return tuning;
}

std::string describe_values(const std::vector<Setting>& settings) {
  std::string text;
  for (const Setting& setting : settings) {
    const bool is_capacitance = setting.name == "damping_capacitance";
    text += fmt::format("{}{} {:.6g} {}", text.empty() ? "" : ", ", setting.name,
                        is_capacitance ? setting.value * 1e6 : setting.value,
                        is_capacitance ? "uF" : "ohm");
  }
  return text;
}

// One line for each step, while it goes on.
void report_step(const TuningStep& step, const std::string& unit) {
  print_note(fmt::format(
      "{:7.1f} s  {}: winding {:.4g} ohm, damping {:.4g} (model {:.4g}) {} at {:.3g} Hz{}\n",
      step.time, describe_values(step.settings), step.winding_resistance, step.measured_damping,
      step.modelled_damping, unit, step.frequency_hz,
      step.stable ? "" : "  STOPPED: " + step.remark));
}

std::string describe_run(const json& result, const std::string& unit) {
  std::string text = result["model_name"].get<std::string>() + ": ";
  text += tuning_sentence(result) + "\n";
  if (result["verdict"].is_null()) return text;
  text += fmt::format("The command per effort that this holds for: {:.6g} {}.\n",
                      result["command_per_effort"].get<double>(),
                      result["units"]["command_per_effort"].get<std::string>());
  text += fmt::format("\n{:>12}  {:>12}  {:>25}  {:>12}\n", "frequency", "measured",
                      "99 % interval", "model");
  const auto number = [&](const char* key, std::size_t i) {
    return result[key][i].is_null() ? std::nan("") : result[key][i].get<double>();
  };
  for (std::size_t i = 0; i < result["frequency_hz"].size(); ++i) {
    text += fmt::format("{:>9.4g} Hz  {:>12.4g}  {:>12.4g} {:>12.4g}  {:>12.4g}  {}\n",
                        number("frequency_hz", i), number("impedance_real", i),
                        number("damping_low", i), number("damping_high", i),
                        number("modelled_impedance_real", i), unit);
  }
  return text;
}

void write_points(const std::string& path, const json& result) {
  const std::vector<std::string> names{"frequency_hz",
                                       "impedance_real",
                                       "impedance_imag",
                                       "damping_low",
                                       "damping_high",
                                       "actuation_real",
                                       "actuation_imag",
                                       "modelled_impedance_real",
                                       "modelled_impedance_imag",
                                       "modelled_actuation_real",
                                       "modelled_actuation_imag"};
  std::vector<std::vector<double>> columns;
  for (const std::string& name : names)
    columns.push_back(result.contains(name) ? result[name].get<std::vector<double>>()
                                            : std::vector<double>());
  write_csv(path, names, columns);
}

// What the circuit needs besides its values.
std::vector<Setting> complete_settings(const TuningChoice& choice, const Bench& bench) {
  std::vector<Setting> settings = choice.settings;
  if (choice.circuit == TuningCircuit::rc && bench.has_setting("damping_connected"))
    settings.push_back({"damping_connected", 1});
  for (const std::string& name : find_disturbing_settings(bench)) {
    const bool is_set = std::any_of(settings.begin(), settings.end(),
                                    [&](const Setting& s) { return s.name == name; });
    if (!is_set) settings.push_back({name, 0});
  }
  return settings;
}

// What was measured is what is kept: another program, or the device itself, may have changed it
// since.
void check_untouched(AmplifierPort& port, const std::vector<Setting>& settings) {
  for (const Setting& setting : settings) {
    const DeviceRegister& place = port.profile().at(setting.name);
    const double wanted = find_nearest_value(place, setting.value);
    const std::optional<double> found = port.read(setting.name);
    if (found == wanted) continue;
    throw Error(ErrorCode::device, fmt::format("{} ({})", place.name, place.describe_place()),
                fmt::format("reads {}, not the {} that was set and measured: something else has "
                            "written to the device; nothing is kept",
                            found ? describe_value(place, *found) : "no value",
                            describe_value(place, wanted)));
  }
}

// What was asked for by option and the amplifier cannot do.
void check_against(const BenchLimits& limits, const TuneOptions& options,
                   const TuningOptions& tuning) {
  if (tuning.current > limits.largest_current)
    throw Error(ErrorCode::bad_input, "--current",
                fmt::format("{}: the amplifier's limit is {:g} A", options.current,
                            limits.largest_current));
  const double highest = find_highest_frequency(limits);
  if (tuning.highest_hz > highest && options.to != TuneOptions{}.to)
    throw Error(ErrorCode::bad_input, "--to",
                fmt::format("{}: this amplifier's generator and buffer are good for {:.4g} Hz",
                            options.to, highest));
}

// The dry run: what the model says, as a plan.
json plan_tuning(AmplifierSession& session, ModbusBench& bench, const Model& model,
                 const TuningOptions& tuning, std::string& text) {
  const TuningChoice choice = naming_file(model, [&] {
    return choose_settings(model.passivity_model(), tuning.target,
                           [&](std::string_view name) { return bench.setting_range(name); });
  });
  AmplifierPort& port = session.port();
  bench.set_mode(mode_of(choice.circuit));
  for (const Setting& setting : complete_settings(choice, bench))
    port.write(setting.name, setting.value);
  json result = make_tuning_plan_result(model, tuning, choice);
  const MotionUnits& units = units_of(model.device.motion);
  text = describe_changes(port.plan());
  if (port.plan().empty()) text = "Nothing to change: the amplifier is set so already.\n";
  text += fmt::format("\nBy the model the wall may then be as stiff as {:.4g} {}{}.\n",
                      choice.max_stiffness, units.stiffness.symbol,
                      choice.reaches_wall ? "" : ": THE WALL IS NOT REACHED with its margin");
  text +=
      "Dry run: nothing was written and nothing moved. With --apply the values are raised in "
      "steps,\nthe motor turning freely, and measured at each.\n";
  result.update(describe_session(port.plan(), false, session.restore()));
  return result;
}

// Registers that the tuning was for stay; those of its experiments go back.
SessionEnd keep_tuned(AmplifierSession& session, ModbusBench& bench, const TuningChoice& choice,
                      bool persist) {
  AmplifierPort& port = session.port();
  bench.set_mode(mode_of(choice.circuit));
  check_untouched(port, complete_settings(choice, bench));
  const SettingsBackup now = port.read_settings();
  SettingsBackup wanted = session.backup();
  std::vector<std::string> kept = tuned_settings();
  kept.emplace_back("drive_mode");
  for (SettingValue& setting : wanted.settings)
    if (std::find(kept.begin(), kept.end(), setting.name) != kept.end())
      if (const SettingValue* found = now.find(setting.name)) setting = *found;
  put_back(port, wanted, true, true);
  if (persist) port.keep_settings();
  return session.keep();
}

json apply_tuning(AmplifierSession& session, ModbusBench& bench, const Model& model,
                  TuningOptions tuning, const TuneOptions& options) {
  const std::string unit(units_of(model.device.motion).damping.symbol);
  if (!options.common.quiet)
    tuning.on_step = [unit](const TuningStep& step) { report_step(step, unit); };
  const TuningRun run =
      naming_file(model, [&] { return tune(bench, model.passivity_model(), tuning); });
  json result = make_tuning_result(model, tuning, run);
  AmplifierPort& port = session.port();
  const bool reached = run.outcome == TuningOutcome::reached;
  const SessionEnd end =
      reached ? keep_tuned(session, bench, run.choice, options.device.persist) : session.restore();
  const auto changes = compare_settings(session.profile(), session.backup(), port.read_settings());
  result.update(describe_session(changes, true, end));
  result["statistics"] = describe_statistics(port.statistics());
  if (reached && !options.tuned_model.empty())
    write_text_file(options.tuned_model, result["tuned_model"].dump(2) + "\n");
  return result;
}

void run_tune(const TuneOptions& options, int& exit_code) {
  check_files({{"the model", options.common.model}, {"the profile", options.device.profile}},
              {{"--csv", options.common.csv},
               {"--svg", options.common.svg},
               {"--png", options.common.png},
               {"--output", options.common.output},
               {"--write-model", options.tuned_model}});
  const Model model = load_model(options.common.model);
  const TuningOptions tuning = make_tuning_options(options);
  const auto session = open_session(make_device_setup(options.device, "tune"));
  ModbusBench bench(session->port());
  check_against(bench.limits(), options, tuning);
  if (!options.device.apply) {
    std::string text;
    json result = plan_tuning(*session, bench, model, tuning, text);
    exit_code = result["reaches_wall"].get<bool>() || tuning.target.cancellation ? 0 : 1;
    CommonOptions common = options.common;
    common.svg.clear();  // nothing was measured that could be drawn
    common.png.clear();
    deliver(common, std::move(result), text);
    return;
  }
  json result = apply_tuning(*session, bench, model, tuning, options);
  if (!options.common.csv.empty()) write_points(options.common.csv, result);
  exit_code = result["outcome"] == "reached" ? 0 : 1;
  const std::string text =
      describe_run(result, std::string(units_of(model.device.motion).damping.symbol)) +
      "Journal: " + result["journal"].get<std::string>() + "\n";
  deliver(options.common, std::move(result), text);
}

}  // namespace

void add_tune_command(CLI::App& app, int& exit_code) {
  auto options = std::make_shared<TuneOptions>();
  CLI::App* command = app.add_subcommand(
      "tune", "Set an amplifier's damping for a model's wall, in steps, each measured");
  command
      ->add_option("MODEL", options->common.model,
                   "Identified model (JSON) with the wall that is wanted as its controller")
      ->required()
      ->check(not_empty());
  add_writing_device_options(*command, options->device);
  command
      ->add_option("--circuit", options->circuit,
                   "rc: R_1 and C across the motor, behind a current amplifier; cancellation: of "
                   "the winding's resistance, in a voltage amplifier")
      ->check(CLI::IsMember({"rc", "cancellation"}))
      ->capture_default_str();
  command
      ->add_option("--margin", options->margin,
                   "By how much the passive limit must exceed the wall's stiffness")
      ->capture_default_str();
  command->add_option(
      "--cancellation", options->cancellation,
      "Cancel this share of the winding, as warm as it is, whatever the wall: 0.85");
  command
      ->add_option("--most-cancellation", options->most_cancellation,
                   "Never cancel more than this share")
      ->capture_default_str();
  command->add_option("--current", options->current,
                      "Amplitude of the measuring sines; by default a fifth of the current limit");
  command->add_option("--from", options->from, "Lowest of the measuring sines")
      ->capture_default_str();
  command
      ->add_option("--to", options->to,
                   "Highest of them; beyond it the model stands for the measurement")
      ->capture_default_str();
  command->add_option("--points", options->points, "How many of them")->capture_default_str();
  command->add_option("--watch", options->watch,
                      "Afterwards follow the winding as it warms for this time: \"60 s\"");
  command
      ->add_option("--write-model", options->tuned_model,
                   "Write the model with the circuit that was set")
      ->type_name("FILE")
      ->check(not_empty());
  add_output_options(*command, options->common,
                     "Write measured and modelled impedance and actuation",
                     "gyrator tune motor.json --connect tcp://127.0.0.1:1502 --profile "
                     "gyrator_twin --apply -o tuned.json\n\nWithout --apply: a plan, nothing is "
                     "written and nothing moves. The shaft must be free to turn.\n\nExit codes: 0 "
                     "reached, 1 not reached and everything put back, 2 bad input, 4 device or "
                     "communication failure, or refused for safety.");
  command->callback([options, &exit_code] { run_tune(*options, exit_code); });
}

}  // namespace gyrator::app
