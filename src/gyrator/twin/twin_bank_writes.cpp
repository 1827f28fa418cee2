// What a write to a twin's registers does.

#include "gyrator/core/error.hpp"
#include "gyrator/twin/twin_bank.hpp"

#include <algorithm>
#include <cmath>

namespace gyrator {
namespace {

// Of the drive_mode register: its codes are the profile's own.
double to_mode(const DeviceRegister& place, double value) {
  return find_code_name(place, value) == name_of(DriveMode::voltage) ? 1 : 0;
}

// Whether the value may be written: within the limits and on the step, to the type's rounding.
bool is_allowed(const DeviceRegister& place, const RawValue& raw) {
  const auto value = to_physical(place, raw);
  if (!value || !std::isfinite(*value)) return false;
  try {
    const auto nearest = to_physical(place, to_raw(place, *value));
    const double rounding = place.type == RegisterType::f32 ? 4e-7 : 1e-9;
    const double size = std::max(std::abs(*value), place.step.value_or(0));
    return std::abs(*nearest - *value) <= rounding * size;
  } catch (const Error&) {
    return false;
  }
}

double on_tick(double seconds) {
  return std::round(seconds * SimulatedAmplifier::ticks_per_second) /
         SimulatedAmplifier::ticks_per_second;
}

ExcitationKind to_kind(const DeviceRegister& place, double value) {
  const auto name = find_code_name(place, value);
  for (const ExcitationKind kind : {ExcitationKind::dc, ExcitationKind::step, ExcitationKind::sine,
                                    ExcitationKind::chirp, ExcitationKind::prbs})
    if (name == name_of(kind)) return kind;
  throw Error(ErrorCode::bad_input, place.name, "no kind of excitation that the twin has");
}

ModbusException to_exception(const Error& error) {
  return error.code() == ErrorCode::device ? ModbusException::device_failure
                                           : ModbusException::illegal_data_value;
}

}  // namespace

void TwinBank::start() {
  const DeviceExcitation& names = *profile_.excitation;
  Excitation excitation;
  excitation.mode = amplifier_.settings().drive_mode;
  excitation.kind = to_kind(profile_.at(names.kind), memory_of(names.kind, 0));
  excitation.amplitude = memory_of(names.amplitude, 0);
  excitation.offset = memory_of(names.offset, 0);
  excitation.frequency_hz = memory_of(names.frequency, 0);
  excitation.end_frequency_hz = memory_of(names.end_frequency, 0);
  excitation.duration = on_tick(memory_of(names.duration, 0));
  amplifier_.start(excitation);
}

void TwinBank::arm() {
  const DeviceCapture& names = *profile_.capture;
  CaptureRequest request;
  request.start = on_tick(memory_of(names.delay, 0));
  request.period = on_tick(memory_of(names.decimation, 1) * names.period);
  request.samples = static_cast<int>(memory_of(names.samples, names.max_samples));
  amplifier_.arm(request);
}

// What more a register does than to hold a value.
void TwinBank::act(const DeviceRegister& place, double value) {
  if (profile_.fault && is(profile_.fault->clear, place, value)) amplifier_.clear_faults();
  if (profile_.watchdog && is(profile_.watchdog->feed, place, value)) amplifier_.feed_watchdog();
  if (profile_.persist && is(profile_.persist->action, place, value)) ++persist_count_;
  if (profile_.clock && place.name == profile_.clock->advance) amplifier_.advance(value, false);
  if (profile_.excitation) {
    if (is(profile_.excitation->stop, place, value)) amplifier_.stop();
    if (is(profile_.excitation->start, place, value)) start();
  }
  if (profile_.capture && is(profile_.capture->arm, place, value)) arm();
}

std::optional<ModbusException> TwinBank::find_changes(RegisterTable table, int address,
                                                      std::span<const std::uint16_t> words,
                                                      std::vector<Change>& changes) {
  const auto count = static_cast<int>(words.size());
  std::vector<bool> taken(words.size(), false);
  bool is_part = false;
  for (std::size_t i = 0; i < profile_.registers.size(); ++i) {
    const DeviceRegister& place = profile_.registers[i];
    if (!place.writable || !overlaps(place, table, address, count)) continue;
    const int from = place.address - address;
    const int to = from + place.words();
    for (int w = std::max(from, 0); w < std::min(to, count); ++w)
      taken[static_cast<std::size_t>(w)] = true;
    if (from < 0 || to > count) {
      is_part = true;  // a number is written whole, in one request
      continue;
    }
    const RawValue raw = take_raw(place, words.subspan(static_cast<std::size_t>(from),
                                                       static_cast<std::size_t>(place.words())));
    if (place.bits && raw == raw_of(i)) continue;  // its neighbours in the word were meant
    changes.push_back({i, raw, to_physical(place, raw).value_or(std::nan(""))});
  }
  if (!std::all_of(taken.begin(), taken.end(), [](bool is) { return is; }))
    return ModbusException::illegal_data_address;
  if (is_part) return ModbusException::illegal_data_value;
  for (const Change& change : changes)
    if (!is_allowed(profile_.registers[change.index], change.raw))
      return ModbusException::illegal_data_value;
  return std::nullopt;
}

std::optional<ModbusException> TwinBank::apply(const std::vector<Change>& changes) {
  const std::vector<RawValue> memory = memory_;
  std::vector<std::pair<std::string, double>> done;  // settings as they were
  try {
    for (const Change& change : changes) {
      const DeviceRegister& place = profile_.registers[change.index];
      ++write_counts_[place.name];
      if (place.name == options_.stuck) continue;
      if (SimulatedAmplifier::has_setting(place.name)) {
        const double before = amplifier_.read(place.name);
        const double value =
            place.name == "drive_mode" ? to_mode(place, change.value) : change.value;
        amplifier_.write(place.name, value);
        done.emplace_back(place.name, before);
      }
      memory_[change.index] = change.raw;
    }
    for (const Change& change : changes) {
      const DeviceRegister& place = profile_.registers[change.index];
      if (place.name != options_.stuck) act(place, change.value);
    }
  } catch (const Error& error) {
    memory_ = memory;
    for (auto undo = done.rbegin(); undo != done.rend(); ++undo)
      amplifier_.write(undo->first, undo->second);
    return to_exception(error);
  }
  return std::nullopt;
}

std::optional<ModbusException> TwinBank::write_words(RegisterTable table, int address,
                                                     std::span<const std::uint16_t> words) {
  keep_pace();
  if (!holds_bits(table) && static_cast<int>(words.size()) > profile_.link.max_write)
    return ModbusException::illegal_data_value;
  std::vector<Change> changes;
  if (const auto refusal = find_changes(table, address, words, changes)) return refusal;
  return apply(changes);
}

std::optional<ModbusException> TwinBank::write_coils(int address, const std::vector<bool>& values) {
  const Words words(values.begin(), values.end());
  return write_words(RegisterTable::coil, address, words);
}

std::optional<ModbusException> TwinBank::write_registers(int address,
                                                         std::span<const std::uint16_t> words) {
  return write_words(RegisterTable::holding, address, words);
}

}  // namespace gyrator
