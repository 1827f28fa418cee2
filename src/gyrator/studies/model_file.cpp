#include "gyrator/studies/model_file.hpp"

#include "gyrator/core/error.hpp"
#include "gyrator/core/quantity.hpp"
#include "gyrator/documents/document_reader.hpp"
#include "gyrator/documents/json_text.hpp"
#include "gyrator/mechanics/actuation_roots.hpp"
#include "gyrator/passivity/held_limit.hpp"
#include "gyrator/plots/pretty_text.hpp"
#include "gyrator/studies/controller_format.hpp"
#include "gyrator/studies/environment_format.hpp"
#include "gyrator/studies/model_format.hpp"
#include "gyrator/studies/motion_terms.hpp"
#include "gyrator/studies/operator_format.hpp"
#include "gyrator/studies/sampling_format.hpp"
#include "gyrator/studies/wrapper_format.hpp"

#include <algorithm>
#include <filesystem>
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

Amplifier amplifier_of(const json& a) {
  std::optional<double> bandwidth_hz;
  if (a.contains("bandwidth") && !a["bandwidth"].is_null()) bandwidth_hz = a["bandwidth"];
  if (a["kind"] == "current") {
    return CurrentAmplifier{bandwidth_hz,
                            a["sense"] == "motor" ? CurrentSense::motor : CurrentSense::total,
                            optional_of(a, "current_limit"), optional_of(a, "voltage_limit")};
  }
  if (a["kind"] == "voltage") {
    return VoltageAmplifier{bandwidth_hz, a["output_resistance"], optional_of(a, "current_limit"),
                            optional_of(a, "voltage_limit")};
  }
  return IdealDrive{};
}

HighPassDamper high_pass_damper_of(const json& d) {
  return {find_inertia(d), d["damping"]};
}

// The path stands relative to the model file's folder.
NetlistDamping netlist_of(const json& d, const std::string& model_file) {
  const auto path = std::filesystem::path(model_file).parent_path() / d["file"].get<std::string>();
  try {
    SpiceCircuit circuit =
        read_subcircuit(path, d["subckt"].get<std::string>(), {d["allow_negative"].get<bool>()});
    check_two_terminals(circuit);
    return {std::move(circuit)};
  } catch (const Error& error) {  // the reader knows the netlist, not who asked for it
    throw Error(error.code(), error.place(),
                fmt::format("{} (netlist of {})", error.message(), model_file));
  }
}

// One line per kind of the list. The motor gives what the drive would be set up with by default.
Damping damping_of(const json& d, const Motor& motor, const json& controller,
                   const std::string& file) {
  const std::string kind = d["kind"];
  if (kind == "resistor") return ResistorDamping{d["resistance"]};
  if (kind == "netlist") return netlist_of(d, file);
  if (kind == "rc") return RcDamping{d["resistance"], d["capacitance"]};
  if (kind == "clamp") return ClampDamping{d["voltage"], d["resistance"]};
  if (kind == "friction_brake") return FrictionBrake{d["damping"], d["effort"]};
  if (kind == "resistance_cancellation") {
    const auto fraction = optional_of(d, "fraction");
    return ResistanceCancellation{
        fraction ? *fraction * motor.resistance : d["resistance"].get<double>(),
        optional_of(d, "bandwidth")};
  }
  if (kind == "back_emf") {
    return BackEmfDamping{d["damping"],
                          optional_of(d, "resistance_estimate").value_or(motor.resistance),
                          optional_of(d, "inductance_estimate").value_or(motor.inductance),
                          optional_of(d, "low_pass"), optional_of(d, "high_pass")};
  }
  if (kind == "held_impedance") {
    const bool wall = controller["kind"] == "virtual_wall";
    return HeldImpedance{wall ? controller["stiffness"].get<double>() : 0,
                         wall ? controller["damping"].get<double>() : 0,
                         optional_of(d, "bandwidth")};
  }
  if (kind == "wave") return WaveDamping{d["impedance"]};
  if (kind == "torque_sensed_damper") return TorqueSensedDamper{d["damping"], d["cutoff"]};
  if (kind == "eddy_current_brake") return EddyCurrentBrake{d["damping"], d["on"]};
  return high_pass_damper_of(d);
}

Drive drive_of(const json& model, const std::string& file) {
  Drive drive;
  if (const json& m = model["motor"]; !m.is_null()) {
    drive.motor = Motor{find_either(m, "torque_constant", "force_constant"),
                        m["resistance"],
                        m["inductance"],
                        m["temperature_coefficient"],
                        m["temperature_rise"],
                        {}};
    if (const json& t = m["thermal"]; !t.is_null())
      drive.motor->thermal = WindingThermal{t["resistance"], t["capacity"]};
  }
  drive.amplifier = amplifier_of(model["amplifier"]);
  for (const auto& damping : model["damping"])
    drive.damping.push_back(
        damping_of(damping, drive.motor.value_or(Motor{}), model["controller"], file));
  if (const json& h = model["mechanics"]["high_pass_damper"]; !h.is_null())
    drive.damping.emplace_back(high_pass_damper_of(h));
  return drive;
}

Mechanics mechanics_of(const json& m) {
  Mechanics mechanics;
  mechanics.inertia = find_inertia(m);
  mechanics.damping = m["damping"];
  mechanics.coulomb_friction = m["coulomb_friction"];
  mechanics.stiction = optional_of(m, "stiction");
  mechanics.stribeck_velocity = m["stribeck_velocity"];
  if (const json& s = m["stops"]; !s.is_null()) {
    mechanics.stops =
        HardStops{optional_of(s, "lower"), optional_of(s, "upper"), s["stiffness"], s["damping"]};
  }
  if (const json& t = m["transmission"]; !t.is_null()) {
    mechanics.transmission =
        Transmission{t["stiffness"], t["damping"], find_either(t, "load_inertia", "load_mass")};
  }
  return mechanics;
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
  const json m = read_document(document, model_format(), file);
  Model model;
  model.name = plain_text(m["name"].get<std::string>());
  model.file = file;
  model.device.motion = m["motion"] == "rotary" ? Motion::rotary : Motion::linear;
  model.device.drive = drive_of(m, file);
  model.device.mechanics = mechanics_of(m["mechanics"]);
  model.device.sensor =
      m["sensor"]["location"] == "motor" ? SensorLocation::motor : SensorLocation::port;
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
