#include "gyrator/studies/model_file.hpp"

#include "gyrator/core/error.hpp"
#include "gyrator/core/quantity.hpp"
#include "gyrator/documents/document_kind.hpp"
#include "gyrator/documents/document_reader.hpp"
#include "gyrator/documents/json_text.hpp"
#include "gyrator/mechanics/actuation_roots.hpp"
#include "gyrator/passivity/held_limit.hpp"
#include "gyrator/plots/pretty_text.hpp"
#include "gyrator/studies/controller_format.hpp"
#include "gyrator/studies/device_document.hpp"
#include "gyrator/studies/environment_format.hpp"
#include "gyrator/studies/model_format.hpp"
#include "gyrator/studies/motion_terms.hpp"
#include "gyrator/studies/operator_format.hpp"
#include "gyrator/studies/result_parts.hpp"
#include "gyrator/studies/sampling_format.hpp"
#include "gyrator/studies/wrapper_format.hpp"

#include <algorithm>
#include <numbers>
#include <utility>

#include <fmt/core.h>

namespace gyrator {
namespace {

using nlohmann::json;

// The document has been validated: every key is there, of the right type, in SI units.

Rational time_of(const json& value) {
  return Rational::from_text(value.get<std::string>());
}

std::optional<Rational> slow_period_of(const json& sampling) {
  if (sampling["slow_period"].is_null()) return std::nullopt;
  return time_of(sampling["slow_period"]);
}

std::optional<double> optional_of(const json& object, const char* key) {
  if (object[key].is_null()) return std::nullopt;
  return object[key].get<double>();
}

// An analog loop does the wall: the controller must be one, and no estimate of velocity is made.
void check_held_impedance(const Model& model, const std::string& file) {
  const auto* wall = std::get_if<VirtualWall>(&model.controller.law);
  if (!wall) {
    throw Error(ErrorCode::bad_input, file + ": /damping",
                "held_impedance: the loop takes stiffness and damping from a virtual wall; use "
                "\"controller\": {\"kind\": \"virtual_wall\"}");
  }
  if (!model.controller.wrappers.empty()) {
    throw Error(ErrorCode::bad_input, file + ": /controller",
                "passivity control or contact effects with held_impedance: the analog loop takes "
                "stiffness and damping only; leave them out");
  }
  if (wall->unilateral) {
    throw Error(ErrorCode::bad_input, file + ": /controller/unilateral",
                "true with held_impedance: the analog loop is linear, its wall bilateral");
  }
}

// The wave controller reads the drive's wave instead of a position, and takes its scales from the
// drive.
void connect_wave(Model& model, WaveController& wave, const json& sensor) {
  const auto& damping = model.device.drive.damping;
  const auto drive = std::find_if(damping.begin(), damping.end(), [](const Damping& d) {
    return std::holds_alternative<WaveDamping>(d);
  });
  if (drive == damping.end()) {
    throw Error(
        ErrorCode::bad_input, "controller/kind",
        "\"wave\" without a wave drive to read: add {\"kind\": \"wave\", \"impedance\": …} to "
        "\"damping\", with \"amplifier\": {\"kind\": \"voltage\"}");
  }
  for (const char* key : {"quantum", "offset", "noise"}) {
    if (sensor[key] == 0) continue;
    throw Error(ErrorCode::bad_input, std::string("sensor/") + key,
                "a controller of kind \"wave\" reads no position: leave it out");
  }
  if (sensor["location"] == "motor") {
    throw Error(ErrorCode::bad_input, "sensor/location",
                "\"motor\": a controller of kind \"wave\" reads no position: leave it out");
  }
  model.device.sensor = SensorLocation::outgoing_wave;
  wave.impedance = std::get<WaveDamping>(*drive).impedance;
  wave.volts_per_velocity = model.device.drive.motor->torque_constant;
  wave.volts_per_command =
      build_device_network(model.device, FreeOperator{}).drive.volts_per_command;
  make_wave_law(wave, model.sampling.period.to_double());  // refuses what it cannot be
}

// The output stage inverts the drive as it is, so that it comes after it.
void connect_pre_emphasis(Model& model, const json& stage) {
  if (find_held_impedance(model.device)) {
    throw Error(ErrorCode::bad_input, "controller/pre_emphasis",
                "with held_impedance: the wall acts in an analog loop, no command is left to "
                "emphasize; leave it out");
  }
  const double period = model.sampling.period.to_double();
  const auto band_hz = optional_of(stage, "band");
  const double band = band_hz ? 2 * std::numbers::pi * *band_hz : std::numbers::pi / period;
  const ActuationRoots roots = find_actuation_roots(model.device);
  model.controller.wrappers.emplace_back(make_pre_emphasis(roots.poles, roots.zeros, band, period));
}

// What the operator moves with the port itself.
double port_inertia(const Mechanics& mechanics) {
  return mechanics.transmission ? mechanics.transmission->load_inertia : mechanics.inertia;
}

// What no single key can tell.
void check_together(Model& model, const json& source, const json& read, const std::string& file) {
  const bool ideal = std::holds_alternative<IdealDrive>(model.device.drive.amplifier);
  if (!model.device.drive.motor && !ideal) {
    const std::string kind =
        source.contains("amplifier") ? "this amplifier" : "the default amplifier (current)";
    throw Error(
        ErrorCode::bad_input, file + ": /motor",
        "missing: " + kind +
            " needs a motor to drive: add \"motor\", or use \"amplifier\": {\"kind\": \"ideal\"}");
  }
  if (const auto& motor = model.device.drive.motor; motor && !(motor->warm_resistance() > 0)) {
    throw Error(
        ErrorCode::bad_input, file + ": /motor/temperature_rise",
        fmt::format("{}: the winding would have {}; with its temperature_coefficient it must be "
                    "above {}",
                    format_quantity(motor->temperature_rise, dimension::temperature),
                    format_quantity(motor->warm_resistance(), dimension::resistance),
                    format_quantity(-1 / motor->temperature_coefficient, dimension::temperature)));
  }
  try {
    check_wrappers(model.controller, read["controller"], model.sampling.period.to_double());
    build_device_network(model.device, FreeOperator{});
    if (auto* wave = std::get_if<WaveController>(&model.controller.law))
      connect_wave(model, *wave, read["sensor"]);
    if (const auto* wall = std::get_if<VirtualWall>(&model.controller.law))
      check_velocity_estimator(wall->velocity, model.sampling.period.to_double());
    const json& controller = read["controller"];
    if (controller.contains("pre_emphasis") && !controller["pre_emphasis"].is_null())
      connect_pre_emphasis(model, controller["pre_emphasis"]);
    check_environment(model.controller, model.sampling.period, slow_period_of(read["sampling"]));
  } catch (const Error& error) {
    throw Error(error.code(), file + ": /" + error.place(), error.message());
  }
  const auto* wall = std::get_if<VirtualWall>(&model.controller.law);
  if (find_held_impedance(model.device)) check_held_impedance(model, file);
  if (wall && wall->no_pull && !wall->unilateral) {
    throw Error(ErrorCode::bad_input,
                fmt::format("{}: {}/no_pull", file, find_law_place(read["controller"])),
                "true for a bilateral wall: only a unilateral wall can be kept from pulling; set "
                "\"unilateral\": true");
  }
}

}  // namespace

Controller Model::sampled_controller() const {
  return find_held_impedance(device) ? Controller{NoController{}} : controller;
}

Model parse_model(const json& document, const std::string& file) {
  check_document_kind(document, model_schema_name, file);
  const ReadDocument read = read_document_with_tolerances(document, model_format(), file);
  const json& m = read.normal;
  Model model;
  model.name = plain_text(m["name"].get<std::string>());
  model.file = file;
  model.device.motion = m["motion"] == "rotary" ? Motion::rotary : Motion::linear;
  model.device.drive = make_drive(m, file);
  model.device.mechanics = make_mechanics(m["mechanics"]);
  model.device.sensor =
      m["sensor"]["location"] == "motor" ? SensorLocation::motor : SensorLocation::port;
  model.device.sensor_filter = parse_sensor_filter(m["sensor"]);
  model.sensor = parse_sensor(m["sensor"]);
  model.sampling = parse_sampling(m["sampling"], file);
  model.dac = parse_dac(m["dac"]);
  model.controller =
      parse_controller(m["controller"], {.period = model.sampling.period,
                                         .quantum = model.sensor.quantum,
                                         .inertia = port_inertia(model.device.mechanics),
                                         .slow_period = slow_period_of(m["sampling"])});
  model.held_by = parse_operator(m["operator"], file);
  const json& s = m["simulation"];
  model.duration = time_of(s["duration"]);
  model.initial_velocity = s["initial_velocity"];
  model.initial_position = s["initial_position"];
  model.external_effort = s["external_effort"];
  model.gesture = parse_gesture(s["gesture"], model.held_by, file);
  model.seed = s["seed"];
  model.source = document;
  check_together(model, document, m, file);
  model.parts = find_device_parts(m, read.tolerances);
  if (!read.tolerances.empty()) naming_file(model, [&] { check_device_box(model.device_box()); });
  return model;
}

Model load_model(const std::string& path) {
  return parse_model(load_json_file(path), path);
}

json unit_names(Motion motion) {
  const MotionUnits& units = units_of(motion);
  return {{"position", units.position.symbol},   {"velocity", units.velocity.symbol},
          {"effort", units.effort.symbol},       {"damping", units.damping.symbol},
          {"stiffness", units.stiffness.symbol}, {"inertia", units.inertia.symbol}};
}

}  // namespace gyrator
