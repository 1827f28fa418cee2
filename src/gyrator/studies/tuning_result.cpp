#include "gyrator/studies/tuning_result.hpp"

#include "gyrator/plots/html.hpp"
#include "gyrator/plots/plot_page.hpp"
#include "gyrator/plots/pretty_text.hpp"
#include "gyrator/studies/motion_terms.hpp"
#include "gyrator/studies/result_fields.hpp"
#include "gyrator/studies/result_parts.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <fmt/core.h>

namespace gyrator {

using nlohmann::json;

namespace {

json describe_settings(const std::vector<Setting>& settings) {
  json described = json::object();
  for (const Setting& setting : settings) described[setting.name] = setting.value;
  return described;
}

json describe_step(const TuningStep& step) {
  return {{"time_s", step.time},
          {"settings", describe_settings(step.settings)},
          {"winding_resistance", step.winding_resistance},
          {"remaining_resistance",
           step.remaining_resistance > 0 ? json(step.remaining_resistance) : json(nullptr)},
          {"measured_damping", step.measured_damping},
          {"modelled_damping", step.modelled_damping},
          {"frequency_hz", step.frequency_hz},
          {"decay_per_s", step.decay},
          {"stable", step.stable},
          {"remark", step.remark}};
}

void describe_points(json& result, const std::vector<MeasuredPoint>& points) {
  const auto add = [&](const char* key, const auto& value_of) {
    json values = json::array();
    for (const MeasuredPoint& point : points) values.push_back(finite_or_null(value_of(point)));
    result[key] = std::move(values);
  };
  using P = MeasuredPoint;
  add("frequency_hz", [](const P& p) { return p.frequency_hz; });
  add("impedance_real", [](const P& p) { return p.impedance.real(); });
  add("impedance_imag", [](const P& p) { return p.impedance.imag(); });
  add("damping_low", [](const P& p) { return p.damping_low; });
  add("damping_high", [](const P& p) { return p.damping_high; });
  add("actuation_real", [](const P& p) { return p.actuation.real(); });
  add("actuation_imag", [](const P& p) { return p.actuation.imag(); });
  add("modelled_impedance_real", [](const P& p) { return p.modelled_impedance.real(); });
  add("modelled_impedance_imag", [](const P& p) { return p.modelled_impedance.imag(); });
  add("modelled_actuation_real", [](const P& p) { return p.modelled_actuation.real(); });
  add("modelled_actuation_imag", [](const P& p) { return p.modelled_actuation.imag(); });
  add("winding_resistance", [](const P& p) { return p.winding_resistance; });
}

json start_tuning_result(const Model& identified, const TuningOptions& options,
                         const TuningChoice& choice) {
  json result = start_result("tune", identified);
  const auto wall = find_wall_values(identified.controller);
  result["circuit"] = name_of(options.target.circuit);
  result["stiffness"] = wall ? json(wall->stiffness) : json(nullptr);
  result["virtual_damping"] = wall ? json(wall->damping) : json(nullptr);
  result["margin"] = options.target.margin;
  result["wanted_cancellation"] =
      options.target.cancellation ? json(*options.target.cancellation) : json(nullptr);
  result["settings"] = describe_settings(choice.settings);
  result["modelled_max_stiffness"] = finite_or_null(choice.max_stiffness);
  result["reaches_wall"] = choice.reaches_wall;
  if (choice.device.drive.motor) {
    const bool by_current = mode_of(choice.circuit) == DriveMode::current;
    result["command_per_effort"] = find_amplifier_gain(choice.device);
    result["units"]["command_per_effort"] =
        fmt::format("{}/{}", by_current ? "A" : "V",
                    identified.device.motion == Motion::rotary ? "(N.m)" : "N");
  }
  return result;
}

}  // namespace

json make_tuned_model(const Model& identified, const TuningChoice& choice) {
  json model = identified.source;
  const json bandwidth =
      model.contains("amplifier") ? model["amplifier"].value("bandwidth", json()) : json();
  const bool by_current = mode_of(choice.circuit) == DriveMode::current;
  model["amplifier"] = {{"kind", by_current ? "current" : "voltage"}};
  if (!bandwidth.is_null()) model["amplifier"]["bandwidth"] = bandwidth;
  model["damping"] = json::array();
  if (choice.circuit == TuningCircuit::rc) {
    model["damping"].push_back({{"kind", "rc"},
                                {"resistance", value_of(choice.settings, "damping_resistance")},
                                {"capacitance", value_of(choice.settings, "damping_capacitance")}});
  } else if (const double cancelled = value_of(choice.settings, "cancellation_resistance");
             cancelled > 0) {
    model["damping"].push_back({{"kind", "resistance_cancellation"}, {"resistance", cancelled}});
  }
  // As warm as it was measured: what the amplifier's gain was set by.
  model["motor"]["resistance"] = choice.device.drive.motor->warm_resistance();
  model["motor"].erase("temperature_rise");
  return model;
}

json make_tuning_plan_result(const Model& identified, const TuningOptions& options,
                             const TuningChoice& choice) {
  json result = start_tuning_result(identified, options, choice);
  result["outcome"] = "planned";
  result["explanation"] = "nothing was measured or set: --apply does it";
  result["verdict"] = nullptr;
  return result;
}

json make_tuning_result(const Model& identified, const TuningOptions& options,
                        const TuningRun& run) {
  json result = start_tuning_result(identified, options, run.choice);
  result["outcome"] = name_of(run.outcome);
  result["explanation"] = run.explanation;
  result["steps"] = json::array();
  for (const TuningStep& step : run.steps) result["steps"].push_back(describe_step(step));
  result["verdict"] = nullptr;
  if (run.verdict) {
    const MeasuredVerdict& verdict = *run.verdict;
    result["verdict"] = verdict.passive ? "passive" : "not_passive";
    result["measured_margin"] = finite_or_null(verdict.margin);
    result["measured_margin_low"] = finite_or_null(verdict.margin_low);
    result["worst_frequency_hz"] = verdict.worst_frequency_hz;
    result["measured_max_stiffness"] = finite_or_null(verdict.max_stiffness);
    result["measured_max_stiffness_low"] = finite_or_null(verdict.max_stiffness_low);
    result["modelled_max_stiffness"] = finite_or_null(verdict.modelled_max_stiffness);
    describe_points(result, verdict.points);
  }
  if (!run.ring_down.velocity.empty()) {
    json ring = {{"period_s", run.ring_down.period}, {"velocity", run.ring_down.velocity}};
    if (!run.ring_down.current.empty()) ring["current"] = run.ring_down.current;
    result["ring_down"] = std::move(ring);
  }
  if (run.model.device.drive.motor) {
    const Motor& motor = *run.model.device.drive.motor;
    result["winding"] = {{"resistance", motor.warm_resistance()},
                         {"temperature_rise", motor.temperature_rise}};
    if (!run.choice.settings.empty())
      result["tuned_model"] = make_tuned_model(identified, run.choice);
  }
  return result;
}

// ---- Figure
// --------------------------------------------------------------------------------------

namespace {

constexpr const char* place = "tune result";

Panel frequency_panel(const json& result, const std::string& title, const std::string& label,
                      const std::string& unit) {
  Panel panel{title, {"frequency", "Hz", true}, {label, unit}};
  const auto f = required_numbers(result, "frequency_hz", place);
  if (!f.empty()) {
    panel.x_axis.min = f.front() / 1.2;
    panel.x_axis.max = f.back() * 1.2;
  }
  return panel;
}

Panel damping_panel(const json& result) {
  Panel panel = frequency_panel(result, "Damping at the shaft", "Re Z", unit_of(result, "damping"));
  const auto f = required_numbers(result, "frequency_hz", place);
  panel.curves = {{"99 % of measured", f, required_numbers(result, "damping_high", place),
                   CurveStyle::band, Colour::sky, required_numbers(result, "damping_low", place)},
                  {"measured", f, required_numbers(result, "impedance_real", place),
                   CurveStyle::points, Colour::blue},
                  {"model", f, required_numbers(result, "modelled_impedance_real", place),
                   CurveStyle::dashed, Colour::black}};
  panel.lines = {{0, false}};
  return panel;
}

Panel actuation_panel(const json& result) {
  Panel panel =
      frequency_panel(result, "Phase of the command on its way to the shaft", "phase of A", "deg");
  const auto f = required_numbers(result, "frequency_hz", place);
  const auto phase = [&](const char* real, const char* imag) {
    const auto re = required_numbers(result, real, place);
    const auto im = required_numbers(result, imag, place);
    std::vector<double> degrees;
    for (std::size_t i = 0; i < re.size() && i < im.size(); ++i)
      degrees.push_back(std::atan2(im[i], re[i]) * 180 / std::numbers::pi);
    return degrees;
  };
  panel.curves = {
      {"measured", f, phase("actuation_real", "actuation_imag"), CurveStyle::points, Colour::blue},
      {"model", f, phase("modelled_actuation_real", "modelled_actuation_imag"), CurveStyle::dashed,
       Colour::black}};
  panel.lines = {{0, false}};
  return panel;
}

Panel steps_panel(const json& result) {
  Panel panel{
      "Damping step by step", {"step"}, {"Re Z of the circuit", unit_of(result, "damping")}};
  std::vector<double> number, measured, modelled;
  for (const json& step : result["steps"]) {
    number.push_back(static_cast<double>(number.size() + 1));
    measured.push_back(optional_number(step, "measured_damping"));
    modelled.push_back(optional_number(step, "modelled_damping"));
  }
  panel.x_axis.min = 0.5;
  panel.x_axis.max = static_cast<double>(number.size()) + 0.5;
  panel.curves = {{"measured", number, measured, CurveStyle::points, Colour::blue},
                  {"model", number, modelled, CurveStyle::dashed, Colour::black}};
  panel.lines = {{0, false}};
  return panel;
}

Panel ring_down_panel(const json& result) {
  const json& ring = result["ring_down"];
  const auto velocity = required_numbers(ring, "velocity", place);
  const double period = required_number(ring, "period_s", place);
  std::vector<double> time;
  for (std::size_t k = 0; k < velocity.size(); ++k) time.push_back(static_cast<double>(k) * period);
  Panel panel{"After the command's end, with the last settings",
              {"time", "s"},
              {"velocity", unit_of(result, "velocity")}};
  panel.curves = {{"", time, velocity}};
  panel.lines = {{0, false}};
  return panel;
}

}  // namespace

Figure tuning_figure(const json& result) {
  Figure figure{figure_title(result, "Tuning of the amplifier"), {}};
  if (has(result, "frequency_hz")) {
    figure.panels.push_back(damping_panel(result));
    figure.panels.push_back(actuation_panel(result));
  }
  if (has(result, "steps")) figure.panels.push_back(steps_panel(result));
  if (has(result, "ring_down")) figure.panels.push_back(ring_down_panel(result));
  if (figure.panels.empty())
    throw Error(ErrorCode::bad_input, place, "nothing was measured that could be drawn");
  figure.columns = figure.panels.size() > 1 ? 2 : 1;
  return figure;
}

// ---- Report
// --------------------------------------------------------------------------------------

namespace {

std::string stiffness_in_words(const json& result, const char* key) {
  return pretty_quantity(optional_number(result, key), unit_of(result, "stiffness"), 3);
}

std::string describe_settings_in_words(const json& settings) {
  if (!settings.is_object())
    throw Error(ErrorCode::bad_input, std::string(place) + ": /settings", "an object is expected");
  std::string text;
  for (const auto& item : settings.items()) {
    const std::string& name = item.key();
    const std::string unit = name == "damping_capacitance" ? "F" : "ohm";
    text += fmt::format("{}{} {}", text.empty() ? "" : ", ", name,
                        pretty_quantity(required_number(settings, name, place), unit, 4));
  }
  return text;
}

}  // namespace

ReportSection tuning_section(const json& result) {
  std::vector<std::vector<HtmlCell>> rows;
  const std::string damping = unit_of(result, "damping");
  if (has(result, "steps")) {
    for (const json& step : result["steps"]) {
      const bool stable = optional_flag(step, "stable", true);
      rows.push_back(
          {{pretty_quantity(optional_number(step, "time_s"), "s", 3), "number"},
           {describe_settings_in_words(required(step, "settings", place))},
           {pretty_quantity(optional_number(step, "winding_resistance"), "ohm"), "number"},
           {pretty_quantity(optional_number(step, "measured_damping"), damping), "number"},
           {pretty_quantity(optional_number(step, "modelled_damping"), damping), "number"},
           {stable ? "yes" : optional_text(step, "remark"), stable ? "yes" : "no"}});
    }
  }
  std::string html = html_paragraph(tuning_sentence(result));
  if (has(result, "settings"))
    html += html_paragraph("Settings: " + describe_settings_in_words(result["settings"]) + ".");
  if (!rows.empty())
    html += html_table(
        {"Time", "Settings", "Winding", "Damping measured", "by the model", "Stable"}, rows);
  if (has(result, "plan")) {
    std::vector<std::vector<HtmlCell>> registers;
    for (const json& row : result["plan"]) {
      const auto cell = [&](const char* key) {
        const json& value = row.value(key, json());
        return value.is_number()   ? pretty_number(value.get<double>(), 6)
               : value.is_string() ? value.get<std::string>()
                                   : std::string("–");
      };
      registers.push_back({{cell("register")},
                           {cell("address")},
                           {cell("old"), "number"},
                           {cell("new"), "number"},
                           {cell("unit")}});
    }
    html += html_table({"Register", "Address", "Before", "After", "Unit"}, registers);
  }
  return {"Tuning of the amplifier", html,
          "Measured by sines with the shaft free, against the identified model with the same "
          "settings. The band is the 99 % interval of the measured damping."};
}

std::string tuning_sentence(const json& result) {
  const std::string outcome = optional_text(result, "outcome");
  std::string text;
  if (outcome == "reached") {
    text = "The amplifier is set";
    if (optional_text(result, "verdict") == "not_passive") {
      text += fmt::format(
          ": but by its measured response the wall of {} is NOT PASSIVE, the "
          "stiffest that would be is {}",
          stiffness_in_words(result, "stiffness"),
          stiffness_in_words(result, "measured_max_stiffness"));
    } else if (optional_text(result, "verdict") == "passive")
      text += fmt::format(
          ": by its measured response the wall of {} is passive, the stiffest that "
          "would be is {} (at least {} with 99 % confidence)",
          stiffness_in_words(result, "stiffness"),
          stiffness_in_words(result, "measured_max_stiffness"),
          stiffness_in_words(result, "measured_max_stiffness_low"));
    return text + ".";
  }
  if (outcome == "planned") return "Nothing was set: a plan.";
  const bool is_back = optional_text(result, "state") != "unknown";
  return fmt::format("Not reached: {}.{}", optional_text(result, "explanation"),
                     is_back ? " The settings are as they were." : "");
}

}  // namespace gyrator
