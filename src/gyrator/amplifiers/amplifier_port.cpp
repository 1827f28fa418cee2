// Reading, and what is asked of the device before and after; writes are in amplifier_writes.cpp,
// time and safety in amplifier_safety.cpp.
#include "gyrator/amplifiers/amplifier_port.hpp"

#include "gyrator/amplifiers/register_blocks.hpp"
#include "gyrator/core/error.hpp"
#include "gyrator/core/text.hpp"

#include <algorithm>
#include <cmath>

#include <fmt/core.h>

namespace gyrator {
namespace {

// A device that refuses an address answers so; all else is the link's trouble.
bool is_refusal(const LinkError& error) {
  return error.fault() == LinkFault::exception &&
         error.exception() != ModbusException::device_busy &&
         error.exception() != ModbusException::acknowledge;
}

std::vector<std::uint16_t> as_words(const std::vector<bool>& bits) {
  return {bits.begin(), bits.end()};
}

}  // namespace

AmplifierPort::AmplifierPort(const DeviceProfile& profile, ModbusLink& link, PortOptions options,
                             SettingsJournal* journal)
    : profile_(profile), link_(link), options_(std::move(options)), journal_(journal) {
  for (const auto& [name, limit] : options_.limits) {
    const DeviceRegister& place = profile_.at(name);
    const ValueRange range = range_of(place);
    const bool is_possible = limit >= 0 && limit >= range.low;
    if (!is_possible) {
      throw Error(ErrorCode::bad_input, "--limit",
                  fmt::format("{} of {}: must be at least {}", name, describe_value(place, limit),
                              describe_value(place, std::max(range.low, 0.0))));
    }
  }
}

void AmplifierPort::check_identity() {
  for (const DeviceAction& wanted : profile_.identity) {
    const DeviceRegister& place = profile_.at(wanted.register_name);
    const std::optional<double> found = read(place.name);
    if (found && *found == wanted.value) continue;
    throw Error(ErrorCode::device, describe(link_.address()),
                fmt::format("{} ({}) reads {}: a {} has {} there: another device, another unit or "
                            "another profile",
                            place.name, place.describe_place(),
                            found ? describe_value(place, *found) : "no value", profile_.name,
                            describe_value(place, wanted.value)));
  }
}

AmplifierPort::Words AmplifierPort::read_from_device(const DeviceRegister& place) {
  feed_watchdog();
  ++since_fed_;
  if (holds_bits(place.table)) return as_words(link_.read_bits(place.table, place.address, 1));
  return link_.read_registers(place.table, place.address, place.words());
}

AmplifierPort::Words AmplifierPort::read_words(const DeviceRegister& place) {
  if (!place.readable)
    throw Error(ErrorCode::bad_input, place.name, "can only be written, by its access");
  const auto planned = planned_.find({place.table, place.address});
  return planned != planned_.end() ? planned->second : read_from_device(place);
}

std::optional<double> AmplifierPort::read(std::string_view name) {
  const DeviceRegister& place = profile_.at(name);
  return to_physical(place, take_raw(place, read_words(place)));
}

double AmplifierPort::read_value(std::string_view name) {
  const std::optional<double> value = read(name);
  if (value) return *value;
  throw Error(ErrorCode::device, std::string(name), "the device says that it has no such value");
}

// Blocks first; where the device refuses one, its registers one by one.
std::vector<std::optional<SettingValue>> AmplifierPort::read_places(
    const std::vector<const DeviceRegister*>& places, std::vector<std::string>& refused) {
  std::map<const DeviceRegister*, SettingValue> found;
  for (const RegisterBlock& block :
       plan_blocks(places, profile_.link.max_read, profile_.link.max_hole)) {
    Words words;
    try {
      feed_watchdog();
      ++since_fed_;
      words = holds_bits(block.table)
                  ? as_words(link_.read_bits(block.table, block.address, block.count))
                  : link_.read_registers(block.table, block.address, block.count);
    } catch (const LinkError& error) {
      if (!is_refusal(error)) throw;
      for (const DeviceRegister* place : block.places) {
        try {
          found.emplace(place, take_value(*place, read_from_device(*place)));
        } catch (const LinkError& single) {
          if (!is_refusal(single)) throw;
          refused.push_back(fmt::format("{} ({}): {}", place->name, place->describe_place(),
                                        describe(*single.exception())));
        }
      }
      continue;
    }
    for (const DeviceRegister* place : block.places) {
      const auto first = words.begin() + (place->address - block.address);
      found.emplace(place, take_value(*place, {first, first + place->words()}));
    }
  }
  std::vector<std::optional<SettingValue>> values;
  for (const DeviceRegister* place : places) {
    const auto value = found.find(place);
    values.push_back(value != found.end() ? std::optional(value->second) : std::nullopt);
  }
  return values;
}

SettingsBackup AmplifierPort::read_settings() {
  std::vector<const DeviceRegister*> places;
  for (const DeviceRegister& place : profile_.registers)
    if (place.is_setting) places.push_back(&place);
  SettingsBackup backup{profile_.name, profile_.digest, {}, describe_time_now(), {}, {}};
  backup.device = describe_device(link_.address(), link_.options().unit);
  for (auto& value : read_places(places, backup.unreadable))
    if (value) backup.settings.push_back(std::move(*value));
  return backup;
}

std::map<std::string, std::optional<double>> AmplifierPort::read_several(
    const std::vector<std::string>& names) {
  std::vector<const DeviceRegister*> places;
  for (const std::string& name : names) places.push_back(&profile_.at(name));
  std::vector<std::string> refused;
  const auto values = read_places(places, refused);
  std::map<std::string, std::optional<double>> by_name;
  for (std::size_t i = 0; i < names.size(); ++i)
    by_name[names[i]] = values[i] ? values[i]->value : std::nullopt;
  return by_name;
}

std::vector<double> AmplifierPort::read_window(const DeviceRegister& first, int samples) {
  const int words = first.words();
  const int part = std::max(1, profile_.link.max_read / words);  // whole numbers in each request
  std::vector<double> values;
  values.reserve(static_cast<std::size_t>(samples));
  for (int done = 0; done < samples; done += part) {
    const int count = std::min(part, samples - done);
    feed_watchdog();
    ++since_fed_;
    const Words read =
        link_.read_registers(first.table, first.address + done * words, count * words);
    for (int i = 0; i < count; ++i) {
      const std::span<const std::uint16_t> number(read.data() + i * words,
                                                  static_cast<std::size_t>(words));
      values.push_back(to_physical(first, take_raw(first, number)).value_or(NAN));
    }
  }
  return values;
}

std::vector<std::string> AmplifierPort::read_faults() {
  if (!profile_.fault) return {};
  const DeviceRegister& place = profile_.at(profile_.fault->register_name);
  const std::uint64_t pattern = take_value(place, read_from_device(place)).pattern;
  std::vector<std::string> faults;
  std::uint64_t known = 0;
  for (const auto& [bit, meaning] : profile_.fault->bits) {
    known |= std::uint64_t{1} << bit;
    if ((pattern >> bit & 1U) != 0) faults.push_back(meaning);
  }
  if ((pattern & ~known) != 0)
    faults.push_back(fmt::format("unknown fault bits 0x{:x}", pattern & ~known));
  return faults;
}

void AmplifierPort::clear_fault() {
  if (profile_.fault && profile_.fault->clear) perform(*profile_.fault->clear, true);
}

double AmplifierPort::upper_limit(std::string_view name) const {
  const double by_profile = range_of(profile_.at(name)).high;
  const auto given = options_.limits.find(std::string(name));
  return given == options_.limits.end() ? by_profile : std::min(by_profile, given->second);
}

}  // namespace gyrator
