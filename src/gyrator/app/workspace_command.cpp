#include "gyrator/documents/csv.hpp"
#include "gyrator/studies/workspace_result.hpp"

#include <algorithm>
#include <cmath>
#include <memory>

#include <fmt/core.h>

#include "commands.hpp"
#include "common_options.hpp"
#include "usage_errors.hpp"

namespace gyrator::app {
namespace {

std::string describe_number(const nlohmann::json& value) {
  return value.is_null() ? "any" : fmt::format("{:.6g}", value.get<double>());
}

std::string describe(const nlohmann::json& result) {
  const bool judged = !result["verdict"].is_null();
  std::string text = result["model_name"].get<std::string>();
  if (judged) text += result["verdict"] == "enough" ? ": ENOUGH DAMPING" : ": NOT ENOUGH DAMPING";
  std::size_t width = 4;
  for (const auto& pose : result["poses"])
    width = std::max(width, pose["name"].get<std::string>().size());
  text += fmt::format("\n\n{:<{}}  {:>22}", "pose", width, "largest isotropic [SI]");
  if (judged)
    text +=
        fmt::format("  {:>21}  {:>16}  {}", "least eigenvalue [SI]", "times the wanted", "enough");
  for (const auto& pose : result["poses"]) {
    text += fmt::format("\n{:<{}}  {:>22}", pose["name"].get<std::string>(), width,
                        describe_number(pose["largest_isotropic"]));
    if (!judged) continue;
    text += fmt::format("  {:>21.6g}  {:>16}  {}", pose["least_eigenvalue"].get<double>(),
                        describe_number(pose["allowed_factor"]),
                        pose["holds"].get<bool>() ? "yes" : "no");
  }
  text += fmt::format(
      "\n\nIn every direction and at every pose the joints give a damping of {} N.s/m (about an "
      "axis: "
      "N.m.s/rad); least at the pose {}.\n",
      describe_number(result["largest_isotropic"]),
      result["largest_isotropic_at"].get<std::string>());
  if (judged) {
    text += fmt::format("Of the wanted task damping they give {} times; least at the pose {}.\n",
                        describe_number(result["allowed_factor"]),
                        result["worst_pose"].get<std::string>());
  }
  return text;
}

void run(const CommonOptions& options, int& exit_code) {
  check_outputs(options, {{"the workspace", options.model}});
  const nlohmann::json result = make_workspace_result(load_workspace(options.model));
  if (!options.csv.empty()) {
    std::vector<std::string> names{"pose", "largest_isotropic"};
    if (!result["verdict"].is_null())
      names.insert(names.end(), {"least_eigenvalue", "allowed_factor"});
    std::vector<std::vector<double>> columns(names.size());
    for (const auto& pose : result["poses"]) {
      columns[0].push_back(static_cast<double>(columns[0].size() + 1));
      for (std::size_t i = 1; i < names.size(); ++i)
        columns[i].push_back(pose[names[i]].is_null() ? INFINITY : pose[names[i]].get<double>());
    }
    write_csv(options.csv, names, columns);
  }
  exit_code = result["verdict"] == "not_enough" ? 1 : 0;
  deliver(options, result, describe(result));
}

}  // namespace

void add_workspace_command(CLI::App& app, int& exit_code) {
  auto options = std::make_shared<CommonOptions>();
  CLI::App* command = app.add_subcommand(
      "workspace", "What the damping of a mechanism's joints is worth at the hand, pose by pose");
  command
      ->add_option("FILE", options->model,
                   "JSON with joint_damping, poses and, if it is to be judged, task_damping")
      ->required()
      ->check(not_empty());
  add_output_options(*command, *options, "Write the poses (by number) and what they give",
                     "gyrator workspace examples/environments/two_link_arm.json\n\nExit code 0: "
                     "enough at every pose, or nothing was asked for. 1: not enough.");
  command->callback([options, &exit_code] { run(*options, exit_code); });
}

}  // namespace gyrator::app
