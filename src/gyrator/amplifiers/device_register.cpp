#include "gyrator/amplifiers/device_register.hpp"

#include "gyrator/core/error.hpp"
#include "gyrator/core/text.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include <fmt/core.h>

namespace gyrator {
namespace {

bool is_float(RegisterType type) {
  return type == RegisterType::f32 || type == RegisterType::f64;
}

bool is_signed(RegisterType type) {
  return type == RegisterType::i16 || type == RegisterType::i32;
}

// What the words can hold; a double tells whole numbers apart up to 2^53.
ValueRange raw_range(const DeviceRegister& place) {
  if (place.bits) return {0, std::ldexp(1.0, place.bits->count) - 1};
  constexpr double most_whole = 9007199254740992.0;
  switch (place.type) {
    case RegisterType::bit:
      return {0, 1};
    case RegisterType::u16:
      return {0, 65535};
    case RegisterType::i16:
      return {-32768, 32767};
    case RegisterType::u32:
      return {0, 4294967295.0};
    case RegisterType::i32:
      return {-2147483648.0, 2147483647};
    case RegisterType::u64:
      return {0, most_whole};
    case RegisterType::f32: {
      constexpr double most = std::numeric_limits<float>::max();
      return {-most, most};
    }
    case RegisterType::f64:
      break;
  }
  constexpr double most = std::numeric_limits<double>::max();
  return {-most, most};
}

double from_raw(const DeviceRegister& place, double raw) {
  return (raw * place.scale + place.offset) * place.factor;
}

// A value that was read back may lie beyond a limit by its own rounding.
double rounding_of(const DeviceRegister& place, double limit) {
  return (place.type == RegisterType::f32 ? 2e-7 : 1e-9) * std::fabs(limit);
}

[[noreturn]] void refuse(const DeviceRegister& place, const std::string& message) {
  throw Error(ErrorCode::bad_input, place.name, message);
}

double on_step(const DeviceRegister& place, double value) {
  if (!place.step) return value;
  const double origin = place.low.value_or(0);
  double steps = std::round((value - origin) / *place.step);
  if (place.high)
    steps = std::min(steps, std::floor((*place.high - origin) / *place.step * (1 + 1e-12) + 1e-9));
  return origin + steps * *place.step;
}

void check_code(const DeviceRegister& place, double value) {
  if (place.codes.empty() || find_code_name(place, value)) return;
  std::vector<std::string> known;
  for (const auto& [name, code] : place.codes) known.push_back(fmt::format("{} ({})", code, name));
  refuse(place, fmt::format("{:.9g}: no code of it: allowed: {}", value, join(known)));
}

}  // namespace

bool overlaps(const DeviceRegister& place, RegisterTable table, int address, int count) {
  return place.table == table && place.address < address + count &&
         address < place.address + place.words();
}

std::optional<double> to_physical(const DeviceRegister& place, const RawValue& raw) {
  if (place.not_implemented && to_double(raw) == to_double(*place.not_implemented)) return {};
  const double number = to_double(raw);
  if (std::isnan(number)) return {};
  return from_raw(place, number);
}

ValueRange range_of(const DeviceRegister& place) {
  const ValueRange raw = raw_range(place);
  const double a = from_raw(place, raw.low);
  const double b = from_raw(place, raw.high);
  return {std::max(std::min(a, b), place.low.value_or(-HUGE_VAL)),
          std::min(std::max(a, b), place.high.value_or(HUGE_VAL))};
}

RawValue to_raw(const DeviceRegister& place, double value) {
  if (!std::isfinite(value)) refuse(place, format_number(value) + ": a finite number is expected");
  const ValueRange range = range_of(place);
  if (value < range.low - rounding_of(place, range.low)) {
    refuse(place, fmt::format("{}: must be at least {}", describe_value(place, value),
                              describe_value(place, range.low)));
  }
  if (value > range.high + rounding_of(place, range.high)) {
    refuse(place, fmt::format("{}: must be at most {}", describe_value(place, value),
                              describe_value(place, range.high)));
  }
  check_code(place, value);
  const double wanted = on_step(place, std::clamp(value, range.low, range.high));
  const double number = (wanted / place.factor - place.offset) / place.scale;
  const ValueRange raw = raw_range(place);
  RawValue answer;
  if (is_float(place.type)) {
    answer =
        place.type == RegisterType::f32 ? static_cast<double>(static_cast<float>(number)) : number;
  } else if (is_signed(place.type)) {
    answer = static_cast<std::int64_t>(std::clamp(std::round(number), raw.low, raw.high));
  } else {
    answer = static_cast<std::uint64_t>(std::clamp(std::round(number), raw.low, raw.high));
  }
  if (!to_physical(place, answer)) {
    refuse(place, fmt::format("{}: the device takes it for \"not implemented\"",
                              describe_value(place, value)));
  }
  return answer;
}

double find_nearest_value(const DeviceRegister& place, double value) {
  const ValueRange range = range_of(place);
  return *to_physical(place, to_raw(place, std::clamp(value, range.low, range.high)));
}

RawValue take_raw(const DeviceRegister& place, std::span<const std::uint16_t> words) {
  const RawValue whole = decode_value(words, place.type, place.order);
  if (!place.bits) return whole;
  const std::uint64_t mask = (std::uint64_t{1} << place.bits->count) - 1;
  return (std::get<std::uint64_t>(whole) >> place.bits->first) & mask;
}

std::vector<std::uint16_t> put_raw(const DeviceRegister& place, const RawValue& raw,
                                   std::span<const std::uint16_t> words) {
  if (!place.bits) return encode_value(raw, place.type, place.order);
  const std::uint64_t mask = ((std::uint64_t{1} << place.bits->count) - 1) << place.bits->first;
  const auto whole = std::get<std::uint64_t>(decode_value(words, place.type, place.order));
  const std::uint64_t field = std::get<std::uint64_t>(raw) << place.bits->first;
  return encode_value((whole & ~mask) | (field & mask), place.type, place.order);
}

std::optional<std::int64_t> find_code(const DeviceRegister& place, std::string_view name) {
  for (const auto& [known, code] : place.codes)
    if (known == name) return code;
  return {};
}

std::optional<std::string> find_code_name(const DeviceRegister& place, double value) {
  for (const auto& [name, code] : place.codes)
    if (static_cast<double>(code) == value) return name;
  return {};
}

std::string describe_value(const DeviceRegister& place, double value) {
  if (const auto code = find_code_name(place, value)) return *code;
  if (place.type == RegisterType::bit || (place.bits && place.bits->count == 1)) {
    if (value == 0 || value == 1) return value == 1 ? "on" : "off";
  }
  const std::string number = fmt::format("{:.7g}", value / place.factor);
  return place.unit.empty() ? number : number + " " + place.unit;
}

double parse_register_value(const DeviceRegister& place, std::string_view text) {
  const std::string word(trim(text));
  if (const auto code = find_code(place, word)) return static_cast<double>(*code);
  if (place.codes.empty() && place.symbol.empty() && (word == "on" || word == "off"))
    return word == "on" ? 1 : 0;
  if (!place.codes.empty() && !find_decimal(word)) {
    std::vector<std::string> names;
    for (const auto& [name, code] : place.codes) names.push_back(name);
    throw Error(ErrorCode::bad_input, "", describe_unknown_name("code", word, names));
  }
  const Quantity given = parse_quantity(word);
  if (!given.dimension) return given.value * place.factor;
  if (!place.dimension ||
      describe_dimension(*place.dimension) != describe_dimension(*given.dimension)) {
    throw Error(
        ErrorCode::bad_input, "",
        fmt::format("'{}': is a {}: {} is expected", word, describe_dimension(*given.dimension),
                    place.dimension ? "a " + describe_dimension(*place.dimension)
                                    : "a number without unit"));
  }
  return given.value;
}

}  // namespace gyrator
