#include "gyrator/core/quantity.hpp"
#include "gyrator/core/text.hpp"
#include "gyrator/documents/csv.hpp"
#include "gyrator/studies/motion_terms.hpp"
#include "gyrator/studies/tolerance_guarantee.hpp"
#include "gyrator/studies/tolerance_study.hpp"

#include <limits>
#include <memory>
#include <string>
#include <utility>
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
  long samples = 10000;
  long seed = 1;
  std::string distribution = "uniform";
  int threads = 0;
  bool guarantee = false;
  long guarantee_time = 600;  // [s]
  long guarantee_boxes = 20000;
};

std::string describe_limit(const json& limit, const Unit& unit) {
  return limit.is_null() ? "no limit" : format_quantity(limit, unit);
}

std::string describe_outcome(const json& point, const Unit& damping) {
  const std::string outcome = point["outcome"];
  std::string text = outcome == "passive"         ? "the wall is passive"
                     : outcome == "too_stiff"     ? "the wall is too stiff"
                     : outcome == "no_stiffness"  ? "no stiffness is passive at this B"
                     : outcome == "device_active" ? "the device supplies energy by itself"
                                                  : "the device oscillates by itself";
  if (!point["margin"].is_null() && (outcome == "passive" || outcome == "too_stiff"))
    text += fmt::format(", margin {}", format_quantity(point["margin"], damping));
  return text;
}

std::string per_cent(double share) {
  return fmt::format("{:.4g} %", 100 * share);
}

std::string describe_samples(const json& samples, const Unit& stiffness) {
  std::string text = fmt::format("\n{} ({}, seed {}): passive in {} (95 % interval {} to {})\n",
                                 describe_count(samples["count"], "sample"),
                                 samples["distribution"].get<std::string>(),
                                 samples["seed"].get<std::uint64_t>(), per_cent(samples["yield"]),
                                 per_cent(samples["yield_low"]), per_cent(samples["yield_high"]));
  for (const auto& [name, words] : {std::pair{"too_stiff", "the wall is too stiff"},
                                    std::pair{"no_stiffness", "no stiffness is passive"},
                                    std::pair{"device_active", "the device supplies energy"},
                                    std::pair{"device_unstable", "the device oscillates"}}) {
    const std::size_t count = samples["outcomes"][name];
    if (count > 0) text += fmt::format("  {:>8}  {}\n", count, words);
  }
  std::string head = "  ";
  std::string row = "  ";
  for (const auto& q : samples["quantiles"]) {
    const double p = q["probability"];
    const std::string name = p == 0     ? "lowest"
                             : p == 1   ? "highest"
                             : p == 0.5 ? "median"
                                        : fmt::format("{:g} %", 100 * p);
    if (p == 0.25 || p == 0.75) continue;
    head += fmt::format("{:>17}", name);
    row += fmt::format("{:>17}", describe_limit(q["max_stiffness"], stiffness));
  }
  return text + head + "\n" + row + "\n";
}

std::string describe_parts(const json& parts, const Unit& stiffness,
                           const std::vector<Tolerance>& tolerances) {
  std::size_t width = 4;
  std::size_t written_width = 10;
  for (const auto& part : parts) {
    width = std::max(width, part["name"].get<std::string>().size());
    written_width = std::max(written_width, part["written"].get<std::string>().size());
  }
  const auto number = [](const json& value) {
    return value.is_null() ? std::string("-") : fmt::format("{:+.3f}", value.get<double>());
  };
  std::string text = fmt::format("\n{:<{}}  {:<{}} {:>16} {:>16} {:>12} {:>9}  {}\n", "part", width,
                                 "as written", written_width, "K at low end", "K at high end",
                                 "sensitivity", "rank cor.", "worst case");
  for (const auto& part : parts) {
    const Unit* unit = &dimension::none;
    for (const Tolerance& t : tolerances)
      if (t.pointer == part["pointer"]) unit = &t.unit;
    const std::string written = part["written"];
    text += fmt::format(
        "{:<{}}  {:<{}} {:>16} {:>16} {:>12} {:>9}  {}\n", part["name"].get<std::string>(), width,
        written, written_width, describe_limit(part["max_stiffness_at_low"], stiffness),
        describe_limit(part["max_stiffness_at_high"], stiffness), number(part["sensitivity"]),
        number(part["rank_correlation"]), format_quantity(part["worst"], *unit));
  }
  return text;
}

std::string describe(const Model& model, const json& result) {
  const MotionUnits& units = units_of(model.device.motion);
  const json& nominal = result["nominal"];
  const json& worst = result["worst"];
  std::string text = fmt::format(
      "{}: {}\nwall: K = {}, B = {}; {}\n\nlargest passive K (exact disk)\n", model.name,
      result["robust"].get<bool>() ? "PASSIVE in every sample and at the worst case found"
                                   : "NOT PASSIVE with every choice of parts",
      format_quantity(result["stiffness"], units.stiffness),
      format_quantity(result["virtual_damping"], units.damping),
      describe_count(result["parts"].size(), "part with a tolerance", "parts with tolerances"));
  text += fmt::format("  nominal      {:>16}   {}\n",
                      describe_limit(nominal["max_stiffness"], units.stiffness),
                      describe_outcome(nominal, units.damping));
  text += fmt::format("  worst found  {:>16}   {} (found by: {})\n",
                      describe_limit(worst["max_stiffness"], units.stiffness),
                      describe_outcome(worst, units.damping), worst["found_by"].get<std::string>());
  return text + describe_samples(result["samples"], units.stiffness) +
         describe_parts(result["parts"], units.stiffness, model.parts.tolerances);
}

