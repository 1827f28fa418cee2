#include "gyrator/amplifiers/modbus_bench.hpp"

#include "gyrator/core/error.hpp"
#include "gyrator/core/interrupt.hpp"
#include "gyrator/core/text.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <thread>

#include <fmt/core.h>

namespace gyrator {
namespace {

using std::chrono::steady_clock;

// A look every so long is enough for people and motors, and leaves the link its time [s].
constexpr double look_interval = 0.02;
// What the noise and the ripple of a current may be above its limit.
constexpr double current_margin = 1.2;
// Beyond the time that the device needs, for the link and a slow device [s].
constexpr double patience = 5;

[[noreturn]] void refuse(const std::string& what, const std::string& message) {
  throw Error(ErrorCode::bad_input, what, message);
}

const DeviceExcitation& generator_of(const DeviceProfile& profile) {
  if (!profile.excitation) refuse(profile.name, "its profile has no generator (excitation)");
  return *profile.excitation;
}

const DeviceCapture& buffer_of(const DeviceProfile& profile) {
  if (!profile.capture) refuse(profile.name, "its profile has no capture buffer (capture)");
  return *profile.capture;
}

std::vector<double>& samples_of(Capture& capture, CaptureSignal signal) {
  switch (signal) {
    case CaptureSignal::command:
      return capture.command;
    case CaptureSignal::current:
      return capture.current;
    case CaptureSignal::voltage:
      return capture.voltage;
    case CaptureSignal::velocity:
      return capture.velocity;
    case CaptureSignal::position:
      break;
  }
  return capture.position;
}

void check_memory(const DeviceProfile& profile) {
  for (const std::string& name : find_experiment_registers(profile)) {
    if (!profile.at(name).persistent) continue;
    refuse(name, "is in persistent memory, by the profile: experiments write it again and again");
  }
}

}  // namespace

std::vector<std::string> find_experiment_registers(const DeviceProfile& profile) {
  std::vector<std::string> names;
  const auto add = [&](const std::string& name) {
    const bool is_new = std::find(names.begin(), names.end(), name) == names.end();
    if (!name.empty() && profile.find(name) != nullptr && is_new) names.push_back(name);
  };
  add("drive_mode");
  if (profile.excitation) {
    const DeviceExcitation& e = *profile.excitation;
    for (const std::string& name : {e.kind, e.amplitude, e.offset, e.frequency, e.end_frequency,
                                    e.duration, e.start.register_name, e.stop.register_name})
      add(name);
  }
  if (profile.capture) {
    const DeviceCapture& c = *profile.capture;
    for (const std::string& name : {c.delay, c.decimation, c.samples, c.arm.register_name, c.page})
      add(name);
  }
  add("enable");
  if (profile.watchdog) add(profile.watchdog->feed.register_name);
  if (profile.clock) add(profile.clock->advance);
  return names;
}

ModbusBench::ModbusBench(AmplifierPort& port)
    : port_(port), excitation_(generator_of(port.profile())), capture_(buffer_of(port.profile())) {
  const DeviceProfile& profile = port_.profile();
  check_memory(profile);
  limits_.shortest_period = capture_.period;
  limits_.most_samples = capture_.max_samples;
  limits_.longest_duration = range_of(profile.at(excitation_.duration)).high;
  if (!excitation_.frequency.empty()) {
    const ValueRange range = range_of(profile.at(excitation_.frequency));
    limits_.lowest_frequency_hz = std::max(range.low, 1e-3);
    limits_.highest_frequency_hz = range.high;
  }
  if (const DeviceRegister* position = capture_.find(CaptureSignal::position)) {
    const bool is_float =
        position->type == RegisterType::f32 || position->type == RegisterType::f64;
    limits_.position_quantum = is_float ? 0 : std::fabs(position->scale * position->factor);
  }
  for (const auto kind : {ExcitationKind::dc, ExcitationKind::step, ExcitationKind::sine,
                          ExcitationKind::chirp, ExcitationKind::prbs}) {
    const bool needs_frequency = kind == ExcitationKind::sine || kind == ExcitationKind::chirp ||
                                 kind == ExcitationKind::prbs;
    const bool has_registers =
        (!needs_frequency || !excitation_.frequency.empty()) &&
        (kind != ExcitationKind::chirp || !excitation_.end_frequency.empty());
    if (has_registers && find_code(profile.at(excitation_.kind), name_of(kind)))
      limits_.kinds.push_back(kind);
  }
  const DeviceRegister* mode = profile.find("drive_mode");
  for (const auto each : {DriveMode::current, DriveMode::voltage}) {
    const bool offered =
        mode == nullptr ? each == DriveMode::current : find_code(*mode, name_of(each)).has_value();
    if (offered) limits_.modes.push_back(each);
  }
  read_limits();
}

void ModbusBench::read_limits() {
  const DeviceProfile& profile = port_.profile();
  const auto limit_of = [&](const char* name) -> std::optional<double> {
    const DeviceRegister* place = profile.find(name);
    if (place == nullptr) return {};
    const std::optional<double> set = place->readable ? port_.read(name) : std::optional<double>();
    return std::min(port_.upper_limit(name), set.value_or(HUGE_VAL));
  };
  const double largest_command = range_of(profile.at(excitation_.amplitude)).high;
  limits_.largest_current = std::min(largest_command, limit_of("current_limit").value_or(HUGE_VAL));
  limits_.largest_voltage = std::min(largest_command, limit_of("voltage_limit").value_or(HUGE_VAL));
  hottest_ = limit_of("temperature_limit");
  const DeviceRegister* velocity = profile.find("velocity");
  if (velocity != nullptr && velocity->high) limits_.largest_velocity = *velocity->high;
}

bool ModbusBench::has_setting(std::string_view name) const {
  return port_.profile().find(name) != nullptr;
}

SettingRange ModbusBench::setting_range(std::string_view name) const {
  const DeviceRegister& place = port_.profile().at(name);
  const bool is_float = place.type == RegisterType::f32 || place.type == RegisterType::f64;
  const double resolution = is_float ? 0 : std::fabs(place.scale * place.factor);
  return {range_of(place).low, port_.upper_limit(name), place.step.value_or(resolution)};
}

void ModbusBench::write_setting(std::string_view name, double value) {
  const DeviceRegister& place = port_.profile().at(name);
  if (place.persistent) {
    if (place.readable && port_.read(name) == find_nearest_value(place, value)) return;
    throw Error(ErrorCode::device, fmt::format("{} ({})", place.name, place.describe_place()),
                fmt::format("refused: {}: it is in persistent memory, which experiments would wear "
                            "out{}{}",
                            describe_value(place, value), place.write_cost.empty() ? "" : ", ",
                            place.write_cost));
  }
  // What is set under a running motor would be felt at once.
  if (!is_off_ && has_setting("enable")) port_.write("enable", 0);
  is_off_ = true;
  port_.write(name, value);
  if (name.ends_with("_limit")) read_limits();
}

std::optional<double> ModbusBench::winding_temperature() {
  if (!has_setting("winding_temperature")) return {};
  return port_.read("winding_temperature");
}

void ModbusBench::check_request(const Excitation& excitation, const CaptureRequest& request) const {
  check_excitation(excitation);
  const std::string what = describe(excitation);
  const auto offers = [](const auto& list, auto each) {
    return std::find(list.begin(), list.end(), each) != list.end();
  };
  if (!offers(limits_.kinds, excitation.kind))
    refuse(what, "the amplifier's generator has no such kind");
  if (!offers(limits_.modes, excitation.mode))
    refuse(what, fmt::format("the amplifier has no {} mode", name_of(excitation.mode)));
  const double most =
      excitation.mode == DriveMode::current ? limits_.largest_current : limits_.largest_voltage;
  if (find_peak(excitation) > most * (1 + 1e-9)) {
    refuse(what,
           fmt::format("reaches {:.6g} {}: at most {:.6g} {} are allowed", find_peak(excitation),
                       unit_of(excitation.mode), most, unit_of(excitation.mode)));
  }
  const double decimation = request.period / capture_.period;
  if (!(decimation > 0.5) || std::fabs(decimation - std::round(decimation)) > 1e-6 * decimation) {
    refuse(what, fmt::format("a capture every {:.6g} s: must be a multiple of {:.6g} s",
                             request.period, capture_.period));
  }
  if (capture_.decimation.empty() && std::round(decimation) != 1)
    refuse(what, fmt::format("the capture's period is {:.6g} s always", capture_.period));
  if (request.samples < 1 || request.samples > limits_.most_samples) {
    refuse(what, fmt::format("a capture of {} samples: must be from 1 to {}", request.samples,
                             limits_.most_samples));
  }
  if (request.start < 0 || (request.start > 0 && capture_.delay.empty()))
    refuse(what, fmt::format("a capture from {:.6g} s on: cannot begin there", request.start));
}

void ModbusBench::set_mode(DriveMode mode) {
  if (std::find(limits_.modes.begin(), limits_.modes.end(), mode) == limits_.modes.end())
    refuse("drive_mode", fmt::format("the amplifier has no {} mode", name_of(mode)));
  const DeviceRegister* place = port_.profile().find("drive_mode");
  if (place == nullptr) return;  // of current only
  port_.write(place->name, static_cast<double>(*find_code(*place, name_of(mode))));
}

void ModbusBench::set_up(const Excitation& excitation, const CaptureRequest& request) {
  const DeviceProfile& profile = port_.profile();
  const auto write_if = [&](const std::string& name, double value) {
    if (!name.empty()) port_.write(name, value);
  };
  const auto code = [&](const std::string& name, std::string_view word) {
    return static_cast<double>(*find_code(profile.at(name), word));
  };
  set_mode(excitation.mode);
  port_.write(excitation_.kind, code(excitation_.kind, name_of(excitation.kind)));
  // A constant command is its offset.
  const bool has_amplitude = excitation.kind != ExcitationKind::dc;
  port_.write(excitation_.amplitude, has_amplitude ? excitation.amplitude : 0);
  port_.write(excitation_.offset, excitation.offset);
  const bool has_frequency = has_amplitude && excitation.kind != ExcitationKind::step;
  if (has_frequency) write_if(excitation_.frequency, excitation.frequency_hz);
  if (excitation.kind == ExcitationKind::chirp)
    write_if(excitation_.end_frequency, excitation.end_frequency_hz);
  port_.write(excitation_.duration, excitation.duration);
  write_if(capture_.delay, request.start);
  write_if(capture_.decimation, std::round(request.period / capture_.period));
  port_.write(capture_.samples, request.samples);
}

void ModbusBench::check_faults(const char* when) {
  const std::vector<std::string> faults = port_.read_faults();
  if (faults.empty()) return;
  throw Error(ErrorCode::device, port_.profile().name,
              fmt::format("fault {}: {}", when, join(faults)));
}

// Whether the buffer is full; throws for what must not go on.
bool ModbusBench::look() {
  const DeviceProfile& profile = port_.profile();
  std::vector<std::string> names{capture_.state};
  for (const char* name : {"current", "velocity", "winding_temperature"})
    if (const DeviceRegister* place = profile.find(name); place != nullptr && place->readable)
      names.emplace_back(name);
  if (profile.fault) names.push_back(profile.fault->register_name);
  const auto values = port_.read_several(names);
  const auto refuse_more = [&](const char* name, const std::optional<double>& most) {
    const auto found = values.find(name);
    if (!most || *most <= 0 || found == values.end() || !found->second) return;
    if (std::fabs(*found->second) <= *most) return;
    const DeviceRegister& place = profile.at(name);
    throw Error(ErrorCode::device, name,
                fmt::format("{} during the excitation: at most {} is allowed",
                            describe_value(place, *found->second), describe_value(place, *most)));
  };
  if (profile.fault && values.at(profile.fault->register_name).value_or(0) != 0)
    check_faults("during the excitation");
  refuse_more("current", limits_.largest_current * current_margin);
  refuse_more("velocity", limits_.largest_velocity);
  refuse_more("winding_temperature", hottest_);
  const auto done = find_code(profile.at(capture_.state), "done");
  return values.at(capture_.state) == static_cast<double>(*done);
}

void ModbusBench::play(const Excitation& excitation, const CaptureRequest& request) {
  set_up(excitation, request);
  port_.perform(capture_.arm, true);
  if (has_setting("enable")) port_.write("enable", 1);
  port_.perform(excitation_.start);
  const double longest = request.start + request.period * request.samples + patience;
  const auto begin = steady_clock::now();
  while (!look()) {
    throw_if_interrupted(describe(excitation));
    const std::chrono::duration<double> waited = steady_clock::now() - begin;
    if (waited.count() > longest) {
      throw Error(ErrorCode::device, capture_.state,
                  fmt::format("the capture is not done after {:.3g} s, which was to take {:.3g} s",
                              waited.count(), longest - patience));
    }
    std::this_thread::sleep_for(std::chrono::duration<double>(look_interval));
  }
}

// Off before anything else; where the link is in the way, with all patience. `cause`: the error
// that ended the run, if one did.
void ModbusBench::switch_off(const std::string& cause) {
  std::string reason;
  try {
    if (!interrupt_requested()) {
      if (has_setting("enable")) port_.write("enable", 0);
      port_.perform(excitation_.stop, true);
      return;
    }
  } catch (const Error& error) {  // below with more patience
    reason = error.what();
  }
  const bool was_interrupted = interrupt_requested();
  const AmplifierPort::SafeResult safe = port_.make_safe();
  const std::string after = cause.empty() ? "" : "; before that: " + cause;
  const std::string& device = port_.profile().name;
  if (safe.state == DeviceState::unknown) {
    throw Error(ErrorCode::device, device,
                "THE DRIVE COULD NOT BE SWITCHED OFF: " + join(safe.failed, "; ") + after);
  }
  if (was_interrupted) throw Error(ErrorCode::interrupted, device, "interrupted" + after);
  // Every `safe` value stands now: nothing that goes on would be with the settings it was for.
  throw Error(ErrorCode::device, device, "switched off only by its safe state: " + reason + after);
}

Capture ModbusBench::run(const Excitation& excitation, const CaptureRequest& request) {
  check_request(excitation, request);
  if (!port_.options().apply) {
    throw Error(ErrorCode::device, describe(excitation),
                "refused: an excitation moves the motor, which needs --apply");
  }
  check_faults("before the excitation");
  Capture capture;
  capture.start = request.start;
  capture.period = request.period;
  capture.winding_temperature_before = winding_temperature();
  if (has_setting("enable")) port_.write("enable", 0);
  is_off_ = true;  // and at the end of a run again
  try {
    play(excitation, request);
  } catch (const Error& error) {
    switch_off(error.code() == ErrorCode::interrupted ? "" : error.what());
    throw;
  } catch (const std::exception& error) {
    switch_off(error.what());
    throw;
  }
  switch_off({});
  check_faults("at the end of the excitation");
  read_buffer(request.samples, capture);
  capture.winding_temperature_after = winding_temperature();
  return capture;
}

void ModbusBench::read_buffer(int samples, Capture& capture) {
  const int page = capture_.page.empty() ? samples : capture_.page_samples;
  for (int first = 0; first < samples; first += page) {
    if (!capture_.page.empty()) port_.write(capture_.page, first / page);
    for (const auto& [signal, place] : capture_.signals) {
      std::vector<double>& kept = samples_of(capture, signal);
      const auto read = port_.read_window(place, std::min(page, samples - first));
      kept.insert(kept.end(), read.begin(), read.end());
    }
  }
  for (const auto& [signal, place] : capture_.signals) {
    const std::vector<double>& kept = samples_of(capture, signal);
    const auto gap =
        std::find_if(kept.begin(), kept.end(), [](double x) { return !std::isfinite(x); });
    if (gap == kept.end()) continue;
    throw Error(ErrorCode::device, place.name,
                fmt::format("sample {} of {} is no number", gap - kept.begin(), samples));
  }
}

}  // namespace gyrator
