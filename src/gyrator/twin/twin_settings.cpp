// The names that a simulated amplifier's settings and actual values go by.

#include "gyrator/core/error.hpp"
#include "gyrator/core/text.hpp"
#include "gyrator/twin/simulated_amplifier.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <vector>

#include <fmt/core.h>

namespace gyrator {
namespace {

struct NumberSetting {
  std::string_view name;
  double TwinSettings::*value;
  double least, most;
  const char* unit;
};
constexpr std::array number_settings{
    NumberSetting{"current_limit", &TwinSettings::current_limit, 0, 1e3, "A"},
    NumberSetting{"voltage_limit", &TwinSettings::voltage_limit, 0, 1e3, "V"},
    NumberSetting{"temperature_limit", &TwinSettings::temperature_limit, 200, 600, "K"},
    NumberSetting{"velocity_limit", &TwinSettings::velocity_limit, 1e-6, 1e6, "rad/s or m/s"},
    NumberSetting{"cancellation_resistance", &TwinSettings::cancellation_resistance, 0, 1e4, "ohm"},
    NumberSetting{"damping_resistance", &TwinSettings::damping_resistance, 0, 1e6, "ohm"},
    NumberSetting{"damping_capacitance", &TwinSettings::damping_capacitance, 0, 10, "F"},
    NumberSetting{"back_emf_damping", &TwinSettings::back_emf_damping, 0, 1e4,
                  "N.m.s/rad or N.s/m"},
    NumberSetting{"back_emf_resistance", &TwinSettings::back_emf_resistance, 0, 1e4, "ohm"},
    NumberSetting{"watchdog_period", &TwinSettings::watchdog_period, 0, 1e4, "s"},
};

const NumberSetting* find_number(std::string_view name) {
  const auto* found = std::find_if(number_settings.begin(), number_settings.end(),
                                   [&](const NumberSetting& s) { return s.name == name; });
  return found == number_settings.end() ? nullptr : found;
}

bool* find_switch(TwinSettings& settings, std::string_view name) {
  if (name == "enable") return &settings.enable;
  if (name == "damping_connected") return &settings.damping_connected;
  return nullptr;
}

[[noreturn]] void refuse_unknown(std::string_view name) {
  std::vector<std::string> known = SimulatedAmplifier::setting_names();
  for (const std::string& actual : SimulatedAmplifier::actual_names()) known.push_back(actual);
  throw Error(ErrorCode::bad_input, "setting",
              describe_unknown_name("setting", std::string(name), known));
}

// 0 or 1, as switches and the drive mode are written.
bool to_switch(std::string_view name, double value) {
  if (value == 0 || value == 1) return value == 1;
  throw Error(ErrorCode::bad_input, std::string(name), fmt::format("{:g}: must be 0 or 1", value));
}

// Whether the circuit is another one, or has other values.
bool is_same_circuit(TwinSettings a, const TwinSettings& b) {
  a.current_limit = b.current_limit;
  a.temperature_limit = b.temperature_limit;
  a.velocity_limit = b.velocity_limit;
  a.watchdog_period = b.watchdog_period;
  return a == b;
}

}  // namespace

const std::vector<std::string>& SimulatedAmplifier::setting_names() {
  static const std::vector<std::string> names = [] {
    std::vector<std::string> all{"enable", "drive_mode", "damping_connected"};
    for (const NumberSetting& setting : number_settings) all.emplace_back(setting.name);
    return all;
  }();
  return names;
}

const std::vector<std::string>& SimulatedAmplifier::actual_names() {
  static const std::vector<std::string> names{
      "current", "voltage", "velocity", "position", "winding_temperature", "fault", "device_time"};
  return names;
}

bool SimulatedAmplifier::has_setting(std::string_view name) {
  return std::find(setting_names().begin(), setting_names().end(), name) != setting_names().end();
}

bool SimulatedAmplifier::has_actual(std::string_view name) {
  return std::find(actual_names().begin(), actual_names().end(), name) != actual_names().end();
}

double SimulatedAmplifier::read(std::string_view name) {
  if (const NumberSetting* number = find_number(name)) return settings_.*number->value;
  if (const bool* on = find_switch(settings_, name)) return *on ? 1 : 0;
  if (name == "drive_mode") return settings_.drive_mode == DriveMode::voltage ? 1 : 0;
  const TwinNoise& noise = twin_.noise;
  if (name == "current") return sense(current_, noise.current, twin_.current_step, reading_noise_);
  if (name == "voltage")
    return sense(plant_->now().voltage(), noise.voltage, twin_.voltage_step, reading_noise_);
  if (name == "velocity")
    return sense(plant_->now().velocity(), noise.velocity, twin_.velocity_step, reading_noise_);
  if (name == "position")
    return sense(plant_->now().position(), noise.position, twin_.position_quantum, reading_noise_);
  if (name == "winding_temperature") return winding_temperature();
  if (name == "fault") return faults_;
  if (name == "device_time") return time();
  refuse_unknown(name);
}

void SimulatedAmplifier::write(std::string_view name, double value) {
  if (name == "clear_fault") {
    if (value != 0) clear_faults();
    return;
  }
  if (name == "watchdog") return feed_watchdog();
  TwinSettings wanted = settings_;
  if (const NumberSetting* number = find_number(name)) {
    if (!(value >= number->least && value <= number->most)) {
      throw Error(ErrorCode::bad_input, std::string(name),
                  fmt::format("{:g} {}: must be between {:g} and {:g} {}", value, number->unit,
                              number->least, number->most, number->unit));
    }
    wanted.*number->value = value;
  } else if (bool* on = find_switch(wanted, name)) {
    *on = to_switch(name, value);
  } else if (name == "drive_mode") {
    wanted.drive_mode = to_switch(name, value) ? DriveMode::voltage : DriveMode::current;
  } else {
    refuse_unknown(name);
  }
  if (wanted.enable && !settings_.enable && faults_ != 0) {
    throw Error(ErrorCode::device, "enable",
                "refused: the fault " + describe_faults(faults_) + " has not been cleared");
  }
  if (wanted.drive_mode != settings_.drive_mode && settings_.enable) {
    throw Error(ErrorCode::device, "drive_mode", "refused: the drive is on; switch it off first");
  }
  apply(wanted);
}

void SimulatedAmplifier::apply(const TwinSettings& wanted) {
  const bool switched = wanted.enable != settings_.enable;
  if (!is_same_circuit(settings_, wanted)) rebuild(wanted, heat_.resistance());
  settings_ = wanted;
  if (!switched) return;
  stop();
  reset_commands();
  feed_watchdog();
  quiet_since_ = now_;
}

}  // namespace gyrator
