#include "gyrator/twin/twin_bank.hpp"

#include "gyrator/core/error.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace gyrator {
namespace {

constexpr double tick = SimulatedAmplifier::tick;

// Of the drive_mode register: its codes are the profile's own.
double from_mode(const DeviceRegister& place, double mode) {
  const auto code = find_code(place, name_of(mode == 1 ? DriveMode::voltage : DriveMode::current));
  return code ? static_cast<double>(*code) : mode;
}

// The nearest that a register can hold, limits of what may be written left aside.
RawValue saturate(DeviceRegister place, double value) {
  place.low = place.high = place.step = std::nullopt;
  const ValueRange range = range_of(place);
  return to_raw(place, std::isnan(value) ? 0 : std::clamp(value, range.low, range.high));
}

}  // namespace

TwinBank::TwinBank(SimulatedAmplifier& amplifier, const DeviceProfile& profile,
                   TwinBankOptions options)
    : amplifier_(amplifier),
      profile_(profile),
      options_(std::move(options)),
      began_(std::chrono::steady_clock::now()) {
  if (!options_.stuck.empty()) (void)profile_.at(options_.stuck);
  for (const DeviceRegister& place : profile_.registers) {
    double value = find_nearest_value(
        place, place.codes.empty() ? 0 : static_cast<double>(place.codes[0].second));
    for (const DeviceAction& known : profile_.identity)
      if (known.register_name == place.name) value = known.value;
    memory_.push_back(saturate(place, value));
    if (!SimulatedAmplifier::has_setting(place.name) || place.name == "drive_mode") continue;
    amplifier_.write(place.name, find_nearest_value(place, amplifier_.read(place.name)));
  }
  if (profile_.watchdog && options_.pace)
    amplifier_.write("watchdog_period", profile_.watchdog->period * *options_.pace);
  // What can be read: registers, captures, and small holes between registers.
  for (const RegisterTable table : {RegisterTable::coil, RegisterTable::discrete,
                                    RegisterTable::input, RegisterTable::holding}) {
    std::vector<bool> readable(65536, false);
    const auto mark = [&](int from, int words) {
      std::fill_n(readable.begin() + from, std::min(words, 65536 - from), true);
    };
    for (const DeviceRegister& place : profile_.registers)
      if (place.table == table && place.readable) mark(place.address, place.words());
    if (profile_.capture) {
      const int samples = profile_.capture->page.empty() ? profile_.capture->max_samples
                                                         : profile_.capture->page_samples;
      for (const auto& [signal, place] : profile_.capture->signals)
        if (place.table == table) mark(place.address, place.words() * samples);
    }
    for (int address = 0, last = -1; address < 65536; ++address) {
      if (!readable[static_cast<std::size_t>(address)]) continue;
      const int hole = address - last - 1;
      if (last >= 0 && hole > 0 && hole <= profile_.link.max_hole) mark(last + 1, hole);
      last = address;
    }
    readable_[table] = std::move(readable);
  }
}

void TwinBank::keep_pace() {
  if (!options_.pace) return;
  const std::chrono::duration<double> wall = std::chrono::steady_clock::now() - began_;
  const std::int64_t due = static_cast<std::int64_t>(wall.count() * *options_.pace / tick);
  // Beside what the clock's register has skipped.
  if (due <= paced_) return;
  amplifier_.advance_ticks(due - paced_);
  paced_ = due;
}

void TwinBank::pass(double seconds) {
  if (options_.pace || !(seconds > 0)) return;
  passed_ += seconds;
  const auto ticks = static_cast<std::int64_t>(passed_ / tick);
  passed_ -= static_cast<double>(ticks) * tick;
  amplifier_.advance_ticks(ticks, false);
}

double TwinBank::memory_of(const std::string& name, double otherwise) const {
  for (std::size_t i = 0; i < profile_.registers.size(); ++i)
    if (profile_.registers[i].name == name && !name.empty())
      return to_physical(profile_.registers[i], memory_[i]).value_or(otherwise);
  return otherwise;
}

double TwinBank::fault_bits() const {
  const unsigned faults = amplifier_.faults();
  if (!profile_.fault || profile_.fault->bits.empty()) return faults;
  std::uint64_t bits = 0;
  for (int k = 0; k < twin_fault_count; ++k) {
    if ((faults >> k & 1U) == 0) continue;
    // A fault that the profile has no bit for must not go unseen.
    int bit = profile_.fault->bits.front().first;
    for (const auto& [number, name] : profile_.fault->bits)
      if (name == name_of(static_cast<TwinFault>(k))) bit = number;
    bits |= std::uint64_t{1} << bit;
  }
  return static_cast<double>(bits);
}

double TwinBank::capture_code(const DeviceRegister& place) const {
  const CaptureState state = amplifier_.capture_state();
  const auto first_of = [&](std::initializer_list<const char*> names, double otherwise) {
    for (const char* name : names)
      if (const auto code = find_code(place, name)) return static_cast<double>(*code);
    return otherwise;
  };
  switch (state) {
    case CaptureState::idle:
      return first_of({"idle", "ready"}, 0);
    case CaptureState::armed:
      return first_of({"armed", "idle", "ready"}, 1);
    case CaptureState::busy:
      return first_of({"busy", "running", "armed"}, 2);
    case CaptureState::done:
      break;
  }
  return first_of({"done"}, 3);
}

