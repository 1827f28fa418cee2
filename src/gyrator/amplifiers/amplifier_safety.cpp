// Time, the watchdog, and the safe state.
#include "gyrator/amplifiers/amplifier_port.hpp"
#include "gyrator/core/error.hpp"
#include "gyrator/core/interrupt.hpp"

#include <algorithm>
#include <cmath>
#include <thread>

#include <fmt/core.h>

namespace gyrator {
namespace {

using std::chrono::steady_clock;

constexpr double look_again = 0.05;    // [s]
constexpr double shortest_nap = 0.02;  // [s], between looks at Ctrl-C

double seconds_since(steady_clock::time_point begin) {
  return std::chrono::duration<double>(steady_clock::now() - begin).count();
}

void sleep_for(double seconds) {
  std::this_thread::sleep_for(std::chrono::duration<double>(seconds));
}

}  // namespace

void AmplifierPort::feed_watchdog() {
  if (!profile_.watchdog || !options_.apply || feeding_) return;
  // A simulated device's time may run with its requests rather than with ours.
  constexpr int requests_between = 8;
  const bool is_due = seconds_since(fed_) > profile_.watchdog->period / 3 ||
                      (profile_.clock && since_fed_ >= requests_between);
  if (!is_due) return;
  const DeviceRegister& place = profile_.at(profile_.watchdog->feed.register_name);
  const Words words = put_raw(place, to_raw(place, profile_.watchdog->feed.value),
                              Words(static_cast<std::size_t>(place.words())));
  feeding_ = true;
  // Feeding twice does no harm: here a write whose answer was lost may go out again.
  constexpr int tries = 3;
  for (int i = 1; i <= tries; ++i) {
    try {
      send_words(place, words);
      break;
    } catch (const LinkError& error) {
      feeding_ = false;
      if (i == tries) throw;
      feeding_ = true;
      if (error.fault() == LinkFault::exception) sleep_for(profile_.link.backoff);
    } catch (...) {
      feeding_ = false;
      throw;
    }
  }
  feeding_ = false;
  fed_ = steady_clock::now();
  since_fed_ = 0;
  ++statistics_.fed;
}

// Whether the device's time has moved.
bool AmplifierPort::advance_clock(double seconds) {
  const DeviceRegister& place = profile_.at(profile_.clock->advance);
  const double before = read_value(profile_.clock->time);
  try {
    send_words(place, put_raw(place, to_raw(place, std::min(seconds, range_of(place).high)),
                              Words(static_cast<std::size_t>(place.words()))));
  } catch (const LinkError& error) {
    if (error.fault() == LinkFault::exception && error.exception() != ModbusException::device_busy)
      return false;
    // Whether it has arrived, the clock tells.
  }
  return read_value(profile_.clock->time) - before >= 0.5 * seconds;
}

void AmplifierPort::wait(double seconds) {
  if (!options_.apply) return;
  // Half a watchdog's period at a time.
  const double longest = profile_.watchdog ? profile_.watchdog->period / 2 : 1.0;
  if (profile_.clock && clock_moves_) {
    const double end = read_value(profile_.clock->time) + seconds;
    for (;;) {
      throw_if_interrupted("waiting for the device");
      const double left = end - read_value(profile_.clock->time);
      if (left <= 1e-9) return;
      feed_watchdog();
      if (!advance_clock(std::min(left, longest))) {
        clock_moves_ = false;  // it lives in real time
        seconds = end - read_value(profile_.clock->time);
        break;
      }
      since_fed_ += 1000;  // due again
    }
  }
  const auto begin = steady_clock::now();
  for (;;) {
    throw_if_interrupted("waiting for the device");
    feed_watchdog();
    const double left = seconds - seconds_since(begin);
    if (left <= 0) return;
    sleep_for(std::min({left, longest, shortest_nap}));
  }
}

// The safe value within --limit, on the register's step.
double AmplifierPort::find_safe_value(const DeviceRegister& place) const {
  const auto given = options_.limits.find(place.name);
  if (given == options_.limits.end() || std::fabs(*place.safe) <= given->second) return *place.safe;
  const double limit = given->second;
  const double nearest = find_nearest_value(place, std::copysign(limit, *place.safe));
  constexpr double slack = 1e-6;  // what the rounding to a 32-bit float may add, and no step
  if (std::fabs(nearest) <= limit * (1 + slack)) return nearest;
  const double step = place.step.value_or(std::fabs(place.scale * place.factor));
  return find_nearest_value(place, nearest - std::copysign(step, nearest));
}

// On the disk before it goes out, like any write; a disk that is full must not keep a device from
// its safe state, and a slow one not a motor from being switched off. What a restore needs is the
// backup, which was there before.
void AmplifierPort::journal_safe_step(const DeviceRegister& place, const Words& before,
                                      const Words& wanted, SafeStep step) noexcept {
  if (journal_ == nullptr) return;
  try {
    if (step == SafeStep::setting) return journal_->intend(place, before, wanted);
    journal_->note({{"write", place.name}, {"new", wanted}, {"safe", true}});
  } catch (const std::exception&) {  // without
  }
}

// Whether the register is as it is to be; LinkError where that could not be done or asked.
bool AmplifierPort::try_safe_step(const DeviceRegister& place, double value, SafeStep step) {
  Words base(static_cast<std::size_t>(place.words()));
  // Of a bit field the neighbours must be known.
  const bool must_look = place.readable && (step == SafeStep::setting || place.bits);
  if (must_look) base = read_from_device(place);
  const Words wanted = put_raw(place, to_raw(place, value), base);
  if (must_look && step == SafeStep::setting) {
    if (wanted == base) return true;
    const std::optional<double> now = take_value(place, base).value;
    if (place.name.ends_with("_limit") && now && *now <= value) return true;  // tighter
  }
  journal_safe_step(place, must_look ? base : Words{}, wanted, step);
  send_words(place, wanted);
  if (step == SafeStep::action || !place.readable) return true;
  sleep_for(place.settle);
  return take_value(place, read_from_device(place)).pattern == take_value(place, wanted).pattern;
}

void AmplifierPort::make_safe_step(const DeviceRegister& place, double value, SafeStep step,
                                   steady_clock::time_point until, SafeResult& result) {
  const auto fail = [&](const std::string& reason) {
    result.failed.push_back(fmt::format("{} = {} ({}): {}", place.name,
                                        describe_value(place, value), place.describe_place(),
                                        reason));
  };
  if (!result.answers && steady_clock::now() >= until)
    return fail("not tried any more: the device does not answer");
  std::string reason;
  constexpr int most_disobedience = 5;  // of a device that answers and does otherwise
  for (int disobeyed = 0; disobeyed < most_disobedience;) {
    try {
      const bool is_done = try_safe_step(place, value, step);
      result.answers = true;
      if (is_done) return;
      reason = "it does not keep what is written to it";
      ++disobeyed;
    } catch (const LinkError& error) {
      reason = error.what();
      const bool is_busy = error.exception() == ModbusException::device_busy ||
                           error.exception() == ModbusException::acknowledge;
      const bool answers =
          error.fault() == LinkFault::exception || error.fault() == LinkFault::garbled;
      if (answers && !is_busy) ++disobeyed;
      result.answers = answers;
      if ((!answers || is_busy) && steady_clock::now() >= until) break;
      sleep_for(look_again);
      if (error.fault() != LinkFault::exception) link_.disconnect();
    } catch (const Error& error) {  // the other registers may still be made safe
      return fail(error.what());
    }
  }
  fail(reason);
}

AmplifierPort::SafeResult AmplifierPort::make_safe() noexcept {
  SafeResult result;
  try {
    if (!options_.apply) return result;
    // The link refuses to work while a Ctrl-C is unheard; this is what it asks for, and another
    // one must not cut it off.
    if (!shield_) shield_.emplace();
    acknowledge_interrupt();
    feeding_ = true;  // a watchdog that bites now is welcome
    const auto until =
        steady_clock::now() + std::chrono::duration_cast<steady_clock::duration>(
                                  std::chrono::duration<double>(options_.safe_patience));
    if (const DeviceRegister* enable = profile_.find("enable"); enable != nullptr)
      make_safe_step(*enable, 0, SafeStep::drive_off, until, result);
    if (profile_.excitation) {
      const DeviceAction& stop = profile_.excitation->stop;
      make_safe_step(profile_.at(stop.register_name), stop.value, SafeStep::action, until, result);
    }
    for (const DeviceRegister& place : profile_.registers) {
      if (!place.safe || !place.writable || place.name == "enable") continue;
      if (place.persistent && !options_.persist) continue;
      make_safe_step(place, find_safe_value(place), SafeStep::setting, until, result);
    }
    feeding_ = false;
  } catch (const std::exception& error) {
    feeding_ = false;
    try {
      result.failed.emplace_back(error.what());
    } catch (...) {  // not even memory for the reason
    }
    result.state = DeviceState::unknown;
  }
  if (!result.failed.empty()) result.state = DeviceState::unknown;
  return result;
}

}  // namespace gyrator
