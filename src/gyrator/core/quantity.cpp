#include "gyrator/core/quantity.hpp"

#include "gyrator/core/error.hpp"
#include "gyrator/core/text.hpp"
#include "gyrator/core/unit_symbol.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdlib>
#include <numbers>
#include <utility>
#include <vector>

#include <fmt/core.h>

namespace gyrator {

namespace {

constexpr double pi = std::numbers::pi;
constexpr std::size_t longest_text = 100;  // also bounds the nesting of parentheses

// Typographic signs and what they stand for.
constexpr std::array<std::pair<std::string_view, std::string_view>, 12> signs{
    {{"\u00b5", "u"},
     {"\u03bc", "u"},
     {"\u03a9", "ohm"},
     {"\u2126", "ohm"},
     {"\u00b0", "deg"},
     {"\u00b7", "."},
     {"\u22c5", "."},
     {"\u00b2", "^2"},
     {"\u00b3", "^3"},
     {"\u207b\u00b9", "^-1"},
     {"\u00a0", " "},
     {"\u202f", " "}}};

std::string replace_signs(std::string_view text) {
  std::string plain;
  while (!text.empty()) {
    const auto* const sign = std::find_if(signs.begin(), signs.end(), [text](const auto& entry) {
      return text.starts_with(entry.first);
    });
    if (sign == signs.end()) {
      plain += text.front();
      text.remove_prefix(1);
    } else {
      plain += sign->second;
      text.remove_prefix(sign->first.size());
    }
  }
  return plain;
}

// The double nearest to the decimal × 10^shift.
double scale_decimal(const DecimalText& decimal, int shift, std::string_view whole) {
  const std::string text = fmt::format("{}e{}", decimal.mantissa, decimal.exponent + shift);
  double value = 0;
  const auto result = std::from_chars(text.data(), text.data() + text.size(), value);
  if (result.ec != std::errc{}) {
    throw Error(ErrorCode::bad_input, "",
                fmt::format("'{}': beyond the range of a double (2e-308 to 1.8e308)", whole));
  }
  return value;
}

[[noreturn]] void refuse_number(std::string_view whole, std::string_view text) {
  std::string_view word = text;
  if (word.starts_with('+') || word.starts_with('-')) word.remove_prefix(1);
  std::string lower;
  for (const char c : word.substr(0, 3)) lower += static_cast<char>(c | ('a' ^ 'A'));
  const bool is_not_finite = lower == "nan" || lower == "inf";
  throw Error(ErrorCode::bad_input, "",
              fmt::format("'{}': {}", whole,
                          is_not_finite ? "not a finite number, which a quantity must be"
                                        : "a number is expected first, as in \"1.5 ohm\""));
}

std::string with_article(std::string_view name) {
  const bool vowel = std::string_view("aeiou").find(name.front()) != std::string_view::npos;
  return fmt::format("{} {}", vowel ? "an" : "a", name);
}

std::string describe_unit(const Unit& unit) {
  if (unit.symbol == "1") return std::string(unit.name);
  return fmt::format("{} [{}]", unit.name, unit.symbol);
}

// Catalogues give the speed constant k_n (rpm/V) beside the torque constant.
void refuse_inverse_constant(const Quantity& given, const Unit& expected) {
  const bool is_constant =
      expected == dimension::torque_constant || expected == dimension::force_constant;
  Dimension product = multiply(*given.dimension, expected.dimension, 1);
  product.angle = 0;
  if (!is_constant || product != Dimension{} || !(given.value > 0)) return;
  throw Error(ErrorCode::bad_input, "",
              fmt::format("'{}': this is a speed constant k_n: the {} is its inverse, 1/k_n = {}",
                          given.text, expected.name, format_quantity(1 / given.value, expected)));
}

// "5 k" and "4k7", as on a circuit diagram: "; did you mean '4.7 kohm'?", or nothing.
std::string suggest_whole_symbol(std::string_view text, const Unit& expected) {
  const std::string plain = replace_signs(trim(text));
  const auto number = find_decimal(plain);
  if (!number || number->exponent != 0) return {};
  const std::string_view rest = trim(std::string_view(plain).substr(number->length));
  if (rest.empty()) return {};
  std::string symbol(expected.symbol);
  if (symbol != "ohm" || (rest[0] != 'R' && rest[0] != 'r')) {
    symbol.insert(0, 1, rest[0] == 'K' ? 'k' : rest[0]);
    if (!find_unit_symbol(symbol)) return {};
  }
  std::string digits(number->mantissa);
  const std::string_view behind = rest.substr(1);
  if (behind.find_first_not_of("0123456789") != std::string_view::npos) return {};
  if (!behind.empty() && digits.find('.') != std::string::npos) return {};
  if (!behind.empty()) digits.append(".").append(behind);
  return fmt::format("; did you mean '{} {}'?", digits, symbol);
}

}  // namespace

Quantity parse_quantity(std::string_view text) {
  const std::string_view whole = trim(text);
  if (whole.size() > longest_text) {
    throw Error(ErrorCode::bad_input, "",
                fmt::format("a text of {} characters: a quantity has at most {}", whole.size(),
                            longest_text));
  }
  const std::string plain = replace_signs(whole);
  std::string_view rest = trim(plain);
  const auto number = find_decimal(rest);
  if (!number) refuse_number(whole, rest);
  rest = trim(rest.substr(number->length));

  // A '/' before another number makes a fraction; before a symbol it belongs to the unit.
  std::optional<DecimalText> divisor;
  if (rest.starts_with('/')) {
    const std::string_view behind = trim(rest.substr(1));
    divisor = find_decimal(behind);
    if (divisor) rest = trim(behind.substr(divisor->length));
  }

  // "1/K" may follow a number, other digits not.
  if (!rest.empty() && rest[0] >= '0' && rest[0] <= '9' && !rest.starts_with("1/")) {
    throw Error(ErrorCode::bad_input, "",
                fmt::format("'{}': two numbers: digits are written without spaces", whole));
  }

  const UnitScale scale = rest.empty() ? UnitScale{} : read_unit(rest, whole);
  double value = scale_decimal(*number, scale.decimal, whole) * scale.factor;
  if (divisor) value /= scale_decimal(*divisor, 0, whole);
  if (!std::isfinite(value)) refuse_number(whole, "inf");
  Quantity quantity{value, std::nullopt, std::string(whole)};
  if (!rest.empty()) quantity.dimension = scale.dimension;
  return quantity;
}

double value_in(const Quantity& given, const Unit& expected) {
  if (!given.dimension) return given.value;
  Dimension dimension = *given.dimension;
  double value = given.value;
  switch (expected.match) {
    case Match::exact:
      break;
    case Match::ignore_angle:
      dimension.angle = expected.dimension.angle;
      break;
    case Match::cycles:
      if (dimension.angle == 1) {
        dimension.angle = 0;
        value /= 2 * pi;
      }
      break;
    case Match::resolution:
      if (dimension.count == 1 && value > 0) {
        dimension = multiply({}, dimension, -1);
        value = 1 / value;
      }
      if (dimension.count == -1) dimension.count = 0;  // "5 um/count" is the step as it is
      break;
  }
  if (dimension == expected.dimension && std::isfinite(value)) return value;

  if (expected.dimension == dimension::angular_velocity.dimension &&
      *given.dimension == dimension::frequency.dimension) {
    throw Error(
        ErrorCode::bad_input, "",
        fmt::format("'{}': ambiguous as an angular velocity: write it in rad/s, rev/s or rpm",
                    given.text));
  }
  if (expected.match == Match::resolution && dimension.count == 1) {
    throw Error(ErrorCode::bad_input, "",
                fmt::format("'{}': a resolution must be above 0, such as \"{}\"", given.text,
                            expected.example));
  }
  refuse_inverse_constant(given, expected);
  throw Error(ErrorCode::bad_input, "",
              fmt::format("'{}': this is {}: {} is expected, such as \"{}\"", given.text,
                          with_article(describe_dimension(*given.dimension)),
                          with_article(describe_unit(expected)), expected.example));
}

double parse_value(std::string_view text, const Unit& expected) {
  try {
    return value_in(parse_quantity(text), expected);
  } catch (const Error& error) {
    throw Error(error.code(), error.place(),
                error.message() + suggest_whole_symbol(text, expected));
  }
}

std::string describe_dimension(const Dimension& dimension) {
  for (const Unit& unit : dimension::all) {
    if (unit.dimension == dimension) return describe_unit(unit);
  }
  for (const Unit& unit : dimension::all) {
    Dimension same_angle = dimension;
    same_angle.angle = unit.dimension.angle;
    if (unit.match == Match::ignore_angle && unit.dimension == same_angle)
      return describe_unit(unit);
  }
  const std::array<std::pair<std::string_view, int>, 7> parts{{{"kg", dimension.mass},
                                                               {"m", dimension.length},
                                                               {"s", dimension.time},
                                                               {"A", dimension.current},
                                                               {"K", dimension.temperature},
                                                               {"rad", dimension.angle},
                                                               {"count", dimension.count}}};
  std::vector<std::string> factors;
  for (const auto& [symbol, power] : parts) {
    if (power == 1) factors.emplace_back(symbol);
    if (power != 0 && power != 1) factors.push_back(fmt::format("{}^{}", symbol, power));
  }
  return fmt::format("quantity in {}", join(factors, "."));
}

std::string format_quantity(double value, const Unit& unit) {
  value += 0.0;  // -0 becomes 0
  if (unit.symbol == "1") return fmt::format("{:.6g}", value);
  std::string plain = fmt::format("{:.6g} {}", value, unit.symbol);
  // Mass alone goes by the gram; "kg.m^2" stays as it is, for nobody reads mg.m^2. Kelvin too.
  const bool is_mass = unit.symbol == "kg";
  const std::string_view first = unit.symbol.substr(0, unit.symbol.find_first_of("./^"));
  if (!std::isfinite(value) || value == 0) return plain;
  if (first == "1" || first == "K" || (first == "kg" && !is_mass)) return plain;

  // Rounded to six digits first, so that 999.9999999 mV is 1 V and not 1000 mV.
  const std::string digits = fmt::format("{:.5e}", value);
  const DecimalText decimal = find_decimal(digits).value();
  const int exponent = decimal.exponent + (is_mass ? 3 : 0);
  const int thousands = exponent >= 0 ? exponent / 3 : (exponent - 2) / 3;
  constexpr std::array<std::string_view, 8> prefixes{"p", "n", "u", "m", "", "k", "M", "G"};
  const bool is_long_time = first == "s" && thousands > 0;
  if (thousands < -4 || thousands > 3 || is_long_time) return plain;
  const std::string shown = fmt::format("{}e{}", decimal.mantissa, exponent - 3 * thousands);
  return fmt::format("{:.6g} {}{}", std::strtod(shown.c_str(), nullptr), prefixes[thousands + 4],
                     is_mass ? "g" : unit.symbol);
}

}  // namespace gyrator