bool TwinBank::is(const std::optional<DeviceAction>& action, const DeviceRegister& place,
                  double value) const {
  return action && action->register_name == place.name && action->value == value;
}

// Of a register that shows something of the amplifier; none for plain memory.
std::optional<double> TwinBank::value_of(const DeviceRegister& place) {
  if (place.name == "drive_mode") return from_mode(place, amplifier_.read(place.name));
  if (profile_.fault && place.name == profile_.fault->register_name) return fault_bits();
  if (place.name == "watchdog") return std::nullopt;
  if (SimulatedAmplifier::has_setting(place.name) || SimulatedAmplifier::has_actual(place.name))
    return amplifier_.read(place.name);
  if (profile_.clock && place.name == profile_.clock->time) return amplifier_.time();
  if (profile_.capture && place.name == profile_.capture->state) return capture_code(place);
  if (profile_.excitation && place.name == profile_.excitation->start.register_name) {
    if (amplifier_.is_exciting()) return profile_.excitation->start.value;
    const auto& stop = profile_.excitation->stop;
    return stop.register_name == place.name ? stop.value : 0;
  }
  return std::nullopt;
}

RawValue TwinBank::raw_of(std::size_t index) {
  const DeviceRegister& place = profile_.registers[index];
  const auto value = value_of(place);
  return value ? saturate(place, *value) : memory_[index];
}

bool TwinBank::is_readable(RegisterTable table, int address, int count) const {
  const auto from = readable_.at(table).begin() + address;
  return std::all_of(from, from + count, [](bool is) { return is; });
}

std::optional<ModbusException> TwinBank::read_words(RegisterTable table, int address, int count,
                                                    Words& to) {
  keep_pace();
  if (count > profile_.link.max_read && !holds_bits(table))
    return ModbusException::illegal_data_value;
  if (!is_readable(table, address, count)) return ModbusException::illegal_data_address;
  if (!options_.pace && profile_.capture) {
    const DeviceRegister& state = profile_.at(profile_.capture->state);
    if (overlaps(state, table, address, count))
      amplifier_.advance_ticks(amplifier_.ticks_to_capture(), false);
  }
  to.assign(static_cast<std::size_t>(count), 0);
  for (std::size_t i = 0; i < profile_.registers.size(); ++i) {
    const DeviceRegister& place = profile_.registers[i];
    if (!place.readable || !overlaps(place, table, address, count)) continue;
    // Fields of one word come one after another: each into what stands there.
    Words words(static_cast<std::size_t>(place.words()), 0);
    const auto index_of = [&](int w) { return place.address + w - address; };
    for (int w = 0; w < place.words(); ++w)
      if (index_of(w) >= 0 && index_of(w) < count)
        words[static_cast<std::size_t>(w)] = to[static_cast<std::size_t>(index_of(w))];
    words = put_raw(place, raw_of(i), words);
    for (int w = 0; w < place.words(); ++w)
      if (index_of(w) >= 0 && index_of(w) < count)
        to[static_cast<std::size_t>(index_of(w))] = words[static_cast<std::size_t>(w)];
  }
  put_capture(table, address, to);
  return std::nullopt;
}

void TwinBank::put_capture(RegisterTable table, int address, Words& words) {
  if (!profile_.capture) return;
  const DeviceCapture& capture = *profile_.capture;
  const bool paged = !capture.page.empty();
  const int shown = paged ? capture.page_samples : capture.max_samples;
  const auto first = static_cast<std::size_t>(
      paged ? std::llround(memory_of(capture.page, 0)) * capture.page_samples : 0);
  const Capture& held = amplifier_.capture();
  for (const auto& [signal, place] : capture.signals) {
    const int size = place.words();
    if (place.table != table) continue;
    const auto* column = &held.command;
    if (signal == CaptureSignal::current) column = &held.current;
    if (signal == CaptureSignal::voltage) column = &held.voltage;
    if (signal == CaptureSignal::velocity) column = &held.velocity;
    if (signal == CaptureSignal::position) column = &held.position;
    for (std::size_t k = 0; k < words.size(); ++k) {
      const int at = address + static_cast<int>(k) - place.address;
      if (at < 0 || at >= shown * size) continue;
      const std::size_t sample = first + static_cast<std::size_t>(at / size);
      if (sample >= column->size()) continue;
      words[k] =
          put_raw(place, saturate(place, (*column)[sample]))[static_cast<std::size_t>(at % size)];
    }
  }
}

RegisterBank::Answer<std::vector<bool>> TwinBank::read_bits(RegisterTable table, int address,
                                                            int count) {
  Words words;
  if (const auto refusal = read_words(table, address, count, words)) return *refusal;
  return std::vector<bool>(words.begin(), words.end());
}

RegisterBank::Answer<std::vector<std::uint16_t>> TwinBank::read_registers(RegisterTable table,
                                                                          int address, int count) {
  Words words;
  if (const auto refusal = read_words(table, address, count, words)) return *refusal;
  return words;
}

}  // namespace gyrator
