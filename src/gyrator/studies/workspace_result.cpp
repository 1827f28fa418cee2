#include "gyrator/studies/workspace_result.hpp"

#include "gyrator/passivity/joint_dissipation.hpp"
#include "gyrator/plots/html.hpp"
#include "gyrator/plots/plot_page.hpp"
#include "gyrator/plots/pretty_text.hpp"
#include "gyrator/studies/result_fields.hpp"
#include "gyrator/studies/result_parts.hpp"
#include "gyrator/version.hpp"

#include <algorithm>
#include <limits>

#include <fmt/core.h>

namespace gyrator {

using nlohmann::json;

json make_workspace_result(const Workspace& workspace) {
  constexpr double rounding = 1e-12;  // a factor of exactly one is enough
  json poses = json::array();
  double worst_isotropic = std::numeric_limits<double>::infinity();
  double worst_factor = worst_isotropic;
  std::size_t isotropic_at = 0;
  std::size_t factor_at = 0;
  for (std::size_t i = 0; i < workspace.poses.size(); ++i) {
    const PoseDissipation pose = compute_pose_dissipation(
        workspace.joint_damping, workspace.poses[i].jacobian, workspace.task_damping);
    const auto& weakest = pose.weakest_direction;
    const bool moves = std::isfinite(pose.largest_isotropic);
    poses.push_back(
        {{"name", workspace.poses[i].name},
         {"largest_isotropic", finite_or_null(pose.largest_isotropic)},
         {"weakest_direction",
          moves ? json(std::vector<double>(weakest.data(), weakest.data() + weakest.size()))
                : json(nullptr)}});
    if (pose.largest_isotropic < worst_isotropic) {
      worst_isotropic = pose.largest_isotropic;
      isotropic_at = i;
    }
    if (!pose.allowed_factor) continue;
    poses.back()["least_eigenvalue"] = *pose.least_eigenvalue;
    poses.back()["allowed_factor"] = finite_or_null(*pose.allowed_factor);
    poses.back()["holds"] = *pose.allowed_factor >= 1 - rounding;
    if (*pose.allowed_factor < worst_factor) {
      worst_factor = *pose.allowed_factor;
      factor_at = i;
    }
  }
  json result = {{"schema", "gyrator/result/1"},
                 {"command", "workspace"},
                 {"program", fmt::format("gyrator {}", version)},
                 {"model_name", workspace.name},
                 {"model", workspace.source},
                 {"units", json::object()},
                 {"poses", std::move(poses)},
                 {"largest_isotropic", finite_or_null(worst_isotropic)},
                 {"largest_isotropic_at", workspace.poses[isotropic_at].name},
                 {"verdict", nullptr}};
  if (workspace.task_damping) {
    result["verdict"] = worst_factor >= 1 - rounding ? "enough" : "not_enough";
    result["allowed_factor"] = finite_or_null(worst_factor);
    result["worst_pose"] = workspace.poses[factor_at].name;
  }
  return result;
}

namespace {

// Side by side; many poses are numbers.
bool fit_below(const std::vector<std::string>& names) {
  constexpr double width = 600;  // pixels
  double widest = 0;
  for (const auto& name : names) widest = std::max(widest, text_width(name) + 12);
  return widest * static_cast<double>(names.size()) < width;
}

}  // namespace

Figure workspace_figure(const json& result) {
  const std::string place = "workspace result: /poses";
  const json& poses = required_array(result, "poses", "workspace result");
  std::vector<double> number;
  std::vector<std::string> names;
  std::vector<double> isotropic;
  std::vector<double> factor;
  for (const auto& pose : poses) {
    number.push_back(static_cast<double>(number.size() + 1));
    names.push_back(optional_text(pose, "name"));
    isotropic.push_back(optional_number(pose, "largest_isotropic"));
    factor.push_back(optional_number(pose, "allowed_factor"));
  }
  const auto make_panel = [&](const std::string& title, const std::string& label,
                              const std::vector<double>& values) {
    Panel panel{title, {"pose", "", false, 0.5, static_cast<double>(number.size()) + 0.5}, {label}};
    panel.y_axis.logarithmic = true;
    panel.curves = {{"", number, values, CurveStyle::points, Colour::blue}};
    if (fit_below(names)) panel.x_axis.names = names;
    return panel;
  };
  Figure figure{figure_title(result, "Joint damping at the hand"),
                {make_panel("Largest equal damping in every direction that the joints give",
                            "damping (SI)", isotropic)}};
  if (has(result, "verdict")) {
    figure.panels.push_back(
        make_panel("How many times the wanted damping they give: 1 is enough", "factor", factor));
    figure.panels.back().lines = {{1, false}};
  }
  figure.panel_width = 760;
  figure.panel_height = 320;
  return figure;
}

ReportSection workspace_section(const json& result) {
  std::vector<std::vector<HtmlCell>> rows;
  const bool judged = has(result, "verdict");
  for (const auto& pose : required_array(result, "poses", "workspace result")) {
    rows.push_back({{optional_text(pose, "name")},
                    {pretty_number(optional_number(pose, "largest_isotropic")), "number"}});
    if (!judged) continue;
    rows.back().push_back({pretty_number(optional_number(pose, "least_eigenvalue")), "number"});
    rows.back().push_back({pretty_number(optional_number(pose, "allowed_factor")), "number"});
    const bool holds = optional_flag(pose, "holds", false);
    rows.back().push_back({holds ? "yes" : "no", holds ? "yes" : "no"});
  }
  std::vector<std::string> headings{"Pose", "Largest isotropic damping (SI)"};
  if (judged) {
    headings.insert(headings.end(), {"Least eigenvalue (SI)", "Factor of the wanted", "Enough"});
  }
  return {"Joint damping at the hand", html_table(headings, rows),
          "What the dampers of the joints are worth at the hand, pose by pose."};
}

std::string workspace_sentence(const json& result) {
  if (!has(result, "verdict")) return {};
  const std::string factor = pretty_number(optional_number(result, "allowed_factor"), 3);
  return optional_text(result, "verdict") == "enough"
             ? "The joints' damping is enough for the wanted one at every pose."
             : "Not enough: at the pose " + optional_text(result, "worst_pose") +
                   " the joints' damping is worth " + factor + " of the wanted one.";
}

}  // namespace gyrator