std::string describe_guarantee(const Model& model, const json& guaranteed) {
  const std::string verdict = guaranteed["verdict"];
  const std::string size = fmt::format(
      "{}, {}", describe_count(guaranteed["boxes"], "box of parts", "boxes of parts"),
      describe_count(guaranteed["intervals"], "interval of frequency", "intervals of frequency"));
  if (verdict == "passive")
    return fmt::format("\nguaranteed: PASSIVE with every choice of parts ({})\n", size);
  const Unit& damping = units_of(model.device.motion).damping;
  std::string text =
      verdict == "not_passive"
          ? fmt::format("\nguaranteed: NOT PASSIVE, {} at {:.4g} Hz with\n",
                        guaranteed["margin"].is_null()
                            ? guaranteed["reason"].get<std::string>()
                            : "margin " + format_quantity(guaranteed["margin"], damping),
                        guaranteed["frequency_hz"].get<double>())
          : fmt::format("\nguaranteed: UNDECIDED, {} ({}), at {:.4g} Hz near\n",
                        guaranteed["reason"].get<std::string>(), size,
                        guaranteed["frequency_hz"].get<double>());
  for (const Tolerance& t : model.parts.tolerances) {
    if (guaranteed["at"].contains(t.name))
      text += fmt::format("  {} = {}\n", t.name, format_quantity(guaranteed["at"][t.name], t.unit));
  }
  return text;
}

// One row per sample: its parts, its limit, and the outcome by number.
void write_samples(const std::string& path, const Model& model, const ToleranceStudy& study) {
  std::vector<std::string> names;
  for (const Tolerance& t : model.parts.tolerances) names.push_back(t.name);
  const std::size_t parts = names.size();
  names.insert(names.end(), {"max_stiffness", "outcome"});
  std::vector<std::vector<double>> columns(names.size());
  for (const BoxPoint& sample : study.samples) {
    for (std::size_t i = 0; i < parts; ++i) columns[i].push_back(sample.values[i]);
    columns[parts].push_back(sample.limit.max_stiffness);
    columns[parts + 1].push_back(static_cast<double>(sample.limit.outcome));
  }
  write_csv(path, names, columns);
}

void run(const Options& options, int& exit_code) {
  check_outputs(options.common);
  const Model model = load_model(options.common.model);
  ToleranceRequest request;
  request.samples = static_cast<std::size_t>(options.samples);
  request.seed = static_cast<std::uint64_t>(options.seed);
  if (options.distribution == "normal") request.distribution = SampleDistribution::normal;
  request.threads = options.threads;
  request.quiet = options.common.quiet;
  const ToleranceStudy study = run_tolerance_study(model, request);
  json result = make_tolerance_result(model, request, study);
  exit_code = is_robust(study) ? 0 : 1;
  std::string text = describe(model, result);
  if (options.guarantee) {
    const BoxProof proof =
        prove_tolerances(model,
                         {static_cast<std::size_t>(options.guarantee_boxes),
                          static_cast<double>(options.guarantee_time), options.threads},
                         options.common.quiet);
    result["guaranteed"] = make_guarantee_json(model, proof);
    text += describe_guarantee(model, result["guaranteed"]);
    if (proof.outcome != BoxOutcome::passive) exit_code = 1;
  }
  if (!options.common.csv.empty()) write_samples(options.common.csv, model, study);
  deliver(options.common, result, text);
}

}  // namespace

void add_tolerance_command(CLI::App& app, int& exit_code) {
  auto options = std::make_shared<Options>();
  CLI::App* command = app.add_subcommand(
      "tolerance",
      "Does the wall stay passive with every choice of parts? Worst case, yield, and which part "
      "matters most");
  add_common_options(
      *command, options->common,
      "Write one row per sample: its parts, max_stiffness and outcome (0 passive, 1 too_stiff, 2 "
      "no_stiffness, 3 device_active, 4 device_unstable)",
      "gyrator tolerance examples/rc_display_tolerance.json --samples 200 --svg tolerance.svg\n\n"
      "Tolerances stand in the model file: \"5 ohm ± 5 %\", \"2200 uF +20 % -10 %\", "
      "\"0 K to 40 K\".\n"
      "Exit code 0: passive in every sample and at the worst case found, with --guarantee proved\n"
      "with every choice of parts. 1: not.");
  command->add_option("--samples", options->samples, "Devices drawn at random")
      ->capture_default_str()
      ->check(whole_number_between(1, 1000000));
  command->add_option("--seed", options->seed, "Of the random numbers: the same gives the same")
      ->capture_default_str()
      ->check(whole_number_between(0, std::numeric_limits<long>::max()));
  command
      ->add_option("--distribution", options->distribution,
                   "uniform over the range, or normal with the ends at 3 standard deviations")
      ->capture_default_str()
      ->check(CLI::IsMember({"uniform", "normal"}));
  command->add_option("--threads", options->threads, "Cores to use; 0: all")
      ->capture_default_str()
      ->check(whole_number_between(0, 1024));
  CLI::Option* guarantee =
      command->add_flag("--guarantee", options->guarantee,
                        "Also prove it for every choice of parts within tolerance, or find one for "
                        "which it does not hold");
  command
      ->add_option("--guarantee-time", options->guarantee_time,
                   "Seconds after which a proof is given up as undecided")
      ->capture_default_str()
      ->needs(guarantee)
      ->check(whole_number_between(1, 1000000));
  command
      ->add_option("--guarantee-boxes", options->guarantee_boxes,
                   "Boxes of parts after which a proof is given up as undecided")
      ->capture_default_str()
      ->needs(guarantee)
      ->check(whole_number_between(1, 100000000));
  command->callback([options, &exit_code] { run(*options, exit_code); });
}

}  // namespace gyrator::app
