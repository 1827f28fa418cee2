#include "gyrator/core/text.hpp"
#include "gyrator/documents/csv.hpp"
#include "gyrator/documents/output_file.hpp"
#include "gyrator/studies/certificate.hpp"
#include "gyrator/studies/model_format.hpp"
#include "gyrator/studies/results.hpp"

#include <cmath>
#include <memory>

#include <fmt/core.h>

#include "commands.hpp"
#include "common_options.hpp"
#include "linear_range_text.hpp"
#include "stability_text.hpp"
#include "usage_errors.hpp"

namespace gyrator::app {
namespace {

struct Options {
  CommonOptions common;
  bool simulate = false;
  bool no_counterexample = false;
  std::string certificate;
};

std::string describe_limit(const nlohmann::json& stiffness, const Unit& unit) {
  if (stiffness.is_null()) return "-";
  return stiffness == 0 ? "none" : format_quantity(stiffness, unit);
}

// The verdict's reason without the verdict, which stands before it.
std::string describe_reason(std::string explanation) {
  constexpr std::string_view verdict = "Not passive: ";
  if (!explanation.starts_with(verdict)) return explanation;
  explanation.erase(0, verdict.size());
  if (!explanation.empty() && explanation[0] >= 'a' && explanation[0] <= 'z')
    explanation[0] += 'A' - 'a';
  return explanation;
}

std::string describe_operator(const nlohmann::json& found, const MotionUnits& units) {
  std::string parts;
  const auto add = [&](const std::string& part) { parts += (parts.empty() ? "" : " and ") + part; };
  if (found["inertia"] > 0) {
    add(fmt::format("{}{} of {}", found["stiffness"] > 0 ? "an " : "a plain ",
                    units.inertia == dimension::mass ? "mass" : "inertia",
                    format_quantity(found["inertia"], units.inertia)));
  }
  if (found["stiffness"] > 0)
    add(fmt::format("a spring of {}", format_quantity(found["stiffness"], units.stiffness)));
  for (const auto& resonator : found["resonators"]) {
    add(fmt::format("{} hung on a spring of {}",
                    format_quantity(resonator["inertia"], units.inertia),
                    format_quantity(resonator["stiffness"], units.stiffness)));
  }
  return parts;
}

std::string describe_counterexample(const nlohmann::json& found, const MotionUnits& units) {
  const std::string held = describe_operator(found, units);
  std::string text = held.empty()
                         ? "the free device itself diverges, with nothing in the operator's hand"
                         : held + " in the operator's hand makes the loop diverge";
  const double radius = found["spectral_radius"];
  constexpr double plain_growth = 1e-6;  // less is lost among the digits
  const std::string growth = radius - 1 < plain_growth ? fmt::format("1 + {:.3g}", radius - 1)
                                                       : fmt::format("{:.8g}", radius);
  text +=
      fmt::format("\n(spectral radius {}, {}).", growth, describe_frequency(found["frequency_hz"]));
  if (found.contains("simulation")) {
    const auto& run = found["simulation"];
    text +=
        fmt::format(" Simulated for {}: {}.", format_quantity(run["duration_s"], dimension::time),
                    run["classification"].get<std::string>());
  }
  return "\nCounterexample: " + text + "\n";
}

// Why a search that found nothing does not contradict the verdict.
std::string describe_fruitless_search(const Model& model, const nlohmann::json& result) {
  const double nyquist_hz = 0.5 / model.sampling.period.to_double();
  bool near_nyquist = false;
  for (const auto& c : result["criteria"]) {
    const auto& worst = c["worst_frequency_hz"];
    if (c["name"] == "exact_disk" && !worst.is_null()) near_nyquist = worst > nyquist_hz / 2;
  }
  return fmt::format(
      "\nNo single lossless operator was found that breaks the loop (the search is not exhaustive: "
      "{});\n"
      "the verdict stands on the disk.\n",
      near_nyquist ? "close to the\nNyquist frequency only a razor-thin resonance would"
                   : "only an\noperator of extreme size would");
}

// Of a virtual coupling's tool.
std::string describe_minimum_mass(const nlohmann::json& masses, const MotionUnits& units) {
  const auto mass = [&](const char* scheme) -> std::string {
    const auto& value = masses[scheme];
    if (value.is_null()) return "none";
    return value == 0 ? "any" : format_quantity(value, units.inertia);
  };
  return fmt::format(
      "\nsmallest passive tool: {} explicit, {} semi-implicit, {} implicit integration; it has "
      "{}\n",
      mass("explicit"), mass("semi_implicit"), mass("implicit"),
      format_quantity(masses["tool"], units.inertia));
}

std::string describe(const Model& model, const nlohmann::json& result, const Options& options) {
  const MotionUnits& units = units_of(model.device.motion);
  const bool passive = result["verdict"] == "passive";
  std::string text = fmt::format("{}: {}\n{}\n", model.name, passive ? "PASSIVE" : "NOT PASSIVE",
                                 describe_reason(result["explanation"]));
  if (result.contains("stiffness")) {
    text += fmt::format("\nwall: K = {}, B = {}, T = {}, delay = {}\n",
                        format_quantity(result["stiffness"], units.stiffness),
                        format_quantity(result["virtual_damping"], units.damping),
                        format_quantity(model.sampling.period.to_double(), dimension::time),
                        format_quantity(model.sampling.delay.to_double(), dimension::time));
  }
  text += fmt::format("\n{:<20} {:<8} {:<6} {:>20} {:>12}  {}\n", "criterion", "applies", "holds",
                      "margin", "worst at", "largest K");
  for (const auto& c : result["criteria"]) {
    const auto& worst = c["worst_frequency_hz"];
    text +=
        fmt::format("{:<20} {:<8} {:<6} {:>20} {:>12}  {}\n", c["name"].get<std::string>(),
                    c["applies"].get<bool>() ? "yes" : "no", c["holds"].get<bool>() ? "yes" : "no",
                    c["margin"].is_null() ? "-" : format_quantity(c["margin"], units.damping),
                    worst.is_null() ? "-" : describe_frequency(worst),
                    describe_limit(c["max_stiffness"], units.stiffness));
  }
  if (const auto& proof = result["proof"]; proof["outcome"] == "proved") {
    text +=
        fmt::format("\nproved at every frequency, between the points too: {}, margin at least {}\n",
                    describe_count(proof["intervals"], "interval"),
                    format_quantity(proof["lowest_margin"], units.damping));
  }
  text += describe_nominal_values(model, "Judged");
  if (result.contains("minimum_mass")) text += describe_minimum_mass(result["minimum_mass"], units);
  std::string notes;
  const std::string explanation = result["explanation"];
  for (const auto& c : result["criteria"]) {
    if (explanation.find(c["reason"].get<std::string>()) != std::string::npos)
      continue;  // said above
    if (!c["applies"].get<bool>() &&
        (options.common.verbose || c["holds"].get<bool>() != passive)) {
      notes += fmt::format("{} does not apply: {}.\n", c["name"].get<std::string>(),
                           c["reason"].get<std::string>());
    }
  }
  if (!notes.empty()) text += "\n" + notes;
  if (!passive) {
    if (const auto& found = result["counterexample"]; !found.is_null()) {
      text += describe_counterexample(found, units);
    } else if (!options.no_counterexample && result["device"]["passive"].get<bool>()) {
      text += describe_fruitless_search(model, result);
    } else {
      text += "\n";
    }
    if (!result["extra_damping"].is_null()) {
      text += fmt::format("Another {} of damping at the port would make it passive.\n",
                          format_quantity(result["extra_damping"], units.damping));
    }
  }
  return text + describe_linear_range(model, result) + describe_stability_edges(model, result);
}

void run(const Options& options, int& exit_code) {
  const CommonOptions& common = options.common;
  check_outputs(common);
  check_files({{"the model", common.model},
               {"--output", common.output},
               {"--csv", common.csv},
               {"--svg", common.svg},
               {"--png", common.png}},
              {{"--certificate", options.certificate}});
  const Model model = load_model(common.model);
  const PassivityAnswer answer =
      answer_passivity(model, {!options.no_counterexample, options.simulate});
  const nlohmann::json& result = answer.result;
  if (!options.certificate.empty()) {
    write_text_file(options.certificate, make_certificate(model, answer.verdict).dump(1) + "\n");
  }
  if (!options.common.csv.empty()) {
    const auto& curves = result["damping_over_frequency"];
    const std::vector<std::string> names{"frequency_hz", "physical", "virtual", "total", "exact"};
    std::vector<std::vector<double>> columns;
    for (const auto& name : names) columns.push_back(curves[name]);
    write_csv(options.common.csv, names, columns);
  }
  exit_code = result["verdict"] == "passive" ? 0 : 1;
  deliver(options.common, result, describe(model, result, options));
}

}  // namespace

void add_passivity_command(CLI::App& app, int& exit_code) {
  auto options = std::make_shared<Options>();
  CLI::App* command = app.add_subcommand("passivity",
                                         "Is the loop stable with every passive hand? Verdict, "
                                         "margins, and an operator that breaks it");
  add_common_options(
      *command, options->common, "Write damping over frequency as columns",
      "gyrator passivity examples/rc_display.json --simulate-counterexample --png verdict.png\n\n"
      "Exit code 0: passive. 1: not passive.");
  command->add_flag("--simulate-counterexample", options->simulate,
                    "Also simulate the loop with that operator");
  command->add_flag("--no-counterexample", options->no_counterexample,
                    "Do not search for an operator");
  command
      ->add_option("--certificate", options->certificate,
                   "Write what the verdict rests on, for gyrator verify-certificate")
      ->type_name("FILE")
      ->check(not_empty());
  command->callback([options, &exit_code] { run(*options, exit_code); });
}

}  // namespace gyrator::app
