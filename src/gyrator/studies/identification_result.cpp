#include "gyrator/studies/identification_result.hpp"

#include "gyrator/studies/model_file.hpp"
#include "gyrator/studies/motion_terms.hpp"
#include "gyrator/studies/result_fields.hpp"
#include "gyrator/studies/result_parts.hpp"
#include "gyrator/version.hpp"

#include <algorithm>
#include <cmath>

#include <fmt/core.h>

namespace gyrator {

using nlohmann::json;

namespace {

using Complex = std::complex<double>;

// The parameters that are named after the motion.
std::string name_for(const std::string& name, const MotionTerms& terms) {
  if (name == "torque_constant") return terms.motor_constant_name;
  if (name == "inertia") return terms.inertia_name;
  return name;
}

std::string unit_for(const IdentifiedParameter& parameter, const MotionTerms& terms) {
  const auto is = [&](const char* name) { return parameter.name == name; };
  if (is("torque_constant")) return std::string(terms.motor_constant.symbol);
  if (is("inertia")) return std::string(terms.inertia.symbol);
  if (is("damping")) return std::string(terms.damping.symbol);
  if (is("coulomb_friction")) return std::string(terms.effort.symbol);
  return parameter.unit;
}

json number_or_null(const std::optional<double>& value) {
  return value ? finite_or_null(*value) : json(nullptr);
}

json describe_parameter(const IdentifiedParameter& parameter, const MotionTerms& terms) {
  return {{"name", name_for(parameter.name, terms)},
          {"value", number_or_null(parameter.value)},
          {"low", number_or_null(parameter.low)},
          {"high", number_or_null(parameter.high)},
          {"unit", unit_for(parameter, terms)},
          {"identifiable", parameter.identifiable},
          {"note", parameter.note}};
}

json start(const char* outcome, Motion motion, const std::string& name) {
  return {{"schema", "gyrator/result/1"},
          {"command", "identify"},
          {"program", fmt::format("gyrator {}", version)},
          {"model_name", name},
          {"outcome", outcome},
          {"motion", terms_of(motion).name},
          {"units", unit_names(motion)}};
}

// Over frequency: the terminals' impedance and the way from command to current.
json describe_sines(const Identification& found) {
  std::vector<const SineMeasurement*> sines;
  for (const SineMeasurement& sine : found.sines) sines.push_back(&sine);
  std::stable_sort(sines.begin(), sines.end(),
                   [](const auto* a, const auto* b) { return a->frequency_hz < b->frequency_hz; });
  json columns = json::object();
  const auto add = [&](const char* key, double value) {
    columns[key].push_back(finite_or_null(value));
  };
  for (const SineMeasurement* sine : sines) {
    add("frequency_hz", sine->frequency_hz);
    add("amplitude", std::abs(sine->played));
    const Complex none(NAN, NAN);
    const Complex impedance = sine->voltage ? sine->voltage->value / sine->current.value : none;
    const Complex fitted =
        found.winding ? compute_terminal_voltage(*sine, *found.winding, found.winding_options) /
                            sine->current.value
                      : none;
    add("impedance_real", impedance.real());
    add("impedance_imag", impedance.imag());
    add("fitted_impedance_real", fitted.real());
    add("fitted_impedance_imag", fitted.imag());
    const Complex gain = sine->command ? sine->current.value / sine->command->value : none;
    const Complex lag =
        found.amplifier ? found.amplifier->fit.values[0] *
                              compute_held_lag(found.amplifier->lag(found.tick), sine->frequency_hz)
                        : none;
    add("current_real", gain.real());
    add("current_imag", gain.imag());
    add("fitted_current_real", lag.real());
    add("fitted_current_imag", lag.imag());
  }
  return columns;
}

// What slides: the effort against the motion, once inertia and offset are taken off.
json describe_friction(const Identification& found) {
  if (!found.motion || !found.winding) return nullptr;
  const double constant = found.winding->fit.values[2];
  const Eigen::VectorXd& p = found.motion->fit.values;
  json columns = {{"velocity", json::array()}, {"effort", json::array()}};
  for (const MotionWindow& window : found.windows) {
    if (window.direction == 0 || !is_slow(window, found)) continue;
    columns["velocity"].push_back(window.velocity);
    columns["effort"].push_back(
        constant * (find_mean_current(window, found.lag) - p[0] * window.acceleration - p[3]));
  }
  columns["damping"] = constant * p[1];
  columns["coulomb_friction"] = constant * p[2];
  return columns;
}

json describe_experiments(const Identification& found) {
  json experiments = json::array();
  for (const Experiment& experiment : found.experiments)
    experiments.push_back({{"purpose", experiment.purpose},
                           {"excitation", describe(experiment.excitation)},
                           {"amplitude", experiment.excitation.amplitude},
                           {"frequency_hz", experiment.excitation.frequency_hz},
                           {"duration_s", experiment.excitation.duration},
                           {"samples", experiment.capture.samples}});
  return experiments;
}

}  // namespace

json make_identification_result(const Identification& found, Motion motion,
                                const std::string& name) {
  json result = start("identified", motion, name);
  result["parameters"] = json::array();
  for (const IdentifiedParameter& parameter : found.parameters)
    result["parameters"].push_back(describe_parameter(parameter, terms_of(motion)));
  result["winding_temperature"] =
      found.temperature_known ? json(found.winding_temperature) : json(nullptr);
  result["duration_s"] = found.duration;
  result["experiments"] = describe_experiments(found);
  result["sines"] = describe_sines(found);
  result["friction"] = describe_friction(found);
  return result;
}

json make_identification_plan_result(const std::vector<PlannedStep>& plan, Motion motion,
                                     const std::string& name) {
  json result = start("planned", motion, name);
  result["parameters"] = json::array();
  result["experiments"] = json::array();
  for (const PlannedStep& step : plan)
    result["experiments"].push_back({{"purpose", step.purpose},
                                     {"mode", name_of(step.mode)},
                                     {"lowest_frequency_hz", step.lowest_hz},
                                     {"highest_frequency_hz", step.highest_hz},
                                     {"largest_amplitude", step.largest},
                                     {"runs", step.runs},
                                     {"duration_s", step.duration}});
  return result;
}

std::string describe_parameters(const json& result) {
  std::string text = fmt::format("{:<22}  {:>12}  {:>27}  {:<12}  {}\n", "parameter", "value",
                                 "99 % interval", "unit", "identifiable");
  for (const json& p : result.at("parameters")) {
    const auto number = [&](const char* key) {
      return p[key].is_null() ? std::string("-") : fmt::format("{:.5g}", p[key].get<double>());
    };
    const auto note = p["note"].get<std::string>();
    text +=
        fmt::format("{:<22}  {:>12}  {:>12} … {:>12}  {:<12}  {}{}\n", p["name"].get<std::string>(),
                    number("value"), number("low"), number("high"), p["unit"].get<std::string>(),
                    p["identifiable"].get<bool>() ? "yes" : "NO", note.empty() ? "" : ": " + note);
  }
  return text;
}

std::string describe_plan(const std::vector<PlannedStep>& plan) {
  std::string text = fmt::format("{:<22}  {:<22}  {:<26}  {:>8}  {:>10}\n", "sines for",
                                 "frequency", "amplitude", "runs", "together");
  double total = 0;
  for (const PlannedStep& step : plan) {
    const char* unit = step.mode == DriveMode::current ? "A" : "V";
    const std::string frequency =
        step.lowest_hz == step.highest_hz
            ? fmt::format("{:.4g} Hz", step.lowest_hz)
            : fmt::format("{:.4g} to {:.4g} Hz", step.lowest_hz, step.highest_hz);
    text += fmt::format("{:<22}  {:<22}  {:<26}  {:>8}  {:>8.1f} s\n", step.purpose, frequency,
                        fmt::format("grows to at most {:.4g} {}", step.largest, unit), step.runs,
                        step.duration);
    total += step.duration;
  }
  return text +
         fmt::format("{:<22}  {:<22}  {:<26}  {:>8}  {:>8.1f} s at most\n", "", "", "", "", total);
}

namespace {

// Nine digits: the nominal value must lie within the printed ends.
std::string print_toleranced(double value, double low, double high, const std::string& unit) {
  return fmt::format("{:.9g} {} ({:.9g} {} to {:.9g} {})", value, unit, low, unit, high, unit);
}

const IdentifiedParameter* find_identified(const Identification& found, const char* name) {
  for (const IdentifiedParameter& parameter : found.parameters)
    if (parameter.name == name && parameter.identifiable) return &parameter;
  return nullptr;
}

void put(json& object, const std::string& key, const Identification& found, const char* name,
         const MotionTerms& terms, bool with_tolerance = true) {
  const IdentifiedParameter* parameter = find_identified(found, name);
  if (parameter == nullptr) return;
  const double value = std::max(*parameter->value, 0.0);
  object[key] = with_tolerance
                    ? json(print_toleranced(value, std::max(*parameter->low, 0.0), *parameter->high,
                                            unit_for(*parameter, terms)))
                    : json(value);
}

}  // namespace

json make_identified_model(const Identification& found, const std::optional<json>& base,
                           const IdentifiedModelOptions& options) {
  const MotionTerms& terms = terms_of(options.motion);
  json model = base.value_or(json::object());
  if (!base) {
    for (const char* name : {"resistance", "torque_constant", "inertia"}) {
      if (find_identified(found, name) != nullptr) continue;
      throw Error(ErrorCode::numerical, "identified model",
                  fmt::format("no {} was identified ({}): a base with --model is needed",
                              name_for(name, terms), found.find(name).note));
    }
    model = {{"schema", "gyrator/model/1"},
             {"name", options.name},
             {"motion", terms.name},
             {"motor", json::object()},
             {"mechanics", json::object()},
             {"amplifier", {{"kind", "current"}}},
             {"sampling", {{"period", options.period}}}};
    if (found.position_quantum > 0) model["sensor"] = {{"quantum", found.position_quantum}};
  }
  json& motor = model["motor"];
  put(motor, terms.motor_constant_name, found, "torque_constant", terms);
  put(motor, "resistance", found, "resistance", terms);
  put(motor, "inductance", found, "inductance", terms);
  json& mechanics = model["mechanics"];
  put(mechanics, terms.inertia_name, found, "inertia", terms);
  put(mechanics, "damping", found, "damping", terms);
  put(mechanics, "coulomb_friction", found, "coulomb_friction", terms, false);
  if (model.contains("amplifier")) put(model["amplifier"], "bandwidth", found, "bandwidth", terms);
  put(model["sampling"], "delay", found, "delay", terms, false);
  return model;
}

}  // namespace gyrator
