#include "gyrator/documents/csv.hpp"
#include "gyrator/studies/environment_result.hpp"
#include "gyrator/studies/motion_terms.hpp"

#include <memory>

#include <fmt/core.h>

#include "commands.hpp"
#include "common_options.hpp"
#include "linear_range_text.hpp"
#include "usage_errors.hpp"

namespace gyrator::app {
namespace {

struct Options {
  CommonOptions common;
  std::string profile, coupling;
};

std::string describe(const Model& model, const nlohmann::json& result) {
  const MotionUnits& units = units_of(model.device.motion);
  const bool coupled = !result["coupling_damping"].is_null();
  std::string text =
      fmt::format("{} on {}: {}\n\n", result["profile"]["file"].get<std::string>(), model.name,
                  result["verdict"] == "passive" ? "PASSIVE" : "NOT SHOWN TO BE PASSIVE");
  const auto slope = [&](const char* key, const char* name) {
    const auto& steepest = result[key];
    if (steepest.is_null()) return fmt::format("{}: none\n", name);
    return fmt::format("{}: {}, from {} to {}\n", name,
                       format_quantity(steepest["slope"], units.stiffness),
                       format_quantity(steepest["from"], units.position),
                       format_quantity(steepest["to"], units.position));
  };
  text += slope("steepest_rise", "steepest rise") + slope("steepest_fall", "steepest fall");
  text += fmt::format(
      "alpha, what the sampled environment can use up: {}\ndelta, the device's least damping: {} "
      "at "
      "{}\n",
      format_quantity(result["alpha"], units.damping),
      format_quantity(result["delta"], units.damping),
      describe_frequency(result["delta_frequency_hz"]));
  if (coupled) {
    text += fmt::format("gamma, the coupling's damping: {}; delta gamma/(delta + gamma) = {}\n",
                        format_quantity(result["coupling_damping"], units.damping),
                        format_quantity(result["allowed_alpha"], units.damping));
  }
  text += fmt::format("alpha < {}: {}\n", coupled ? "delta gamma/(delta + gamma)" : "delta",
                      result["inequality_holds"].get<bool>() ? "yes" : "no");
  for (const auto& reason : result["reasons"])
    text += fmt::format("The condition says nothing here: {}.\n", reason.get<std::string>());
  if (!result["effort_factor"].is_null() && result["applies"].get<bool>()) {
    text += fmt::format("The efforts may be {:.4g} times these.\n",
                        result["effort_factor"].get<double>());
  }
  return text + describe_linear_range(model, result) + describe_nominal_values(model);
}

void run(const Options& options, int& exit_code) {
  check_outputs(options.common,
                {{"the model", options.common.model}, {"the profile", options.profile}});
  const EnvironmentProfile profile = load_environment_profile(options.profile);
  const Model model = load_model(options.common.model);
  std::optional<double> coupling;
  if (!options.coupling.empty()) {
    coupling =
        parse_option("--coupling-damping", options.coupling, units_of(model.device.motion).damping);
    if (!(*coupling > 0)) {
      throw Error(ErrorCode::bad_input, "--coupling-damping",
                  fmt::format("{:g}: must be above 0; leave it out for an environment without a "
                              "virtual coupling",
                              *coupling));
    }
  }
  const nlohmann::json result = make_environment_result(profile, options.profile, model, coupling);
  if (!options.common.csv.empty()) {
    std::vector<double> slope;
    for (std::size_t i = 0; i < profile.position.size(); ++i) {
      const std::size_t from = std::min(i, profile.position.size() - 2);
      slope.push_back((profile.effort[from + 1] - profile.effort[from]) /
                      (profile.position[from + 1] - profile.position[from]));
    }
    write_csv(options.common.csv, {"position", "effort", "slope"},
              {profile.position, profile.effort, slope});
  }
  exit_code = result["verdict"] == "passive" ? 0 : 1;
  deliver(options.common, result, describe(model, result));
}

}  // namespace

void add_environment_command(CLI::App& app, int& exit_code) {
  auto options = std::make_shared<Options>();
  CLI::App* command = app.add_subcommand(
      "environment", "Is a nonlinear effort profile passive, sampled and held, on this device?");
  command
      ->add_option("PROFILE", options->profile,
                   "CSV with the columns position and effort (opposing; SI units), straight "
                   "between the rows")
      ->required()
      ->check(not_empty());
  command->add_option("--model", options->common.model, "Model file of the device")
      ->required()
      ->type_name("MODEL")
      ->check(not_empty());
  command
      ->add_option("--coupling-damping", options->coupling,
                   "Damping of a virtual coupling between device and environment")
      ->type_name("B")
      ->check(not_empty());
  add_output_options(*command, options->common, "Write the profile and its slopes as columns",
                     "gyrator environment examples/environments/click.csv --model "
                     "examples/p3_plant.json\n\nExit code 0: passive. 1: not shown to be passive.");
  command->callback([options, &exit_code] { run(*options, exit_code); });
}

}  // namespace gyrator::app
