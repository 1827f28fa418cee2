#include "gyrator/studies/environment_result.hpp"

#include "gyrator/core/error.hpp"
#include "gyrator/documents/csv.hpp"
#include "gyrator/mechanics/stability.hpp"
#include "gyrator/plots/html.hpp"
#include "gyrator/plots/pretty_text.hpp"
#include "gyrator/studies/operating_point_fields.hpp"
#include "gyrator/studies/result_fields.hpp"
#include "gyrator/studies/result_parts.hpp"

#include <fmt/core.h>
#include <fmt/ranges.h>

namespace gyrator {

using nlohmann::json;

EnvironmentProfile load_environment_profile(const std::string& path) {
  const CsvColumns read = read_csv(path, {"position", "effort"});
  EnvironmentProfile profile{read.columns[0], read.columns[1]};
  if (profile.position.size() < 2) {
    throw Error(ErrorCode::bad_input, fmt::format("{}:{}", path, read.lines.front()),
                "one row: a profile needs at least two");
  }
  for (std::size_t i = 1; i < profile.position.size(); ++i) {
    if (profile.position[i] > profile.position[i - 1]) continue;
    throw Error(ErrorCode::bad_input,
                fmt::format("{}:{}: column \"position\"", path, read.lines[i]),
                fmt::format("{:g} after {:g}: positions must increase from row to row; an effort "
                            "that depends on the direction of motion is no profile",
                            profile.position[i], profile.position[i - 1]));
  }
  return profile;
}

namespace {

json slope_json(const ProfileSlope& slope) {
  if (slope.slope == 0) return nullptr;
  return {{"slope", slope.slope}, {"from", slope.from}, {"to", slope.to}};
}

}  // namespace

json make_environment_result(const EnvironmentProfile& profile, const std::string& path,
                             const Model& model, std::optional<double> coupling_damping) {
  naming_file(model, [&] { require_stable_device(model.device); });
  const EnvironmentVerdict v =
      judge_environment(profile, model.device, model.sampling, coupling_damping);
  json result = start_result("environment", model);
  result["verdict"] = v.holds() ? "passive" : "not_passive";
  result["inequality_holds"] = v.inequality;
  result["applies"] = v.applies();
  result["reasons"] = v.reasons;
  result["alpha"] = v.activity.alpha;
  result["delta"] = v.dissipation;
  result["delta_frequency_hz"] = v.dissipation_frequency_hz;
  result["coupling_damping"] = v.coupling ? json(*v.coupling) : json(nullptr);
  result["allowed_alpha"] = v.allowed;
  // alpha grows as the profile does: this many times the efforts would still be passive.
  result["effort_factor"] =
      v.activity.alpha > 0 ? json(std::max(0.0, v.allowed) / v.activity.alpha) : json(nullptr);
  result["steepest_rise"] = slope_json(v.activity.rising);
  result["steepest_fall"] = slope_json(v.activity.falling);
  result["profile"] = {{"file", path}, {"position", profile.position}, {"effort", profile.effort}};
  result["operating_point"] = make_operating_point_fields(model);
  return result;
}

Figure environment_figure(const json& result) {
  const std::string place = "environment result";
  const json& profile = required(result, "profile", place);
  const auto position = required_numbers(profile, "position", place);
  const auto effort = required_numbers(profile, "effort", place);
  Panel panel{"The environment's effort over position",
              {"position", unit_of(result, "position")},
              {"opposing effort", unit_of(result, "effort")}};
  panel.curves = {{"profile", position, effort, CurveStyle::line, Colour::blue}};
  const auto mark = [&](const char* key, const std::string& title, Colour colour) {
    if (!has(result, key)) return;
    const double from = required_number(result[key], "from", place);
    const double to = required_number(result[key], "to", place);
    Curve steep{title + ", " +
                    pretty_quantity(required_number(result[key], "slope", place),
                                    unit_of(result, "stiffness"), 3),
                {},
                {},
                CurveStyle::line,
                colour};
    for (std::size_t i = 0; i < std::min(position.size(), effort.size()); ++i) {
      if (position[i] < from || position[i] > to) continue;
      steep.x.push_back(position[i]);
      steep.y.push_back(effort[i]);
    }
    panel.curves.push_back(steep);
  };
  mark("steepest_rise", "steepest rise", Colour::vermillion);
  mark("steepest_fall", "steepest fall", Colour::orange);
  panel.lines = {{0, false}};
  Figure figure{figure_title(result, "Nonlinear environment"), {panel}};
  figure.panel_width = 760;
  figure.panel_height = 400;
  return figure;
}

ReportSection environment_section(const json& result) {
  const std::string place = "environment result";
  const std::string unit = unit_of(result, "damping");
  std::vector<std::vector<HtmlCell>> rows;
  const auto add = [&](const std::string& name, const char* key) {
    rows.push_back({{name}, {pretty_quantity(optional_number(result, key), unit), "number"}});
  };
  add("α, damping that the sampled environment can use up", "alpha");
  add("δ, damping of the device", "delta");
  if (has(result, "coupling_damping"))
    add("γ, damping of the virtual coupling", "coupling_damping");
  add("α must stay below", "allowed_alpha");
  std::string html = html_table({"", "Damping"}, rows);
  for (const auto& reason : required_array(result, "reasons", place))
    html += html_paragraph("The condition says nothing here: " + reason.get<std::string>() + ".");
  return {"Nonlinear environment", html,
          "The effort with which the environment opposes, and where it rises and falls most "
          "steeply: held from sample to sample, it gives out energy there."};
}

std::string environment_sentence(const json& result) {
  if (optional_text(result, "verdict") == "passive")
    return "Passive: the environment's profile, sampled and held, never gives out more energy than "
           "the device dissipates.";
  return optional_flag(result, "applies", true) ? "Not passive: the environment's profile can give "
                                                  "out more than the device dissipates."
                                                : "Not shown to be passive: the condition for "
                                                  "nonlinear environments does not apply to "
                                                  "this device.";
}

}  // namespace gyrator
