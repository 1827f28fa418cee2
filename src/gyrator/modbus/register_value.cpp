#include "gyrator/modbus/register_value.hpp"

#include "gyrator/core/error.hpp"
#include "gyrator/core/text.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cctype>
#include <cmath>
#include <limits>
#include <type_traits>
#include <utility>

#include <fmt/core.h>

namespace gyrator {
namespace {

constexpr std::array<std::string_view, 4> table_names{"coil", "discrete", "input", "holding"};
constexpr std::array<std::string_view, 8> type_names{"bit", "u16", "i16", "u32",
                                                     "i32", "u64", "f32", "f64"};
constexpr std::array<std::string_view, 4> order_names{"ABCD", "BADC", "CDAB", "DCBA"};

template <class Enum, std::size_t Size>
std::optional<Enum> find_in(const std::array<std::string_view, Size>& names,
                            std::string_view name) {
  const auto* found = std::find(names.begin(), names.end(), name);
  if (found == names.end()) return std::nullopt;
  return static_cast<Enum>(found - names.begin());
}

bool swaps_bytes(WordOrder order) {
  return order == WordOrder::badc || order == WordOrder::dcba;
}
bool reverses_words(WordOrder order) {
  return order == WordOrder::cdab || order == WordOrder::dcba;
}

std::uint16_t swap_bytes(std::uint16_t word) {
  return static_cast<std::uint16_t>(word << 8 | word >> 8);
}

// The layouts of IEEE 754.
constexpr int mantissa_bits_f32 = 23, mantissa_bits_f64 = 52;
constexpr int dropped_bits = mantissa_bits_f64 - mantissa_bits_f32;
constexpr std::uint32_t exponent_f32 = 0x7F800000U, sign_f32 = 0x80000000U, quiet_f32 = 0x00400000U,
                        mantissa_f32 = 0x007FFFFFU;
constexpr std::uint64_t exponent_f64 = 0x7FF0000000000000U;

/// The processor's own conversion would set the quiet bit of a not-a-number.
double widen(std::uint32_t pattern) {
  const auto narrow = std::bit_cast<float>(pattern);
  if (!std::isnan(narrow)) return narrow;
  const std::uint64_t sign = static_cast<std::uint64_t>(pattern & sign_f32) << 32;
  const std::uint64_t payload = static_cast<std::uint64_t>(pattern & mantissa_f32) << dropped_bits;
  return std::bit_cast<double>(sign | exponent_f64 | payload);
}

std::uint32_t narrow(double value) {
  if (!std::isnan(value)) return std::bit_cast<std::uint32_t>(static_cast<float>(value));
  const auto pattern = std::bit_cast<std::uint64_t>(value);
  const auto sign = static_cast<std::uint32_t>(pattern >> 32) & sign_f32;
  const auto payload = static_cast<std::uint32_t>(pattern >> dropped_bits) & mantissa_f32;
  return sign | exponent_f32 | (payload == 0 ? quiet_f32 : payload);
}

[[noreturn]] void refuse(const RawValue& value, RegisterType type, std::string_view why) {
  const std::string given =
      std::visit([](auto number) { return fmt::format("{}", number); }, value);
  throw Error(ErrorCode::bad_input, "", fmt::format("{} as {}: {}", given, name_of(type), why));
}

/// The value as an integer of the type, its range being lowest … highest.
template <class Integer>
Integer to_integer(const RawValue& value, RegisterType type, Integer lowest, Integer highest) {
  const std::string range = fmt::format("must be a whole number from {} to {}", lowest, highest);
  if (const auto* number = std::get_if<double>(&value)) {
    // The double next above the largest integer is exact: 2^n.
    const double end =
        std::ldexp(1.0, static_cast<int>(std::bit_width(static_cast<std::uint64_t>(highest))));
    if (!(*number >= static_cast<double>(lowest) && *number < end) ||
        *number != std::floor(*number))
      refuse(value, type, range);
    return static_cast<Integer>(*number);
  }
  return std::visit(
      [&](auto number) {
        if constexpr (std::is_integral_v<decltype(number)>) {
          if (std::cmp_less(number, lowest) || std::cmp_greater(number, highest))
            refuse(value, type, range);
        }
        return static_cast<Integer>(number);
      },
      value);
}

template <class Integer>
std::uint64_t integer_pattern(const RawValue& value, RegisterType type) {
  using Limits = std::numeric_limits<Integer>;
  const auto number = to_integer<Integer>(value, type, Limits::min(), Limits::max());
  return static_cast<std::make_unsigned_t<Integer>>(number);
}

std::uint64_t pattern_of(const RawValue& value, RegisterType type) {
  switch (type) {
    case RegisterType::bit:
      return to_integer<std::uint64_t>(value, type, 0, 1);
    case RegisterType::u16:
      return integer_pattern<std::uint16_t>(value, type);
    case RegisterType::i16:
      return integer_pattern<std::int16_t>(value, type);
    case RegisterType::u32:
      return integer_pattern<std::uint32_t>(value, type);
    case RegisterType::i32:
      return integer_pattern<std::int32_t>(value, type);
    case RegisterType::u64:
      return integer_pattern<std::uint64_t>(value, type);
    case RegisterType::f64:
      return std::bit_cast<std::uint64_t>(to_double(value));
    case RegisterType::f32:
      break;
  }
  const double number = to_double(value);
  const std::uint32_t pattern = narrow(number);
  if (std::isfinite(number) && !std::isfinite(std::bit_cast<float>(pattern)))
    refuse(value, type, "must be at most 3.40282e+38 in magnitude");
  return pattern;
}

}  // namespace

std::string_view name_of(RegisterTable table) {
  return table_names.at(static_cast<std::size_t>(table));
}
std::string_view name_of(RegisterType type) {
  return type_names.at(static_cast<std::size_t>(type));
}
std::string_view name_of(WordOrder order) {
  return order_names.at(static_cast<std::size_t>(order));
}

std::optional<RegisterTable> find_register_table(std::string_view name) {
  return find_in<RegisterTable>(table_names, name);
}
std::optional<RegisterType> find_register_type(std::string_view name) {
  return find_in<RegisterType>(type_names, name);
}
std::optional<WordOrder> find_word_order(std::string_view name) {
  std::string upper(name);
  for (char& c : upper) c = static_cast<char>(std::toupper(static_cast<unsigned char>(c)));
  return find_in<WordOrder>(order_names, upper);
}

bool holds_bits(RegisterTable table) {
  return table == RegisterTable::coil || table == RegisterTable::discrete;
}
bool is_writable(RegisterTable table) {
  return table == RegisterTable::coil || table == RegisterTable::holding;
}

std::string describe_address(RegisterTable table, int address) {
  constexpr std::array<char, 4> first_digits{'0', '1', '3', '4'};
  constexpr int most_in_five_digits = 9999;
  const int number = address + 1;
  return fmt::format("{} 0x{:04X} ({}{:0{}})", name_of(table), address,
                     first_digits.at(static_cast<std::size_t>(table)), number,
                     number > most_in_five_digits ? 5 : 4);
}

int words_of(RegisterType type) {
  switch (type) {
    case RegisterType::bit:
    case RegisterType::u16:
    case RegisterType::i16:
      return 1;
    case RegisterType::u32:
    case RegisterType::i32:
    case RegisterType::f32:
      return 2;
    case RegisterType::u64:
    case RegisterType::f64:
      break;
  }
  return 4;
}

std::vector<std::uint16_t> encode_pattern(std::uint64_t pattern, int words, WordOrder order) {
  std::vector<std::uint16_t> encoded;
  for (int i = words - 1; i >= 0; --i) {
    const auto word = static_cast<std::uint16_t>(pattern >> (16 * i));
    encoded.push_back(swaps_bytes(order) ? swap_bytes(word) : word);
  }
  if (reverses_words(order)) std::reverse(encoded.begin(), encoded.end());
  return encoded;
}

std::uint64_t decode_pattern(std::span<const std::uint16_t> words, WordOrder order) {
  std::uint64_t pattern = 0;
  for (std::size_t i = 0; i < words.size(); ++i) {
    const std::uint16_t word = words[reverses_words(order) ? words.size() - 1 - i : i];
    pattern = pattern << 16 | (swaps_bytes(order) ? swap_bytes(word) : word);
  }
  return pattern;
}

std::vector<std::uint16_t> encode_value(const RawValue& value, RegisterType type, WordOrder order) {
  // A bit of a coil has no bytes to swap.
  const WordOrder used = type == RegisterType::bit ? WordOrder::abcd : order;
  return encode_pattern(pattern_of(value, type), words_of(type), used);
}

RawValue decode_value(std::span<const std::uint16_t> words, RegisterType type, WordOrder order) {
  if (words.size() != static_cast<std::size_t>(words_of(type)))
    throw Error(
        ErrorCode::bad_input, "",
        fmt::format("{} for a value of type {}: it has {}",
                    describe_count(words.size(), "register"), name_of(type), words_of(type)));
  const std::uint64_t pattern = decode_pattern(words, order);
  switch (type) {
    case RegisterType::bit:
      return std::uint64_t{pattern != 0};
    case RegisterType::i16:
      return std::int64_t{static_cast<std::int16_t>(pattern)};
    case RegisterType::i32:
      return std::int64_t{static_cast<std::int32_t>(pattern)};
    case RegisterType::f32:
      return widen(static_cast<std::uint32_t>(pattern));
    case RegisterType::f64:
      return std::bit_cast<double>(pattern);
    case RegisterType::u16:
    case RegisterType::u32:
    case RegisterType::u64:
      break;
  }
  return pattern;
}

double to_double(const RawValue& value) {
  return std::visit([](auto number) { return static_cast<double>(number); }, value);
}

}  // namespace gyrator
