#include "gyrator/studies/device_document.hpp"

#include "gyrator/core/error.hpp"
#include "gyrator/studies/motion_terms.hpp"

#include <filesystem>
#include <optional>
#include <utility>

#include <fmt/core.h>

namespace gyrator {
namespace {

using nlohmann::json;

// The document has been validated: every key is there, of the right type, in SI units.

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

// One line per kind of the list. `motor` is the one that the drive is set up for.
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

// Everything but the list of dampings.
Drive start_drive(const json& model) {
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
  return drive;
}

double find_output_resistance(const Drive& drive) {
  const auto* voltage = std::get_if<VoltageAmplifier>(&drive.amplifier);
  return voltage ? voltage->output_resistance : 0;
}

}  // namespace

Drive make_drive(const json& model, const std::string& file) {
  Drive drive = start_drive(model);
  for (const auto& damping : model["damping"])
    drive.damping.push_back(
        damping_of(damping, drive.motor.value_or(Motor{}), model["controller"], file));
  if (const json& h = model["mechanics"]["high_pass_damper"]; !h.is_null())
    drive.damping.emplace_back(high_pass_damper_of(h));
  return drive;
}

Drive make_drive(const json& model, const Drive& nominal) {
  Drive drive = start_drive(model);
  const Motor set_for = nominal.motor.value_or(Motor{});
  const Motor motor = drive.motor.value_or(Motor{});
  const json& list = model["damping"];
  for (std::size_t i = 0; i < list.size(); ++i) {
    if (list[i]["kind"] == "netlist") {
      drive.damping.push_back(nominal.damping[i]);
      continue;
    }
    Damping damping = damping_of(list[i], set_for, model["controller"], "");
    if (auto* back_emf = std::get_if<BackEmfDamping>(&damping)) {  // (tol-1)
      back_emf->damping *= motor.torque_constant / set_for.torque_constant;
    } else if (auto* wave = std::get_if<WaveDamping>(&damping)) {  // (tol-2)
      const double whole = set_for.torque_constant * set_for.torque_constant / wave->impedance;
      const double resistor = whole - find_output_resistance(nominal);
      wave->impedance = motor.torque_constant * motor.torque_constant /
                        (resistor + find_output_resistance(drive));
    }
    drive.damping.push_back(std::move(damping));
  }
  if (const json& h = model["mechanics"]["high_pass_damper"]; !h.is_null())
    drive.damping.emplace_back(high_pass_damper_of(h));
  return drive;
}

Mechanics make_mechanics(const json& m) {
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

}  // namespace gyrator
