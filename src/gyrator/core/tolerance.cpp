#include "gyrator/core/tolerance.hpp"

#include "gyrator/core/error.hpp"
#include "gyrator/core/text.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <string>
#include <utility>

#include <fmt/core.h>

namespace gyrator {
namespace {

constexpr auto npos = std::string_view::npos;
constexpr std::size_t longest_text = 320;  // three quantities and what joins them

[[noreturn]] void refuse(std::string_view whole, const std::string& message) {
  throw Error(ErrorCode::bad_input, "", fmt::format("'{}': {}", whole, message));
}

// Typographic signs and what they stand for here; those in units are left to parse_quantity.
std::string replace_signs(std::string_view text) {
  constexpr std::array<std::pair<std::string_view, std::string_view>, 5> signs{
      {{"\u00b1", "+-"}, {"\u2212", "-"}, {"+/-", "+-"}, {"\u00a0", " "}, {"\u202f", " "}}};
  std::string plain;
  while (!text.empty()) {
    std::size_t length = 1;
    std::string_view written = text.substr(0, 1);
    for (const auto& [sign, meaning] : signs) {
      if (!text.starts_with(sign)) continue;
      length = sign.size();
      written = meaning;
    }
    plain += written;
    text.remove_prefix(length);
  }
  return plain;
}

// How a text falls apart; the views point into it.
struct Parts {
  enum class Form { both_sides, two_sides, range, nominal_and_range };
  Form form;
  std::string_view nominal;  // empty for a range alone
  std::string_view first, second;
};

// Where the parenthesis opens that ends the text.
std::size_t find_opening(std::string_view text) {
  if (!text.ends_with(')')) return npos;
  int depth = 0;
  for (std::size_t i = text.size(); i-- > 0;) {
    if (text[i] == ')') ++depth;
    if (text[i] == '(' && --depth == 0) return i;
  }
  return npos;
}

// A sign that starts a number of its own: behind a blank or a '/', with something before.
std::size_t find_sign(std::string_view text, std::size_t from) {
  for (std::size_t i = std::max<std::size_t>(from, 1); i < text.size(); ++i) {
    const bool is_sign = text[i] == '+' || text[i] == '-';
    const bool is_apart = text[i - 1] == ' ' || text[i - 1] == '/' || text[i - 1] == '%';
    if (is_sign && is_apart) return i;
  }
  return npos;
}

std::optional<Parts> split(std::string_view text) {
  if (const std::size_t to = text.find(" to "); to != npos) {
    const std::size_t open = find_opening(text);
    if (open == npos || open > to)
      return Parts{Parts::Form::range, {}, trim(text.substr(0, to)), trim(text.substr(to + 4))};
    const std::string_view inner = text.substr(0, text.size() - 1);
    return Parts{Parts::Form::nominal_and_range, trim(text.substr(0, open)),
                 trim(inner.substr(open + 1, to - open - 1)), trim(inner.substr(to + 4))};
  }
  if (const std::size_t sign = text.find("+-"); sign != npos)
    return Parts{
        Parts::Form::both_sides, trim(text.substr(0, sign)), trim(text.substr(sign + 2)), {}};
  const std::size_t first = find_sign(text, 1);
  // "1 / -60 s" is a fraction.
  if (first == npos || trim(text.substr(0, first)).ends_with('/')) return std::nullopt;
  const std::size_t second = find_sign(text, first + 1);
  std::string_view one = trim(text.substr(first, second == npos ? npos : second - first));
  if (one.ends_with('/')) one = trim(one.substr(0, one.size() - 1));
  return Parts{Parts::Form::two_sides, trim(text.substr(0, first)), one,
               second == npos ? std::string_view{} : trim(text.substr(second))};
}

bool is_relative(std::string_view part) {
  return part.ends_with('%') || part.ends_with("ppm");
}

// How far a part reaches, in the unit that is expected; its sign has been taken off.
double read_part(std::string_view part, const Quantity& given, double nominal, const Unit& expected,
                 std::string_view whole) {
  const Quantity amount = parse_quantity(part);
  if (!(amount.value >= 0)) {
    refuse(whole, fmt::format("a tolerance of {}: it must not be negative", part));
  }
  if (is_relative(part)) {
    if (expected.symbol == "1" && given.dimension) {
      refuse(whole,
             "of the value, or points of it? Write the value as a plain number, \"0.8 ± 5 %\", or "
             "a range, \"75 % to 85 %\"");
    }
    if (nominal == 0)
      refuse(whole, fmt::format("{} of nothing: give a range, or a tolerance with a unit", part));
    return amount.value * std::abs(nominal);
  }
  if (given.dimension && !amount.dimension) {
    refuse(
        whole,
        fmt::format("a tolerance of {} of what? Write it with its unit or in %, such as \"± 5 %\"",
                    part));
  }
  return value_in(amount, expected);
}

TolerancedValue read_both_sides(const Parts& parts, const Unit& expected, std::string_view whole) {
  const Quantity given = parse_quantity(parts.nominal);
  const double nominal = value_in(given, expected);
  if (parts.first.empty()) refuse(whole, "nothing follows the ±, such as \"± 5 %\"");
  const double reach = read_part(parts.first, given, nominal, expected, whole);
  return {nominal, nominal - reach, nominal + reach};
}

// "+20/-10 %": the unit stands once, behind both.
std::string share_unit(std::string_view first, std::string_view second) {
  const auto number = find_decimal(first);
  const auto other = find_decimal(second);
  const bool is_bare = number && number->length == first.size();
  if (!is_bare || !other) return std::string(first);
  return fmt::format("{} {}", first, trim(second.substr(other->length)));
}

TolerancedValue read_two_sides(const Parts& parts, const Unit& expected, std::string_view whole) {
  if (parts.second.empty() || parts.first[0] == parts.second[0]) {
    refuse(whole,
           "a tolerance to one side: give both, such as \"+20 % -10 %\" or \"± 5 %\"; \"-0 %\" for "
           "none; a range is written \"1 ohm to 2 ohm\"");
  }
  const Quantity given = parse_quantity(parts.nominal);
  const double nominal = value_in(given, expected);
  const std::string first = share_unit(parts.first, parts.second);
  TolerancedValue value{nominal, nominal, nominal};
  for (const std::string_view part : {std::string_view(first), parts.second}) {
    const double reach = read_part(trim(part.substr(1)), given, nominal, expected, whole);
    (part[0] == '+' ? value.high : value.low) += part[0] == '+' ? reach : -reach;
  }
  return value;
}

TolerancedValue read_range(const Parts& parts, const Unit& expected, std::string_view whole) {
  const Quantity first = parse_quantity(parts.first);
  const Quantity second = parse_quantity(parts.second);
  if (first.dimension.has_value() != second.dimension.has_value())
    refuse(whole, "a range with a unit at one end: write it at both, such as \"0 K to 40 K\"");
  TolerancedValue value{0, value_in(first, expected), value_in(second, expected)};
  if (!(value.low < value.high)) {
    refuse(whole, fmt::format("from {} to {}: the second end of a range must be above the first",
                              parts.first, parts.second));
  }
  if (parts.form == Parts::Form::range) {
    value.nominal = value.low + (value.high - value.low) / 2;
    return value;
  }
  value.nominal = value_in(parse_quantity(parts.nominal), expected);
  if (value.nominal < value.low || value.nominal > value.high) {
    refuse(whole, fmt::format("the nominal value {} is outside its range, {} to {}", parts.nominal,
                              parts.first, parts.second));
  }
  return value;
}

TolerancedValue read_parts(const Parts& parts, const Unit& expected, std::string_view whole) {
  if (parts.form == Parts::Form::both_sides) return read_both_sides(parts, expected, whole);
  if (parts.form == Parts::Form::two_sides) return read_two_sides(parts, expected, whole);
  return read_range(parts, expected, whole);
}

}  // namespace

bool has_tolerance(std::string_view text) {
  return split(replace_signs(trim(text))).has_value();
}

TolerancedValue parse_toleranced_value(std::string_view text, const Unit& expected) {
  const std::string_view whole = trim(text);
  if (whole.size() > longest_text) {
    throw Error(ErrorCode::bad_input, "",
                fmt::format("a text of {} characters: a quantity with a tolerance has at most {}",
                            whole.size(), longest_text));
  }
  const std::string plain = replace_signs(whole);
  const auto parts = split(plain);
  if (!parts) refuse(whole, "no tolerance, such as \"± 5 %\"");
  if (parts->form != Parts::Form::range && parts->nominal.empty())
    refuse(whole, "no value before the tolerance: write \"5 ohm ± 5 %\", or a range alone");
  const TolerancedValue value = read_parts(*parts, expected, whole);
  if (!std::isfinite(value.low) || !std::isfinite(value.high))
    refuse(whole, "an end beyond the range of a double");
  return value;
}

}  // namespace gyrator
