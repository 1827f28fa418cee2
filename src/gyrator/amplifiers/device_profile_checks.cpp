#include "gyrator/amplifiers/device_profile_checks.hpp"

#include "gyrator/core/error.hpp"
#include "gyrator/core/text.hpp"

#include <algorithm>
#include <cmath>
#include <map>

#include <fmt/core.h>

namespace gyrator {
namespace {

[[noreturn]] void refuse(const std::string& where, const std::string& message) {
  throw Error(ErrorCode::bad_input, where, message);
}

bool is_whole_number(RegisterType type) {
  return type != RegisterType::f32 && type != RegisterType::f64;
}

// Near a whole number, as decimal texts give it.
bool is_whole(double number) {
  return std::fabs(number - std::round(number)) <= 1e-6 * std::max(1.0, std::fabs(number));
}

void check_bits(const DeviceRegister& place, const std::string& where) {
  if (!place.bits) return;
  const bool fits_type = place.type == RegisterType::u16 || place.type == RegisterType::u32;
  if (!fits_type) {
    refuse(where + "/bits",
           fmt::format("of the type {}: only u16 and u32 have bit fields", name_of(place.type)));
  }
  const int last = place.bits->first + place.bits->count;
  if (last > 16 * place.words()) {
    refuse(where + "/bits", fmt::format("up to bit {}: {} has {}", last - 1, name_of(place.type),
                                        16 * place.words()));
  }
  if (!place.readable) {
    refuse(where + "/access",
           "a bit field that can only be written: the other bits of its word, which nobody can "
           "read, would be lost");
  }
}

void check_type(const DeviceRegister& place, const std::string& where) {
  if (holds_bits(place.table) && place.type != RegisterType::bit) {
    refuse(where + "/type",
           fmt::format("'{}': the table {} holds bits", name_of(place.type), name_of(place.table)));
  }
  if (place.scale == 0) refuse(where + "/scale", "0: a scale must not be zero");
  if (place.address + place.words() > 65536) {
    refuse(where + "/address", fmt::format("{}: {} words from there end beyond the last address, "
                                           "65535",
                                           place.address, place.words()));
  }
  if (place.writable && !is_writable(place.table))
    refuse(where + "/access", fmt::format("the table {} cannot be written", name_of(place.table)));
  check_bits(place, where);
}

// What the type can hold, without the limits of the register.
ValueRange encodable(DeviceRegister place) {
  place.low.reset();
  place.high.reset();
  return range_of(place);
}

void check_limits(const DeviceRegister& place, const std::string& where) {
  const ValueRange type = encodable(place);
  const auto check_fits = [&](const std::optional<double>& value, const char* key) {
    if (!value) return;
    const double slack = 1e-9 * std::max(std::fabs(type.low), std::fabs(type.high));
    if (*value >= type.low - slack && *value <= type.high + slack) return;
    refuse(where + "/" + key,
           fmt::format("{}: the type {} with this scale holds {} to {}",
                       describe_value(place, *value), name_of(place.type),
                       describe_value(place, type.low), describe_value(place, type.high)));
  };
  check_fits(place.low, "min");
  check_fits(place.high, "max");
  check_fits(place.safe, "safe");
  if (place.low && place.high && *place.low > *place.high) {
    refuse(where + "/min", fmt::format("{}: is above max, {}", describe_value(place, *place.low),
                                       describe_value(place, *place.high)));
  }
  if (!place.safe) return;
  if (!place.writable) refuse(where + "/safe", "the register cannot be written");
  try {
    const double kept = *to_physical(place, to_raw(place, *place.safe));
    const double off = std::fabs(kept - *place.safe);
    if (place.step && off > 1e-6 * *place.step) {
      refuse(where + "/safe",
             fmt::format("{}: is not on the step; the nearest is {}",
                         describe_value(place, *place.safe), describe_value(place, kept)));
    }
  } catch (const Error& error) {
    if (error.place() != place.name) throw;
    refuse(where + "/safe", error.message());
  }
}

void check_step(const DeviceRegister& place, const std::string& where) {
  if (!place.step) return;
  if (!(*place.step > 0)) {
    refuse(where + "/step", fmt::format("{}: must be above 0", describe_value(place, *place.step)));
  }
  const double resolution = std::fabs(place.scale * place.factor);
  if (is_whole_number(place.type) && !is_whole(*place.step / resolution)) {
    refuse(where + "/step",
           fmt::format("{}: must be a multiple of the register's resolution, {}",
                       describe_value(place, *place.step), describe_value(place, resolution)));
  }
  if (!place.low || !is_whole_number(place.type)) return;
  const double raw_low = (*place.low / place.factor - place.offset) / place.scale;
  if (!is_whole(raw_low)) {
    refuse(where + "/min",
           fmt::format("{}: the steps start here, but the register's resolution is "
                       "{}",
                       describe_value(place, *place.low), describe_value(place, resolution)));
  }
}

void check_codes(const DeviceRegister& place, const std::string& where) {
  for (const auto& [name, code] : place.codes) {
    const std::string at = where + "/codes/" + name;
    const ValueRange type = encodable(place);
    const auto value = static_cast<double>(code);
    if (value < type.low || value > type.high)
      refuse(at, fmt::format("{}: the type {} cannot hold it", code, name_of(place.type)));
    for (const auto& [other, same] : place.codes) {
      if (other != name && same == code)
        refuse(at, fmt::format("{}: is the code of {} too", code, other));
    }
  }
  if (!place.codes.empty() && (place.scale != 1 || place.offset != 0 || place.factor != 1))
    refuse(where + "/codes", "a register with codes has no scale, offset or unit");
}

// Bit fields of the same word may stand in it side by side.
bool may_share(const DeviceRegister& a, const DeviceRegister& b) {
  if (!a.bits || !b.bits || a.address != b.address || a.type != b.type || a.order != b.order)
    return false;
  return a.bits->first >= b.bits->first + b.bits->count ||
         b.bits->first >= a.bits->first + a.bits->count;
}

struct Extent {
  RegisterTable table;
  int first, end;
  std::string what, where;
  const DeviceRegister* place;  // none for a window of the capture
};

std::vector<Extent> list_extents(const DeviceProfile& profile) {
  std::vector<Extent> extents;
  for (std::size_t i = 0; i < profile.registers.size(); ++i) {
    const DeviceRegister& place = profile.registers[i];
    extents.push_back({place.table, place.address, place.address + place.words(),
                       "'" + place.name + "'", fmt::format("/registers/{}", i), &place});
  }
  if (!profile.capture) return extents;
  const DeviceCapture& capture = *profile.capture;
  const int samples = capture.page.empty() ? capture.max_samples : capture.page_samples;
  for (const auto& [signal, place] : capture.signals) {
    const std::string where = fmt::format("/capture/signals/{}", name_of(signal));
    const long end = place.address + static_cast<long>(place.words()) * samples;
    if (end > 65536) {
      refuse(fmt::format("{}: {}/address", profile.file, where),
             fmt::format("{}: {} samples of {} words from there end at {}, beyond the last "
                         "address, 65535: show them in pages",
                         place.address, samples, place.words(), end - 1));
    }
    extents.push_back({place.table, place.address, static_cast<int>(end),
                       fmt::format("the window of {}", name_of(signal)), where, nullptr});
  }
  return extents;
}

void check_overlaps(const DeviceProfile& profile) {
  std::vector<Extent> extents = list_extents(profile);
  std::stable_sort(extents.begin(), extents.end(), [](const Extent& a, const Extent& b) {
    return std::pair(a.table, a.first) < std::pair(b.table, b.first);
  });
  for (std::size_t i = 0; i < extents.size(); ++i) {
    for (std::size_t j = i + 1; j < extents.size(); ++j) {
      const Extent& a = extents[i];
      const Extent& b = extents[j];
      if (b.table != a.table || b.first >= a.end) break;
      if (a.place != nullptr && b.place != nullptr && may_share(*a.place, *b.place)) continue;
      refuse(fmt::format("{}: {}/address", profile.file, b.where),
             fmt::format("{}: lies on {}, which takes {} to {}", describe_address(b.table, b.first),
                         a.what, describe_address(a.table, a.first),
                         describe_address(a.table, a.end - 1)));
    }
  }
}

void check_names(const DeviceProfile& profile) {
  std::map<std::string, std::size_t> first;
  for (std::size_t i = 0; i < profile.registers.size(); ++i) {
    const std::string& name = profile.registers[i].name;
    const std::string where = fmt::format("{}: /registers/{}/name", profile.file, i);
    if (name.empty()) refuse(where, "an empty name");
    const auto [known, is_new] = first.emplace(name, i);
    if (!is_new)
      refuse(where, fmt::format("'{}': is the name of /registers/{} too", name, known->second));
  }
}

void check_well_known(const DeviceProfile& profile) {
  for (std::size_t i = 0; i < profile.registers.size(); ++i) {
    const DeviceRegister& place = profile.registers[i];
    if (place.unit.empty()) continue;
    std::vector<std::string> allowed;
    bool fits = false;
    for (const WellKnownName& known : well_known_names()) {
      if (known.name != place.name) continue;
      allowed.emplace_back(known.unit.symbol);
      const Quantity one = parse_quantity("1 " + place.unit);
      try {
        fits = fits || value_in(one, known.unit) == one.value;
      } catch (const Error&) {  // the next meaning of the name, if there is one
      }
    }
    if (allowed.empty() || fits) continue;
    refuse(fmt::format("{}: /registers/{}/unit", profile.file, i),
           fmt::format("'{}': {} is in {} on every device", place.unit, place.name,
                       join(allowed, " or ")));
  }
}

// Written in haste or as time goes by, without a look at the other bits of the word.
void check_whole_words(const DeviceProfile& profile) {
  const auto check = [&](const std::string& name, const char* where) {
    if (!profile.at(name).bits) return;
    refuse(fmt::format("{}: {}", profile.file, where),
           fmt::format("'{}': is a bit field: a whole register is needed", name));
  };
  if (profile.watchdog) check(profile.watchdog->feed.register_name, "/watchdog/register");
  if (profile.clock) check(profile.clock->advance, "/clock/advance");
}

}  // namespace

void check_register(const DeviceRegister& place, const std::string& where) {
  check_type(place, where);
  check_codes(place, where);
  check_step(place, where);
  check_limits(place, where);
}

void check_device_profile(const DeviceProfile& profile) {
  check_names(profile);
  for (std::size_t i = 0; i < profile.registers.size(); ++i)
    check_register(profile.registers[i], fmt::format("{}: /registers/{}", profile.file, i));
  check_well_known(profile);
  check_overlaps(profile);
  check_whole_words(profile);
}

}  // namespace gyrator
