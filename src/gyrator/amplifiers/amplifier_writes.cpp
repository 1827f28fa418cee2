// Writing: what is allowed, what is known of a write whose answer was lost, and the read-back.
#include "gyrator/amplifiers/amplifier_port.hpp"
#include "gyrator/core/error.hpp"

#include <cmath>
#include <thread>

#include <fmt/core.h>
#include <fmt/ranges.h>

namespace gyrator {
namespace {

using std::chrono::steady_clock;

constexpr int most_sends = 3;         // of one write that is known not to have arrived
constexpr int most_looks = 3;         // at a register that should have settled
constexpr double look_again = 0.005;  // [s]

void sleep_for(double seconds) {
  std::this_thread::sleep_for(std::chrono::duration<double>(seconds));
}

[[noreturn]] void refuse(const DeviceRegister& place, const std::string& message) {
  throw Error(ErrorCode::device, fmt::format("{} ({})", place.name, place.describe_place()),
              "refused: " + message);
}

std::string describe_content(const DeviceRegister& place, const SettingValue& content) {
  return content.value ? describe_value(place, *content.value) : "no value";
}

}  // namespace

void AmplifierPort::check_access(const DeviceRegister& place) const {
  if (!place.writable) refuse(place, "can only be read, by the profile");
  if (place.persistent && !options_.persist) {
    refuse(place, fmt::format("it is in persistent memory{}{}: --persist allows it",
                              place.write_cost.empty() ? "" : ", ", place.write_cost));
  }
}

RawValue AmplifierPort::check_value(const DeviceRegister& place, double value) const {
  const auto limit = options_.limits.find(place.name);
  if (limit != options_.limits.end() && std::fabs(value) > limit->second * (1 + 1e-9)) {
    refuse(place, fmt::format("{}: --limit allows at most {}", describe_value(place, value),
                              describe_value(place, limit->second)));
  }
  try {
    return to_raw(place, value);
  } catch (const Error& error) {
    refuse(place, error.message());
  }
}

void AmplifierPort::write(std::string_view name, double value) {
  const DeviceRegister& place = profile_.at(name);
  check_access(place);
  write_raw(place, check_value(place, value));
}

void AmplifierPort::write_content(const SettingValue& content, bool was_there) {
  const DeviceRegister& place = profile_.at(content.name);
  check_access(place);
  if (was_there) return write_raw(place, take_raw(place, content.words));
  if (content.value) {
    // What the device had may lie off the step, but never beyond the limits.
    DeviceRegister without_step = place;
    without_step.step.reset();
    check_value(without_step, *content.value);
  } else if (!place.readable || take_value(place, read_words(place)).pattern != content.pattern) {
    // No limit holds what stands for no value, such as a float that is no number.
    refuse(place, fmt::format("0x{:04X} stands for no value, and the register has one",
                              fmt::join(content.words, " 0x")));
  }
  write_raw(place, take_raw(place, content.words));
}

void AmplifierPort::write_raw(const DeviceRegister& place, const RawValue& raw) {
  const Words before = place.readable ? read_words(place) : Words{};
  Words base = before;
  if (base.empty()) base.resize(static_cast<std::size_t>(place.words()));
  const Words after = put_raw(place, raw, base);
  if (after == before) {
    ++statistics_.skipped;
    return;
  }
  if (!options_.apply) {
    SettingChange change{&place, {}, take_value(place, after)};
    if (!before.empty()) change.before = take_value(place, before);
    plan_.push_back(std::move(change));
    planned_[{place.table, place.address}] = after;
    return;
  }
  if (journal_ != nullptr) journal_->intend(place, before, after);
  send_until_known(place, before, after, place.readable);
  ++statistics_.written;
  if (place.readable) verify(place, after);
  if (journal_ != nullptr) journal_->note({{"done", place.name}});
}

void AmplifierPort::send_words(const DeviceRegister& place, const Words& words) {
  feed_watchdog();
  ++since_fed_;
  if (holds_bits(place.table)) {
    link_.write_coil(place.address, words.front() != 0);
  } else {
    link_.write_registers(place.address, words);
  }
}

void AmplifierPort::reconnect_patiently(steady_clock::time_point until) {
  for (;;) {
    try {
      link_.reconnect();
      return;
    } catch (const LinkError&) {
      if (steady_clock::now() >= until) throw;
      sleep_for(0.05);
    }
  }
}

// After this the write has arrived, or an error tells that it has not or that nobody knows.
void AmplifierPort::send_until_known(const DeviceRegister& place, const Words& before,
                                     const Words& after, bool can_look, bool repeatable) {
  const auto until =
      steady_clock::now() + std::chrono::duration_cast<steady_clock::duration>(
                                std::chrono::duration<double>(options_.safe_patience));
  for (int sent = 1;; ++sent) {
    try {
      return send_words(place, after);
    } catch (const LinkError& error) {
      // "Acknowledge": it is being done, and takes its time.
      if (error.exception() == ModbusException::acknowledge) return;
      const bool is_busy = error.exception() == ModbusException::device_busy;
      const bool is_refused = error.fault() == LinkFault::exception && !is_busy;
      if (is_refused || sent >= most_sends) throw;
      const bool never_left = error.fault() == LinkFault::refused || is_busy;
      if (!never_left && !can_look && !repeatable) {
        throw LinkError(error.fault(), error.place(),
                        error.message() + ": whether the write of " + place.name +
                            " has arrived is unknown, and reading does not tell",
                        error.exception());
      }
      if (error.fault() != LinkFault::exception) reconnect_patiently(until);
      if (is_busy) sleep_for(profile_.link.backoff);
      if (never_left || !can_look) continue;
      // Until the register tells, nobody knows whether it has arrived.
      sleep_for(place.settle);
      const Words now = read_from_device(place);
      if (now == after) {
        ++statistics_.recovered;
        return;
      }
      if (now != before) verify(place, after);  // says what it has become
      ++statistics_.repeated;
    }
  }
}

void AmplifierPort::verify(const DeviceRegister& place, const Words& wanted) {
  if (place.settle > 0) sleep_for(place.settle);
  const SettingValue asked = take_value(place, wanted);
  SettingValue found;
  for (int look = 1; look <= most_looks; ++look) {
    found = take_value(place, read_from_device(place));
    if (found.pattern == asked.pattern) return;
    sleep_for(look_again);
  }
  throw Error(ErrorCode::device, fmt::format("{} ({})", place.name, place.describe_place()),
              fmt::format("wrote {}, reads {}: the register does not keep what is written to it",
                          describe_content(place, asked), describe_content(place, found)));
}

void AmplifierPort::perform(const DeviceAction& action, bool repeatable) {
  const DeviceRegister& place = profile_.at(action.register_name);
  check_access(place);
  Words base(static_cast<std::size_t>(place.words()));
  if (place.bits && place.readable) base = read_words(place);
  const Words after = put_raw(place, check_value(place, action.value), base);
  if (!options_.apply) return;
  if (journal_ != nullptr) journal_->intend(place, {}, after);
  send_until_known(place, {}, after, false, repeatable);
  ++statistics_.written;
  if (journal_ != nullptr) journal_->note({{"done", place.name}});
}

void AmplifierPort::keep_settings() {
  if (!profile_.persist)
    throw Error(ErrorCode::bad_input, profile_.name, "its profile knows no way to keep settings");
  if (!options_.persist) {
    throw Error(ErrorCode::device, profile_.persist->action.register_name,
                "refused: keeping settings over a power cycle needs --persist");
  }
  perform(profile_.persist->action);
}

}  // namespace gyrator
