#include "gyrator/twin/simulated_amplifier.hpp"

#include "gyrator/core/error.hpp"
#include "gyrator/cosim/sensor.hpp"

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

#include <fmt/core.h>

namespace gyrator {
namespace {

// Each source of randomness has a stream of its own, so that reading a value changes no capture.
enum Stream : std::uint64_t {
  command_stream = 11,
  current_stream,
  voltage_stream,
  velocity_stream,
  position_stream,
  reading_stream
};

constexpr double supply_ratio = 10;  // most current of the supply, over the limit at the start

std::int64_t to_ticks(double seconds) {
  return std::llround(seconds * SimulatedAmplifier::ticks_per_second);
}

// Whole ticks that a time is, refusing what is none.
std::int64_t whole_ticks(const char* place, double seconds, std::int64_t least) {
  const double ticks = seconds * SimulatedAmplifier::ticks_per_second;
  const double nearest = std::round(ticks);
  if (std::isfinite(ticks) && std::abs(ticks - nearest) < 1e-6 && nearest < 1e12 &&
      nearest >= static_cast<double>(least))
    return static_cast<std::int64_t>(nearest);
  throw Error(
      ErrorCode::bad_input, place,
      fmt::format("{:.9g} s: must be a multiple of {:g} s and at least {:g} s", seconds,
                  SimulatedAmplifier::tick, static_cast<double>(least) * SimulatedAmplifier::tick));
}

// The node that is one end of the branch's capacitor.
std::string find_capacitor_node(const TwinDevice& twin, const TwinSettings& settings) {
  if (!(settings.damping_resistance > 0)) return "motor.terminal";
  const auto parts = std::count_if(twin.device.drive.damping.begin(),
                                   twin.device.drive.damping.end(), [](const Damping& d) {
                                     return !std::holds_alternative<RcDamping>(d) &&
                                            !std::holds_alternative<ResistanceCancellation>(d) &&
                                            !std::holds_alternative<BackEmfDamping>(d);
                                   });
  return fmt::format("damping.{}.node", parts);
}

bool has_branch(const TwinSettings& settings) {
  return settings.damping_connected && settings.damping_capacitance > 0;
}

bool is_voltage_driven(const TwinSettings& settings) {
  return settings.enable && settings.drive_mode == DriveMode::voltage;
}

}  // namespace

SimulatedAmplifier::SimulatedAmplifier(const TwinDevice& twin)
    : twin_((check_twin_device(twin), twin)),
      settings_(find_initial_settings(twin)),
      supply_current_(supply_ratio * settings_.current_limit),
      heat_(*twin.device.drive.motor, twin.thermal, twin.ambient - twin.reference_temperature,
            twin.winding_rise, tick),
      on_the_way_(static_cast<std::size_t>(twin.delay / tick + 1e-9) + 1),
      command_noise_(twin.seed, command_stream),
      current_noise_(twin.seed, current_stream),
      voltage_noise_(twin.seed, voltage_stream),
      velocity_noise_(twin.seed, velocity_stream),
      position_noise_(twin.seed, position_stream),
      reading_noise_(twin.seed, reading_stream) {
  rebuild(settings_, heat_.resistance());
}

void SimulatedAmplifier::advance(double seconds, bool watched) {
  advance_ticks(to_ticks(seconds), watched);
}

void SimulatedAmplifier::advance_ticks(std::int64_t ticks, bool watched) {
  constexpr std::int64_t between_looks = 1000;
  for (std::int64_t left = ticks; left > 0;) {
    if (is_at_rest()) {
      rest(left, watched);
      return;
    }
    const std::int64_t count = std::min(left, between_looks);
    for (std::int64_t i = 0; i < count; ++i) step(watched);
    left -= count;
  }
}

bool SimulatedAmplifier::is_at_rest() {
  constexpr double nothing = 1e-15;  // [J]: 10 urad/s of a small motor
  return !settings_.enable && capture_state_ != CaptureState::busy &&
         plant_->now().stored_energy() < nothing;
}

void SimulatedAmplifier::rest(std::int64_t ticks, bool watched) {
  now_ += ticks;
  if (watched) watched_ticks_ += ticks;
  heat_.cool(static_cast<double>(ticks) * tick);
  follow_winding();
}

void SimulatedAmplifier::follow_winding() {
  const double resistance = heat_.resistance();
  if (std::abs(resistance - plant_resistance_) > resistance_step * plant_resistance_)
    rebuild(settings_, resistance);
}

double SimulatedAmplifier::bound(double command) const {
  const double limit = settings_.drive_mode == DriveMode::current ? settings_.current_limit
                                                                  : settings_.voltage_limit;
  return std::clamp(command, -limit, limit);
}

void SimulatedAmplifier::step(bool watched) {
  command_ = 0;
  if (excitation_) {
    const double t = static_cast<double>(now_ - excitation_began_) / ticks_per_second;
    if (t < excitation_->duration) {
      command_ = compute_command(*excitation_, t);
    } else {
      excitation_.reset();
    }
  }
  record();
  if (settings_.enable) {
    double output = bound(command_);
    if (output != 0) quiet_since_ = now_ + 1;
    if (twin_.noise.command > 0) output += twin_.noise.command * command_noise_.normal();
    on_the_way_[next_] = output;
    next_ = (next_ + 1) % on_the_way_.size();
    const double before = held_;
    held_ = on_the_way_[next_];
    plant_->advance(time(), before, held_);
  } else {
    plant_->advance(time(), 0, 0);
  }
  ++now_;
  if (watched) ++watched_ticks_;
  const double before = current_;
  current_ = plant_->now().current();
  heat_.warm(delivered(before), delivered(current_));
  if (settings_.enable) protect();
  follow_winding();
}

double SimulatedAmplifier::delivered(double current) const {
  return std::isfinite(current) ? std::clamp(current, -supply_current_, supply_current_) : 0;
}

double SimulatedAmplifier::sense(double value, double noise, double step,
                                 RandomStream& random) const {
  if (noise > 0) value += noise * random.normal();
  return round_to_multiple(value, step);
}

void SimulatedAmplifier::record() {
  if (capture_state_ != CaptureState::busy || now_ < capture_next_) return;
  capture_.command.push_back(command_);
  capture_.current.push_back(
      sense(current_, twin_.noise.current, twin_.current_step, current_noise_));
  capture_.voltage.push_back(
      sense(plant_->now().voltage(), twin_.noise.voltage, twin_.voltage_step, voltage_noise_));
  capture_.velocity.push_back(
      sense(plant_->now().velocity(), twin_.noise.velocity, twin_.velocity_step, velocity_noise_));
  capture_.position.push_back(sense(plant_->now().position(), twin_.noise.position,
                                    twin_.position_quantum, position_noise_));
  capture_next_ += capture_every_;
  if (capture_.command.size() < capture_size_) return;
  capture_state_ = CaptureState::done;
  capture_.winding_temperature_after = winding_temperature();
}

void SimulatedAmplifier::reset_commands() {
  std::fill(on_the_way_.begin(), on_the_way_.end(), 0.0);
  held_ = 0;
}

void SimulatedAmplifier::rebuild(const TwinSettings& settings, double resistance) {
  const Device device = make_plant_device(twin_, settings, resistance);
  const double fraction = twin_.delay - static_cast<double>(on_the_way_.size() - 1) * tick;
  const double split = fraction > 1e-9 ? fraction : 0;  // [s]
  auto next = std::make_unique<RailedPlant>(device, tick, split);
  ++plants_built_;
  if (plant_) {
    PhysicalState stored = plant_->physical_state();
    double charge = charge_;
    if (has_branch(settings_))
      charge = stored.find(find_capacitor_node(twin_, settings_), true).value_or(0);
    if (has_branch(settings)) {
      stored.set_node(find_capacitor_node(twin_, settings), charge);
    }
    // The amplifier's own signal is a current in one mode and a voltage in the other.
    if (!is_voltage_driven(settings)) {
      stored.set_node("amplifier.loop", stored.output_current);
    } else if (!is_voltage_driven(settings_)) {
      stored.set_node("amplifier.loop", 0);
    }
    if (settings.enable != settings_.enable) reset_commands();
    // What has grown beyond all numbers starts from rest.
    const bool is_finite = stored.values.allFinite() && std::isfinite(charge);
    if (is_finite) next->set_state(stored, held_);
    if (!is_finite) charge = 0;
    charge_ = charge;
  }
  plant_ = std::move(next);
  plant_resistance_ = resistance;
  current_ = plant_->now().current();
}

void SimulatedAmplifier::start(const Excitation& excitation) {
  check_excitation(excitation);
  if (!settings_.enable)
    throw Error(ErrorCode::device, "start", "the drive is off: enable it before an excitation");
  if (excitation.mode != settings_.drive_mode) {
    throw Error(ErrorCode::device, "start",
                fmt::format("an excitation in {} with the drive in drive_mode {}",
                            name_of(excitation.mode), name_of(settings_.drive_mode)));
  }
  excitation_ = excitation;
  excitation_began_ = now_;
  if (capture_state_ != CaptureState::armed) return;
  capture_state_ = CaptureState::busy;
  capture_next_ = now_ + capture_start_;
  capture_.winding_temperature_before = winding_temperature();
}

void SimulatedAmplifier::stop() {
  excitation_.reset();
}

void SimulatedAmplifier::arm(const CaptureRequest& request) {
  const std::int64_t start = whole_ticks("capture/start", request.start, 0);
  const std::int64_t every = whole_ticks("capture/period", request.period, 1);
  if (request.samples < 1 || request.samples > most_samples) {
    throw Error(ErrorCode::bad_input, "capture/samples",
                fmt::format("{}: must be between 1 and {}", request.samples, most_samples));
  }
  capture_start_ = start;
  capture_every_ = every;
  capture_size_ = static_cast<std::size_t>(request.samples);
  capture_ = {};
  capture_.start = static_cast<double>(start) / ticks_per_second;
  capture_.period = static_cast<double>(every) / ticks_per_second;
  for (auto* column : {&capture_.command, &capture_.current, &capture_.voltage, &capture_.velocity,
                       &capture_.position})
    column->reserve(capture_size_);
  capture_state_ = CaptureState::armed;
}

std::int64_t SimulatedAmplifier::ticks_to_capture() const {
  if (capture_state_ != CaptureState::busy) return 0;
  const auto left = static_cast<std::int64_t>(capture_size_ - capture_.command.size());
  return capture_next_ + (left - 1) * capture_every_ - now_ + 1;
}

TwinTruth SimulatedAmplifier::truth() {
  return {current_,
          plant_->now().voltage(),
          plant_->now().velocity(),
          plant_->now().position(),
          winding_temperature(),
          plant_->now().stored_energy()};
}

}  // namespace gyrator
