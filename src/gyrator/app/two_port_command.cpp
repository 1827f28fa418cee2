#include "gyrator/core/error.hpp"
#include "gyrator/core/text.hpp"
#include "gyrator/documents/csv.hpp"
#include "gyrator/studies/motion_terms.hpp"
#include "gyrator/studies/two_port_result.hpp"

#include <array>
#include <cmath>
#include <memory>
#include <string>

#include <fmt/core.h>

#include "commands.hpp"
#include "common_options.hpp"
#include "usage_errors.hpp"

namespace gyrator::app {
namespace {

using nlohmann::json;

struct Options {
  CommonOptions common;
  std::string renderings, sensing, passivity_damping;
  std::string remote, stiffness, damping = "0", delay, delay_back, coupling_at = "both_ends";
  std::string from, to;
  int points = 200;
};

constexpr std::array<const char*, 12> columns{
    "h11_real", "h11_imag", "h12_real", "h12_imag",         "h21_real",         "h21_imag",
    "h22_real", "h22_imag", "margin",   "transmitted_real", "transmitted_imag", "transparency"};

double time_of(const std::string& option, const std::string& text) {
  return text.empty() ? 0 : parse_option_time(option, text).to_double();
}

TwoPortSweep sweep_of(const Options& options) {
  TwoPortSweep sweep;
  if (!options.from.empty())
    sweep.from_hz = parse_option("--from", options.from, dimension::frequency);
  if (!options.to.empty()) sweep.to_hz = parse_option("--to", options.to, dimension::frequency);
  sweep.points = options.points;
  return sweep;
}

// Options of the other kind of two-port would silently do nothing.
void refuse_unused(const Options& options) {
  const bool remote = !options.remote.empty();
  const auto refuse = [&](const char* option, const std::string& value) {
    if (value.empty()) return;
    throw Error(ErrorCode::bad_input, option,
                remote ? "has no meaning between two devices (--remote)"
                       : "belongs to the coupling of two devices: give the other one by --remote");
  };
  if (remote) {
    refuse("--rendering", options.renderings);
    refuse("--passivity-damping", options.passivity_damping);
    if (options.stiffness.empty())
      throw Error(ErrorCode::bad_input, "--coupling-stiffness", "missing: --remote needs one");
  } else {
    refuse("--coupling-stiffness", options.stiffness);
    refuse("--delay", options.delay);
    refuse("--delay-back", options.delay_back);
  }
}

double at_least_zero(const std::string& option, const std::string& text, const Unit& unit) {
  const double value = parse_option(option, text, unit);
  if (value >= 0) return value;
  throw Error(ErrorCode::bad_input, option,
              fmt::format("{:g} {}: must be at least 0", value, unit.symbol));
}

// Whether the second of two words was chosen.
bool is_second(const std::string& option, const std::string& text, const char* first,
               const char* second) {
  if (text == second) return true;
  if (text == first) return false;
  throw Error(ErrorCode::bad_input, option, describe_unknown_name("word", text, {first, second}));
}

json analyse(const Options& options, const Model& model) {
  const MotionUnits& units = units_of(model.device.motion);
  // A coupling that two computers close has to be stable by itself: there the position counts.
  const bool by_position = options.sensing.empty()
                               ? !options.remote.empty()
                               : is_second("--sensing", options.sensing, "velocity", "position");
  const Sensing sensing = by_position ? Sensing::position : Sensing::velocity;
  if (options.remote.empty()) {
    TwoPortRequest request;
    if (!options.renderings.empty())
      request.renderings = parse_names("--rendering", options.renderings);
    request.sensing = sensing;
    if (!options.passivity_damping.empty())
      request.passivity_damping =
          at_least_zero("--passivity-damping", options.passivity_damping, units.damping);
    request.sweep = sweep_of(options);
    return make_two_port_result(model, request);
  }
  RemoteRequest request;
  request.coupling = {at_least_zero("--coupling-stiffness", options.stiffness, units.stiffness),
                      at_least_zero("--coupling-damping", options.damping, units.damping)};
  request.delay_there = time_of("--delay", options.delay);
  request.delay_back = options.delay_back.empty() ? request.delay_there
                                                  : time_of("--delay-back", options.delay_back);
  request.place = is_second("--coupling-at", options.coupling_at, "both_ends", "slave")
                      ? CouplingPlace::slave
                      : CouplingPlace::both_ends;
  request.sensing = sensing;
  request.sweep = sweep_of(options);
  return make_remote_result(model, load_model(options.remote), request);
}

std::string describe_bands(const json& condition) {
  std::string text;
  for (const auto& band : condition["violated_hz"])
    text += fmt::format("{}{} to {}", text.empty() ? "" : ", ", describe_frequency(band[0]),
                        describe_frequency(band[1]));
  return text;
}

// The third condition's is a pure number.
std::string describe_margin(const json& condition) {
  const std::string unit = condition["unit"];
  const json& margin = condition["margin"];
  return fmt::format("{:.5g}{}{}", margin.is_null() ? INFINITY : margin.get<double>(),
                     unit == "1" ? "" : " ", unit == "1" ? "" : unit);
}

std::string describe_conditions(const json& result, const MotionUnits& units) {
  std::string text = fmt::format("{:<21} {:<44} {:>6} {:>21} {:>12}  {}\n", "two-port", "condition",
                                 "holds", "margin", "lowest at", "violated");
  for (const auto& part : result["renderings"]) {
    for (const auto& condition : part["conditions"])
      text += fmt::format(
          "{:<21} {:<44} {:>6} {:>21} {:>12}  {}\n", part["rendering"].get<std::string>(),
          condition["condition"].get<std::string>(), condition["holds"].get<bool>() ? "yes" : "no",
          describe_margin(condition), describe_frequency(condition["worst_frequency_hz"]),
          describe_bands(condition));
    const json& felt = part["least_felt_damping"];
    text += fmt::format(
        "{:<21} least damping felt in front of any passive environment: {} at {}\n",
        part["rendering"].get<std::string>(),
        felt["value"].is_null() ? "without bound" : format_quantity(felt["value"], units.damping),
        describe_frequency(felt["worst_frequency_hz"]));
    if (const json& radius = part["computed_spectral_radius"];
        radius.is_null() || radius.get<double>() > 1)
      text += fmt::format("{:<21} what is computed is unstable by itself: spectral radius {:.4g}\n",
                          part["rendering"].get<std::string>(),
                          radius.is_null() ? INFINITY : radius.get<double>());
  }
  return text;
}

// |Z_te/Z_e| over the sweep, one column for each two-port.
std::string describe_transparency(const json& result, bool verbose) {
  const json& parts = result["renderings"];
  if (parts[0]["transparency"][0].is_null()) return {};
  std::string text = fmt::format("\n|Z_te/Z_e|{:>10}", "Hz");
  for (const auto& part : parts)
    text += fmt::format("  {:>20}", part["rendering"].get<std::string>());
  const auto& frequency = result["frequency_hz"];
  const std::size_t stride = verbose ? 1 : std::max<std::size_t>(1, (frequency.size() + 9) / 10);
  for (std::size_t i = 0; i < frequency.size(); i += stride) {
    text += fmt::format("\n{:>20.5g}", frequency[i].get<double>());
    for (const auto& part : parts) {
      const json& value = part["transparency"][i];
      text += value.is_null() ? fmt::format("  {:>20}", "-")
                              : fmt::format("  {:>20.5g}", value.get<double>());
    }
  }
  return text + "\n";
}

std::string describe_stiffness(const json& value, const Unit& unit) {
  return value.is_null() ? "no limit" : format_quantity(value, unit);
}

std::string describe_tool_limit(const json& value, const MotionUnits& units) {
  return value == 0 ? "none" : describe_stiffness(value, units.stiffness);
}

std::string describe_limits(const json& result, const MotionUnits& units) {
  if (!result.contains("coupling_limits")) return {};
  std::string text = "\nStiffest virtual coupling that is absolutely stable\n";
  for (const auto& limit : result["coupling_limits"]) {
    text += fmt::format("  {} sensed: ", limit["sensing"].get<std::string>());
    if (limit["best"].is_null()) {
      text += "none: the device has no damping at some frequency\n";
      continue;
    }
    text += limit["feasible"].get<bool>()
                ? fmt::format("{} at {} (bounded at {})",
                              describe_stiffness(limit["max_stiffness"], units.stiffness),
                              format_quantity(limit["damping"], units.damping),
                              describe_frequency(limit["worst_frequency_hz"]))
                : fmt::format("none at {}, too large a damping by itself",
                              format_quantity(limit["damping"], units.damping));
    text += fmt::format(", at best {} at {}",
                        describe_stiffness(limit["best"]["max_stiffness"], units.stiffness),
                        format_quantity(limit["best"]["damping"], units.damping));
    if (limit.contains("max_stiffness_with_tool"))
      text += "; with this tool " + describe_tool_limit(limit["max_stiffness_with_tool"], units);
    text += "\n";
  }
  return text;
}

std::string describe(const Model& model, const json& result, bool verbose) {
  const bool remote = result.contains("remote");
  const std::string what =
      remote ? fmt::format("coupled to {}", result["remote"]["name"].get<std::string>())
             : result["rendering"].get<std::string>();
  std::string text = fmt::format(
      "{}, {}: {}\nhybrid matrix [f_h; -v_e] = h [v_h; f_e] up to {}, {} sensed\n\n", model.name,
      what, result["absolutely_stable"].get<bool>() ? "ABSOLUTELY STABLE" : "NOT ABSOLUTELY STABLE",
      describe_frequency(result["nyquist_hz"]), result["sensing"].get<std::string>());
  return text + describe_conditions(result, units_of(model.device.motion)) +
         describe_transparency(result, verbose) +
         describe_limits(result, units_of(model.device.motion)) + describe_nominal_values(model);
}

// One two-port under the plain names, several each under its own.
void write_columns(const std::string& file, const json& result) {
  std::vector<std::string> names{"frequency_hz"};
  std::vector<std::vector<double>> data{result["frequency_hz"]};
  const json& parts = result["renderings"];
  for (const auto& part : parts) {
    for (const char* column : columns) {
      names.push_back(parts.size() == 1 ? std::string(column)
                                        : part["rendering"].get<std::string>() + "_" + column);
      data.emplace_back();
      for (const auto& value : part[column])
        data.back().push_back(value.is_null() ? NAN : value.get<double>());
    }
  }
  write_csv(file, names, data);
}

void run(const Options& options, int& exit_code) {
  std::vector<NamedFile> inputs{{"the model", options.common.model}};
  if (!options.remote.empty()) inputs.push_back({"the remote model", options.remote});
  check_outputs(options.common, inputs);
  refuse_unused(options);
  const Model model = load_model(options.common.model);
  const json result = analyse(options, model);
  if (!options.common.csv.empty()) write_columns(options.common.csv, result);
  deliver(options.common, result, describe(model, result, options.common.verbose));
  exit_code = result["absolutely_stable"].get<bool>() ? 0 : 1;
}

}  // namespace

void add_two_port_command(CLI::App& app, int& exit_code) {
  auto options = std::make_shared<Options>();
  CLI::App* command = app.add_subcommand(
      "twoport",
      "Hybrid matrix between operator and environment (or two devices), absolute stability, "
      "impedance felt; exit code 1 where it is not absolutely stable");
  add_common_options(*command, options->common,
                     "Write frequency, hybrid matrix, third margin and what is felt as columns",
                     "gyrator twoport examples/deformable/table1.json "
                     "--rendering direct,proxy,equivalent_impedance --png twoport.png\n"
                     "  gyrator twoport examples/p3_plant.json --remote examples/p3_plant.json "
                     "--coupling-stiffness \"100 N/m\" --delay 5ms");
  const auto add_text = [&](const char* name, std::string& value, const char* type,
                            const char* help) {
    return command->add_option(name, value, help)->type_name(type)->check(not_empty());
  };
  add_text("--rendering", options->renderings, "LIST",
           "direct, proxy, equivalent_impedance: of the model's values, in this order; by default "
           "the controller's own. The answer is the first one's");
  command
      ->add_option("--sensing", options->sensing,
                   "What the computer knows of the motion: velocity as the published two-ports "
                   "have it (the default), or position, whose difference lags by half a period "
                   "(the default with --remote)")
      ->type_name("WHAT")
      ->check(not_empty());
  add_text("--passivity-damping", options->passivity_damping, "B",
           "Of a passivity controller around direct rendering");
  add_text("--remote", options->remote, "MODEL",
           "A second device, held by another operator, instead of the model's controller");
  add_text("--coupling-stiffness", options->stiffness, "K", "Between the two devices");
  add_text("--coupling-damping", options->damping, "B", "Between the two devices")
      ->capture_default_str();
  add_text("--delay", options->delay, "TIME", "From the device to the remote one; by default none");
  add_text("--delay-back", options->delay_back, "TIME", "Back; by default as --delay");
  command
      ->add_option("--coupling-at", options->coupling_at,
                   "Where the coupling is computed: both_ends (from the own motion and the late "
                   "one) or slave (the remote device; its effort is sent back)")
      ->capture_default_str()
      ->type_name("WHERE")
      ->check(not_empty());
  add_text("--from", options->from, "F", "Lowest frequency (Hz); by default a thousandth of --to");
  add_text("--to", options->to, "F", "Highest frequency (Hz); by default half the computing rate");
  command->add_option("--points", options->points, "Number of frequencies")
      ->capture_default_str()
      ->check(whole_number_between(2, 1000000));
  command->callback([options, &exit_code] { run(*options, exit_code); });
}

}  // namespace gyrator::app
