#include "gyrator/studies/result_figures.hpp"

#include "gyrator/core/error.hpp"
#include "gyrator/studies/design_section.hpp"
#include "gyrator/studies/envelope_result.hpp"
#include "gyrator/studies/environment_result.hpp"
#include "gyrator/studies/identification_result.hpp"
#include "gyrator/studies/result_fields.hpp"
#include "gyrator/studies/tuning_result.hpp"
#include "gyrator/studies/workspace_result.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <string_view>
#include <utility>

#include <fmt/format.h>

namespace gyrator {
namespace {

using nlohmann::json;
using Numbers = std::vector<double>;

// ---- Impedance --------------------------------------------------------------------------------

Panel impedance_panel(const json& result, const Numbers& frequency) {
  const std::string place = "impedance result";
  const auto real = required_numbers(result, "impedance_real", place);
  const auto imag = required_numbers(result, "impedance_imag", place);
  Numbers magnitude;
  Numbers positive;
  Numbers negative;  // as magnitude: a logarithmic axis has no room for signs
  for (std::size_t i = 0; i < std::min(real.size(), imag.size()); ++i) {
    magnitude.push_back(std::hypot(real[i], imag[i]));
    positive.push_back(real[i] > 0 ? real[i] : NAN);
    negative.push_back(real[i] < 0 ? -real[i] : NAN);
  }
  Panel panel{"Impedance at the operator's port",
              {"frequency", "Hz", true},
              {"impedance", unit_of(result, "damping"), true}};
  panel.curves = {
      {"|Z|", frequency, magnitude, CurveStyle::line, Colour::blue},
      {"Re Z, effective damping", frequency, positive, CurveStyle::line, Colour::green}};
  if (std::any_of(negative.begin(), negative.end(), [](double x) { return x > 0; }))
    panel.curves.push_back({"−Re Z where Re Z < 0 (active)", frequency, negative,
                            CurveStyle::dashed, Colour::vermillion});
  return panel;
}

std::vector<Panel> actuation_panels(const json& result, const Numbers& frequency) {
  const std::string place = "impedance result";
  const auto real = required_numbers(result, "actuation_real", place);
  const auto imag = required_numbers(result, "actuation_imag", place);
  Numbers magnitude;
  Numbers phase_degrees;
  for (std::size_t i = 0; i < std::min(real.size(), imag.size()); ++i) {
    magnitude.push_back(std::hypot(real[i], imag[i]));
    double phase = std::atan2(imag[i], real[i]) * 180 / std::numbers::pi;
    // Unwrapped: the phase goes on through ±180° instead of jumping.
    if (!phase_degrees.empty() && std::isfinite(phase_degrees.back()))
      phase += 360 * std::round((phase_degrees.back() - phase) / 360);
    phase_degrees.push_back(phase);
  }
  Panel gain{"Actuation path: effort at the port per commanded effort",
             {"frequency", "Hz", true},
             {"|A|", "", true}};
  gain.curves = {{"", frequency, magnitude, CurveStyle::line, Colour::blue}};
  Panel phase{"Phase of the actuation path", {"frequency", "Hz", true}, {"phase of A", "degrees"}};
  phase.curves = {{"", frequency, phase_degrees, CurveStyle::line, Colour::blue}};
  return {gain, phase};
}

// ---- Simulation -------------------------------------------------------------------------------

Panel time_panel(const json& result, const std::string& title, const std::string& label,
                 const std::string& quantity) {
  return {title, {"time", "s"}, {label, unit_of(result, quantity)}};
}

Panel energy_panel(const json& result) {
  const std::string place = "simulate result: /energy_trace";
  const auto& trace = result["energy_trace"];
  const auto time = required_numbers(trace, "time_s", place);
  auto panel =
      time_panel(result, "Energy: exchanged since the start, and stored", "energy", "energy");
  const auto add = [&](const std::string& key, const std::string& title, Colour colour) {
    panel.curves.push_back(
        {title, time, required_numbers(trace, key, place), CurveStyle::line, colour});
  };
  add("operator", "from the operator", Colour::blue);
  add("source", "from the amplifier", Colour::orange);
  add("stored", "stored", Colour::green);
  add("dissipated", "turned into heat", Colour::vermillion);
  panel.lines = {{0, false}};
  return panel;
}

}  // namespace

Figure impedance_figure(const json& result) {
  const auto frequency = required_numbers(result, "frequency_hz", "impedance result");
  Figure figure{figure_title(result, "Impedance and actuation path"),
                {impedance_panel(result, frequency)}};
  for (auto& panel : actuation_panels(result, frequency)) figure.panels.push_back(std::move(panel));
  figure.panel_width = 760;
  figure.panel_height = 290;
  return figure;
}

Figure comparison_figure(const json& result) {
  const std::string place = "compare result: /designs";
  Figure figure{"Largest passive stiffness by the exact disk", {}};
  Panel panel{"",
              {"virtual damping B", unit_of(result, "damping"), true},
              {"largest passive stiffness K", unit_of(result, "stiffness"), true}};
  constexpr std::array colours{Colour::grey,   Colour::sky,    Colour::blue,      Colour::green,
                               Colour::orange, Colour::purple, Colour::vermillion};
  std::size_t i = 0;
  for (const auto& design : required(result, "designs", "compare result")) {
    const auto style = i / colours.size() % 2 == 0 ? CurveStyle::line : CurveStyle::dashed;
    auto title = optional_text(design, "name");
    const auto& limits = required_array(design, "max_stiffness", place);
    if (std::all_of(limits.begin(), limits.end(), [](const json& k) { return k.is_null(); }))
      title += ": no limit";
    panel.curves.push_back({title, required_numbers(design, "damping", place),
                            required_numbers(design, "max_stiffness", place), style,
                            colours[i % colours.size()]});
    ++i;
  }
  // Every boundary ends at zero, which a logarithmic axis has no room for: from half of where the
  // lowest one starts.
  double lowest = INFINITY;
  for (const auto& curve : panel.curves) {
    if (!curve.y.empty() && curve.y.front() > 0) lowest = std::min(lowest, curve.y.front());
  }
  if (std::isfinite(lowest)) panel.y_axis.min = lowest / 2;
  figure.panels = {panel};
  figure.panel_width = 860;
  figure.panel_height = 520;
  return figure;
}

Figure simulate_figure(const json& result) {
  const std::string place = "simulate result: /trace";
  const auto& trace = required(result, "trace", "simulate result");
  const auto time = required_numbers(trace, "time_s", place);
  auto position = time_panel(result, "", "position", "position");
  position.curves = {{"", time, required_numbers(trace, "position", place)}};
  auto velocity = time_panel(result, "", "velocity", "velocity");
  velocity.curves = {{"", time, required_numbers(trace, "velocity", place)}};
  auto effort = time_panel(result, "", "effort", "effort");
  effort.curves = {{"effort at the operator's port", time, required_numbers(trace, "effort", place),
                    CurveStyle::line, Colour::grey},
                   {"command", time, required_numbers(trace, "command", place), CurveStyle::steps,
                    Colour::orange}};
  if (has(trace, "external_effort"))
    effort.curves.push_back({"from the hand's gesture", time,
                             required_numbers(trace, "external_effort", place), CurveStyle::steps,
                             Colour::blue});
  Figure figure{figure_title(result, "Simulated run"), {position, velocity, effort}};
  for (auto& panel : figure.panels) panel.lines = {{0, false}};
  // One under the other, the axes of time are the same: only the last is named.
  figure.panels[0].x_axis.label.clear();
  figure.panels[1].x_axis.label.clear();
  if (has(result, "energy_trace")) figure.panels.push_back(energy_panel(result));
  figure.panel_width = 760;
  figure.panel_height = 230;
  return figure;
}

namespace {

/// The one list of commands whose results have a figure.
struct FigureMaker {
  std::string_view command;
  Figure (*make)(const json&);
};
constexpr auto figure_makers = std::to_array<FigureMaker>({{"compare", comparison_figure},
                                                           {"design", design_figure},
                                                           {"environment", environment_figure},
                                                           {"identify", identification_figure},
                                                           {"impedance", impedance_figure},
                                                           {"passivity", passivity_figure},
                                                           {"simulate", simulate_figure},
                                                           {"stability-map", stability_map_figure},
                                                           {"tolerance", tolerance_figure},
                                                           {"tune", tuning_figure},
                                                           {"twoport", two_port_figure},
                                                           {"workspace", workspace_figure},
                                                           {"zwidth", zwidth_figure},
                                                           {"zwidth-envelope", envelope_figure}});

}  // namespace

Figure result_figure(const json& result) {
  const auto command = command_of(result);
  for (const auto& maker : figure_makers)
    if (maker.command == command) return maker.make(result);
  throw Error(ErrorCode::bad_input, "result: /command",
              fmt::format("\"{}\" has no figure; known are {}", command,
                          fmt::join(known_result_commands(), ", ")));
}

std::vector<std::string> known_result_commands() {
  std::vector<std::string> commands;
  commands.reserve(figure_makers.size());
  for (const auto& maker : figure_makers) commands.emplace_back(maker.command);
  return commands;
}

}  // namespace gyrator
