#include "gyrator/studies/report_sections.hpp"

#include "gyrator/core/error.hpp"
#include "gyrator/core/text.hpp"
#include "gyrator/plots/html.hpp"
#include "gyrator/plots/pretty_text.hpp"
#include "gyrator/studies/design_section.hpp"
#include "gyrator/studies/envelope_result.hpp"
#include "gyrator/studies/environment_result.hpp"
#include "gyrator/studies/identification_result.hpp"
#include "gyrator/studies/result_fields.hpp"
#include "gyrator/studies/result_figures.hpp"
#include "gyrator/studies/tuning_result.hpp"
#include "gyrator/studies/two_port_section.hpp"
#include "gyrator/studies/workspace_result.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <string_view>
#include <vector>

#include <fmt/format.h>

namespace gyrator {
namespace {

using nlohmann::json;
using Rows = std::vector<std::vector<HtmlCell>>;

HtmlCell number(double value, std::string_view unit = {}) {
  return {pretty_quantity(value, unit), "number"};
}

HtmlCell frequency_cell(double hz) {
  return {pretty_frequency(hz), "number"};
}

/// "yes" and "no" in the page's colours; "–" for null or missing.
HtmlCell answer(const json& object, const std::string& key, bool coloured) {
  const auto at = object.find(key);
  if (at == object.end() || !at->is_boolean()) return {"–"};
  const std::string word = at->get<bool>() ? "yes" : "no";
  return {word, coloured ? word : std::string()};
}

// ---- Passivity --------------------------------------------------------------------------------

std::string wall_in_words(const json& result) {
  return fmt::format(
      "a wall of stiffness {} and damping {}",
      pretty_quantity(optional_number(result, "stiffness"), unit_of(result, "stiffness")),
      pretty_quantity(optional_number(result, "virtual_damping"), unit_of(result, "damping")));
}

std::string criteria_table(const json& result) {
  Rows rows;
  const auto& criteria = required_array(result, "criteria", "passivity result");
  for (const auto& criterion : criteria)
    rows.push_back(
        {{criterion_title(optional_text(criterion, "name"))},
         answer(criterion, "applies", false),
         answer(criterion, "holds", optional_flag(criterion, "applies", true)),
         number(optional_number(criterion, "margin"), unit_of(result, "damping")),
         frequency_cell(optional_number(criterion, "worst_frequency_hz")),
         number(optional_number(criterion, "max_stiffness"), unit_of(result, "stiffness")),
         {optional_text(criterion, "reason")}});
  return html_table(
      {"Criterion", "Applies", "Holds", "Margin", "Worst frequency", "Largest stiffness", "Reason"},
      rows);
}

std::string counterexample_html(const json& result) {
  if (!has(result, "counterexample")) return {};
  const auto& example = result["counterexample"];
  Rows rows = {
      {{"Operator"}, {operator_in_words(result)}},
      {{"Spectral radius of the loop"}, number(optional_number(example, "spectral_radius"), {})},
      {{"Frequency of the growing motion"},
       frequency_cell(optional_number(example, "frequency_hz"))}};
  rows[1][1].text = pretty_number(optional_number(example, "spectral_radius"), 7);
  if (has(example, "simulation"))
    rows.push_back({{"Simulated run"}, {optional_text(example["simulation"], "classification")}});
  return "<h3>An operator that shows it</h3>\n" +
         html_paragraph(
             "This operator cannot supply energy, yet with it the sampled loop's own motion "
             "grows by the spectral radius at every sample: above 1, it never comes to rest.") +
         html_table({}, rows);
}

std::string how_to_read(const json& result) {
  std::string text =
      "The device's own damping, what the controller adds or takes away, their sum (the textbook "
      "criterion asks it to stay above zero) and the exact effective damping; where this is below "
      "zero, shaded, some passive operator gains energy.";
  if (has(result, "disk"))
    text +=
        " Every response of the loop that a passive operator can bring about lies in the disk; "
        "with −1/H inside, one of them makes the loop unstable.";
  if (has(result, "counterexample"))
    text += " Last, the run that shows it, cut off where it has grown thirtyfold.";
  return text;
}

ReportSection passivity_section(const json& result) {
  return {"Passivity",
          html_paragraph("Judged: " + wall_in_words(result) + ". " +
                         optional_text(result, "explanation")) +
              criteria_table(result) + counterexample_html(result),
          how_to_read(result)};
}

std::string passivity_sentence(const json& result) {
  if (optional_text(result, "verdict") == "passive")
    return "Passive: with " + wall_in_words(result) +
           ", no passive operator, from a loose finger to a heavy tool, can make it unstable" +
           (has(result, "operating_point") ? " while its motion stays small: the device is not "
                                             "linear, see the simulation."
                                           : ".");
  if (has(result, "counterexample"))
    return "Not passive: with " + wall_in_words(result) + ", it becomes unstable with " +
           operator_in_words(result) + ".";
  return "Not passive: with " + wall_in_words(result) +
         ", the exact criterion fails; no single operator that shows it has been found.";
}

// ---- Z-width ----------------------------------------------------------------------------------

ReportSection zwidth_section(const json& result) {
  Rows rows;
  for (const auto& boundary : required_array(result, "boundaries", "zwidth result")) {
    const auto damping = required_numbers(boundary, "damping", "zwidth result: /boundaries");
    const auto stiffness =
        required_numbers(boundary, "max_stiffness", "zwidth result: /boundaries");
    std::size_t best = 0;
    for (std::size_t i = 0; i < std::min(damping.size(), stiffness.size()); ++i)
      if (!(stiffness[i] <= stiffness[best])) best = std::isnan(stiffness[i]) ? best : i;
    if (damping.empty() || stiffness.empty()) continue;
    rows.push_back({{criterion_title(optional_text(boundary, "criterion"))},
                    number(stiffness[best], unit_of(result, "stiffness")),
                    number(damping[best], unit_of(result, "damping"))});
  }
  return {"Z-width", html_table({"Criterion", "Largest stiffness", "At virtual damping"}, rows),
          "Each curve is the largest stiffness that its criterion allows at a virtual damping; "
          "below it, the criterion calls the wall passive or stable. The model's own wall is the "
          "point."};
}

// ---- Comparison of designs ----------------------------------------------------------------

// What is left of the best stiffness at another winding temperature.
HtmlCell change_cell(const json& changed, double nominal) {
  if (!optional_flag(changed, "stable", true)) return {"unstable", "no"};
  const double now = optional_number(changed, "max_stiffness");
  if (std::isnan(now)) return {"no limit"};
  const double ratio = now / nominal;
  if (!std::isfinite(ratio)) return {"–"};
  return {"× " + pretty_number(ratio, 3), "number"};
}

ReportSection compare_section(const json& result) {
  const std::string place = "compare result: /designs";
  Rows rows;
  for (const auto& design : required_array(result, "designs", "compare result")) {
    const auto& best = required(design, "best", place);
    const double stiffness = optional_number(best, "max_stiffness");
    rows.push_back(
        {{optional_text(design, "name")},
         number(stiffness, unit_of(result, "stiffness")),
         number(optional_number(best, "damping"), unit_of(result, "damping")),
         number(required_number(design, "damping_1hz", place), unit_of(result, "damping")),
         number(required_number(design, "damping_100hz", place), unit_of(result, "damping")),
         number(required_number(design, "apparent_inertia", place), unit_of(result, "inertia")),
         change_cell(required(design, "colder", place), stiffness),
         change_cell(required(design, "warmer", place), stiffness)});
  }
  const auto step =
      pretty_quantity(required_number(result, "temperature_step", "compare result"), "K");
  return {
      "Designs compared",
      html_table({"Design", "Largest passive stiffness", "At virtual damping", "Damping at 1 Hz",
                  "Damping at 100 Hz", "Apparent inertia", "Stiffness, winding " + step + " colder",
                  "Stiffness, winding " + step + " warmer"},
                 rows),
      "Below its curve a design's wall is passive with every hand, by the exact disk. Damping "
      "and inertia are those felt in free air."};
}

// ---- Simulation -------------------------------------------------------------------------------

std::string ledger_table(const json& result) {
  const auto& energy = required(result, "energy", "simulate result");
  const auto unit = unit_of(result, "energy");
  const auto row = [&](const std::string& name, const char* key) {
    return std::vector<HtmlCell>{
        {name}, number(required_number(energy, key, "simulate result: /energy"), unit)};
  };
  // operator + source = (stored - stored at the start) + dissipated + residual
  const double change =
      required_number(energy, "stored", "simulate result: /energy") -
      (has(energy, "stored_initially") ? optional_number(energy, "stored_initially") : 0.0);
  return "<h3>Energy ledger</h3>\n" +
         html_table({"Energy over the run", "Amount"},
                    {row("Work of the operator on the device", "operator"),
                     row("Work of the amplifier", "source"),
                     {{"Change of what is stored"}, number(change, unit)},
                     row("Turned into heat", "dissipated"),
                     row("Residual: the two works less the rest", "residual")}) +
         html_paragraph(
             "The residual is what the books do not explain; it is the size of the integrator's "
             "error and should be far below the other amounts.");
}

double peak(const json& trace, const char* key) {
  double largest = NAN;
  for (const double value : required_numbers(trace, key, "simulate result: /trace"))
    if (!(std::abs(value) <= largest)) largest = std::isnan(value) ? largest : std::abs(value);
  return largest;
}

// How the run ended, or why it did not.
std::string outcome_of(const json& result) {
  if (!has(result, "failure")) return optional_text(result, "classification");
  const json& failure = result["failure"];
  return "failed: " + optional_text(failure, "place") + ": " + optional_text(failure, "message");
}

ReportSection simulate_section(const json& result) {
  const auto& trace = required(result, "trace", "simulate result");
  const Rows rows = {
      {{"The run"}, {outcome_of(result)}},
      {{"Simulated time"}, number(optional_number(result, "final_time_s"), "s")},
      {{"Samples"}, number(optional_number(result, "steps"))},
      {{"Largest position"}, number(peak(trace, "position"), unit_of(result, "position"))},
      {{"Largest velocity"}, number(peak(trace, "velocity"), unit_of(result, "velocity"))},
      {{"Largest command"}, number(peak(trace, "command"), unit_of(result, "effort"))}};
  return {"Simulation", html_table({}, rows) + ledger_table(result),
          "The run over time. The command is held between samples, hence its steps; the effort is "
          "what the operator feels."};
}

std::string simulate_sentence(const json& result) {
  const auto outcome = outcome_of(result);
  if (outcome.empty()) return {};
  const auto run = "With the model's own operator, the simulated run of " +
                   pretty_quantity(optional_number(result, "final_time_s"), "s");
  if (outcome.starts_with("settle")) return run + " settles.";
  if (outcome.starts_with("diverge")) return run + " diverges.";
  if (outcome == "limit_cycle")
    return run + " ends in a limit cycle: it neither settles nor grows.";
  return run + " ends thus: " + outcome + ".";
}

// ---- Impedance --------------------------------------------------------------------------------

ReportSection impedance_section(const json& result) {
  const std::string place = "impedance result";
  const auto frequency = required_numbers(result, "frequency_hz", place);
  const auto real = required_numbers(result, "impedance_real", place);
  const auto imag = required_numbers(result, "impedance_imag", place);
  const auto gain_real = required_numbers(result, "actuation_real", place);
  const auto gain_imag = required_numbers(result, "actuation_imag", place);
  const auto count =
      std::min({frequency.size(), real.size(), imag.size(), gain_real.size(), gain_imag.size()});
  if (count == 0) return {"Impedance and actuation path", html_paragraph("No frequencies."), {}};
  const auto unit = unit_of(result, "damping");
  Rows rows;
  const auto add = [&](const std::string& name, std::size_t i) {
    rows.push_back({{name},
                    number(frequency[i], "Hz"),
                    number(std::hypot(real[i], imag[i]), unit),
                    number(real[i], unit),
                    number(std::hypot(gain_real[i], gain_imag[i]))});
  };
  const auto lowest = std::min_element(real.begin(), real.begin() + static_cast<long>(count));
  add("Lowest frequency", 0);
  add("Least damping", static_cast<std::size_t>(lowest - real.begin()));
  add("Highest frequency", count - 1);
  return {
      "Impedance and actuation path",
      html_table({"", "Frequency", "|Z|", "Re Z, effective damping", "|A|"}, rows),
      "What the hand feels of the bare device (Z: effort per velocity at the port) and how much "
      "of the commanded effort arrives there (A, 1 for an ideal drive). Where Re Z is negative "
      "the device gives out energy of its own."};
}

ReportSection stability_map_section(const json& result) {
  const std::string place = "stability-map result";
  Rows rows;
  const auto add = [&](const char* text, const char* key) {
    rows.push_back({{text}, number(required_number(result, key, place))});
  };
  add("Points that the analysis calls passive and that do not come to rest",
      "passive_points_that_do_not_rest");
  add("Other points that come to rest", "other_points_that_rest");
  return {"Stability over damping and dry friction", html_table({"", "Points"}, rows),
          "What a quantized, sampled spring wall does after a small and a large kick, against the "
          "borders that the energy of a sample period gives."};
}

// ---- Tolerances -------------------------------------------------------------------------------

std::string per_cent(double share) {
  return pretty_number(100 * share, 4) + " %";
}

// The yield by the samples' share, with its interval.
std::string yield_in_words(const json& result) {
  const json& samples = required(result, "samples", "tolerance result");
  return fmt::format(
      "{} of {} (95 % interval {} to {})", per_cent(required_number(samples, "yield", "samples")),
      describe_count(
          static_cast<std::size_t>(std::max(0.0, required_number(samples, "count", "samples"))),
          "sample"),
      per_cent(required_number(samples, "yield_low", "samples")),
      per_cent(required_number(samples, "yield_high", "samples")));
}

std::string tolerance_sentence(const json& result) {
  return fmt::format(
      "With the tolerances of its parts, {} is passive in {}; {} at the worst case "
      "found.",
      wall_in_words(result), yield_in_words(result),
      optional_flag(required(result, "worst", "tolerance result"), "passive", false)
          ? "passive"
          : "not passive");
}

ReportSection tolerance_section(const json& result) {
  const std::string place = "tolerance result";
  const auto unit = unit_of(result, "stiffness");
  Rows rows;
  for (const json& part : required_array(result, "parts", place)) {
    const auto part_unit = optional_text(part, "unit");
    const auto cell = [&](const char* key, std::string_view cell_unit) {
      return number(optional_number(part, key), cell_unit == "1" ? "" : cell_unit);
    };
    rows.push_back({{optional_text(part, "name")},
                    {optional_text(part, "written")},
                    cell("max_stiffness_at_low", unit),
                    cell("max_stiffness_at_high", unit),
                    cell("sensitivity", ""),
                    cell("rank_correlation", ""),
                    cell("worst", part_unit)});
  }
  const auto limit = [&](const char* key) {
    return pretty_quantity(optional_number(required(result, key, place), "max_stiffness"), unit);
  };
  return {"Tolerances of parts",
          html_table({"Part", "As written", "Largest K at low end", "at high end", "Sensitivity",
                      "Rank correlation", "At the worst case"},
                     rows),
          fmt::format("Largest passive stiffness {} nominally, {} at the worst case found; the "
                      "model's wall is passive in {}. Samples estimate, they prove nothing about "
                      "what lies between them.",
                      limit("nominal"), limit("worst"), yield_in_words(result))};
}

// ---- The one list -----------------------------------------------------------------------------

std::string no_sentence(const json&) {
  return {};
}

struct SectionMaker {
  std::string_view command;
  ReportSection (*section)(const json&);
  std::string (*sentence)(const json&);
};
constexpr auto makers =
    std::to_array<SectionMaker>({{"compare", compare_section, no_sentence},
                                 {"design", design_section, design_sentence},
                                 {"environment", environment_section, environment_sentence},
                                 {"identify", identification_section, identification_sentence},
                                 {"impedance", impedance_section, no_sentence},
                                 {"passivity", passivity_section, passivity_sentence},
                                 {"simulate", simulate_section, simulate_sentence},
                                 {"stability-map", stability_map_section, no_sentence},
                                 {"tolerance", tolerance_section, tolerance_sentence},
                                 {"tune", tuning_section, tuning_sentence},
                                 {"twoport", two_port_section, two_port_sentence},
                                 {"workspace", workspace_section, workspace_sentence},
                                 {"zwidth", zwidth_section, no_sentence},
                                 {"zwidth-envelope", envelope_section, no_sentence}});

const SectionMaker& maker_for(const json& result) {
  const auto command = command_of(result);
  for (const auto& maker : makers)
    if (maker.command == command) return maker;
  throw Error(ErrorCode::bad_input, "/command",
              describe_unknown_name("command", command, known_result_commands()));
}

}  // namespace

ReportSection report_section(const json& result) {
  return maker_for(result).section(result);
}

std::string verdict_sentence(const json& result) {
  return maker_for(result).sentence(result);
}

bool is_bad_news(const json& result) {
  const auto outcome = optional_text(result, "classification");
  const auto verdict = optional_text(result, "verdict");
  const auto tuned = optional_text(result, "outcome");
  return verdict == "not_passive" || verdict == "not_enough" ||
         (command_of(result) == "tune" && tuned != "reached" && tuned != "planned") ||
         !optional_flag(result, "robust", true) || !optional_flag(result, "feasible", true) ||
         !optional_flag(result, "absolutely_stable", true) ||
         (!outcome.empty() && !outcome.starts_with("settle"));
}

std::string finding_in_words(const json& passivity) {
  const auto finding = finding_of(passivity);
  if (!finding.disagree()) return {};
  const auto unit = unit_of(passivity, "stiffness");
  const auto limit = [&](double value) {
    return std::isnan(value) ? std::string("an unknown stiffness")
                             : pretty_quantity(value, unit, 3);
  };
  auto text = fmt::format(
      "The textbook criterion, Re Z + bᵥ > 0, allows {} here. The true limit, from the exact "
      "aliased disk, is {}",
      limit(finding.textbook_limit), limit(finding.true_limit));
  const double ratio = finding.textbook_limit / finding.true_limit;
  if (std::isfinite(ratio) && ratio > 1.05)
    text += fmt::format(": the textbook is {} times too high", pretty_number(ratio, 2));
  text += ". ";
  if (!finding.unsafe())
    return text + "The textbook refuses walls that no passive operator can make unstable.";
  const json textbook = find_criterion(passivity, "frequency_dependent");
  const auto reason = optional_text(textbook, "reason");
  if (!optional_flag(textbook, "applies", true) && !reason.empty())
    text += "The textbook does not apply to this device: " + reason + ". ";
  const auto wall = "K = " + pretty_quantity(optional_number(passivity, "stiffness"), unit);
  if (finding.textbook_holds == finding.exact_holds)
    text += fmt::format("At this model's {} both come to the same verdict. ", wall);
  if (!has(passivity, "counterexample")) return text;
  const auto& example = passivity["counterexample"];
  return text + fmt::format(
                    "The proof is {}: with {} the motion grows by the factor {} at every sample, "
                    "near {}.",
                    operator_in_words(passivity), wall,
                    pretty_number(optional_number(example, "spectral_radius"), 7),
                    pretty_frequency(optional_number(example, "frequency_hz"), 3));
}

}  // namespace gyrator
