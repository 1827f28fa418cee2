#include "gyrator/core/error.hpp"
#include "gyrator/documents/csv.hpp"
#include "gyrator/studies/comparison.hpp"
#include "gyrator/studies/model_format.hpp"

#include <algorithm>
#include <cmath>
#include <memory>

#include <fmt/core.h>

#include "commands.hpp"
#include "common_options.hpp"
#include "usage_errors.hpp"

namespace gyrator::app {
namespace {

struct Options {
  CommonOptions common;
  std::vector<std::string> models;
  std::string damping, temperature_step = "25 K";
  int points = 61;
};

std::string in_unit(const nlohmann::json& value, const Unit& unit) {
  return value.is_null() ? "unbounded" : format_quantity(value, unit);
}

// "×0.50", or what is wrong there.
std::string describe_change(const nlohmann::json& changed, const nlohmann::json& nominal) {
  if (!changed["stable"].get<bool>()) return "unstable";
  const auto& now = changed["max_stiffness"];
  if (now.is_null()) return "unbounded";
  if (nominal.is_null() || nominal.get<double>() == 0) return "-";
  return fmt::format("x {:.3f}", now.get<double>() / nominal.get<double>());
}

std::string describe(const nlohmann::json& result, const MotionUnits& units) {
  std::size_t width = 6;
  for (const auto& d : result["designs"])
    width = std::max(width, d["name"].get<std::string>().size());
  const double step = result["temperature_step"];
  std::string text = fmt::format(
      "{:<{}}  {:>14}  {:>14}  {:>19}  {:>19}  {:>19}  {:>15}  {:>10}  {:>10}\n", "design", width,
      "K at B = 0", "largest K", "at B", "damping at 1 Hz", "at 100 Hz", "inertia felt",
      fmt::format("K, -{:g} K", step), fmt::format("K, +{:g} K", step));
  for (const auto& d : result["designs"]) {
    const auto& best = d["best"];
    const bool feasible =
        std::any_of(d["feasible"].begin(), d["feasible"].end(), [](bool f) { return f; });
    const auto at_zero = std::find(d["damping"].begin(), d["damping"].end(), nlohmann::json(0.0)) -
                         d["damping"].begin();
    const bool has_zero = at_zero < static_cast<std::ptrdiff_t>(d["damping"].size());
    const auto index = static_cast<std::size_t>(at_zero);
    text += fmt::format(
        "{:<{}}  {:>14}  {:>14}  {:>19}  {:>19}  {:>19}  {:>15}  {:>10}  {:>10}\n",
        d["name"].get<std::string>(), width,
        !has_zero                           ? "-"
        : !d["feasible"][index].get<bool>() ? "none"
                                            : in_unit(d["max_stiffness"][index], units.stiffness),
        feasible ? in_unit(best["max_stiffness"], units.stiffness) : "none",
        feasible ? in_unit(best["damping"], units.damping) : "-",
        in_unit(d["damping_1hz"], units.damping), in_unit(d["damping_100hz"], units.damping),
        in_unit(d["apparent_inertia"], units.inertia),
        describe_change(d["colder"], best["max_stiffness"]),
        describe_change(d["warmer"], best["max_stiffness"]));
  }
  return text +
         "\nPassive K by the exact disk; damping and inertia in free air; the last two columns: "
         "what is left of the largest K\nat the same B with the winding colder or warmer.\n";
}

void write_boundaries(const std::string& path, const nlohmann::json& result) {
  std::vector<double> design, damping, stiffness;
  for (std::size_t i = 0; i < result["designs"].size(); ++i) {
    const auto& d = result["designs"][i];
    for (std::size_t k = 0; k < d["damping"].size(); ++k) {
      design.push_back(static_cast<double>(i));
      damping.push_back(d["damping"][k]);
      const auto& limit = d["max_stiffness"][k];
      stiffness.push_back(limit.is_null() ? INFINITY : limit.get<double>());
    }
  }
  write_csv(path, {"design", "damping", "max_stiffness"}, {design, damping, stiffness});
}

void run(const Options& options) {
  std::vector<NamedFile> inputs;
  for (const auto& model : options.models) inputs.push_back({"a model", model});
  check_outputs(options.common, inputs);
  std::vector<Model> models;
  for (const auto& path : options.models) models.push_back(load_model(path));
  const MotionUnits& units = units_of(models.front().device.motion);
  ComparisonRequest request;
  request.points = options.points;
  request.quiet = options.common.quiet;
  if (!options.damping.empty())
    request.damping = parse_list("--damping", options.damping, units.damping);
  request.temperature_step =
      parse_option("--temperature-step", options.temperature_step, dimension::temperature);
  if (!(request.temperature_step > 0)) {
    throw Error(ErrorCode::bad_input, "--temperature-step",
                fmt::format("{:g} K: must be above 0 K", request.temperature_step));
  }
  const nlohmann::json result = make_comparison_result(models, request);
  if (!options.common.csv.empty()) write_boundaries(options.common.csv, result);
  deliver(options.common, result, describe(result, units));
}

}  // namespace

void add_compare_command(CLI::App& app, int&) {
  auto options = std::make_shared<Options>();
  CLI::App* command = app.add_subcommand(
      "compare",
      "Designs side by side: passive stiffness over virtual damping, what is felt, temperature");
  command->add_option("MODELS", options->models, "Model files (JSON)")
      ->required()
      ->check(not_empty());
  add_output_options(*command, options->common, "Write design (by number), damping and limit",
                     "gyrator compare examples/re25_display.json examples/re25_rc_display.json "
                     "--png compared.png");
  command
      ->add_option("--damping", options->damping,
                   "Virtual dampings B, such as 0,0.1mN.m.s/rad; absent: each design's range")
      ->type_name("LIST")
      ->check(not_empty());
  command->add_option("--points", options->points, "Number of dampings in a design's range")
      ->capture_default_str()
      ->check(whole_number_between(3, 100000));
  command
      ->add_option("--temperature-step", options->temperature_step,
                   "Winding colder and warmer by this")
      ->capture_default_str()
      ->check(not_empty());
  command->callback([options] { run(*options); });
}

}  // namespace gyrator::app
