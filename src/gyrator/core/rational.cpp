#include "gyrator/core/rational.hpp"

#include "gyrator/core/error.hpp"
#include "gyrator/core/text.hpp"

#include <array>
#include <cmath>
#include <limits>
#include <numeric>
#include <optional>
#include <vector>

#include <fmt/core.h>

namespace gyrator {

namespace {

__extension__ using Wide = __int128;  // not ISO C++, hence marked for -Wpedantic

constexpr std::int64_t largest = std::numeric_limits<std::int64_t>::max();

bool fits(Wide value) {
  return value >= -Wide{largest} && value <= Wide{largest};
}

Wide compute_gcd(Wide a, Wide b) {
  if (a < 0) a = -a;
  if (b < 0) b = -b;
  while (b != 0) {
    // The 64-bit division is many times faster, and nearly always enough.
    if (fits(a) && fits(b)) {
      return std::gcd(static_cast<std::int64_t>(a), static_cast<std::int64_t>(b));
    }
    const Wide rest = a % b;
    a = b;
    b = rest;
  }
  return a;
}

struct Parts {
  std::int64_t num;
  std::int64_t den;
};

// num / den in lowest terms; nothing if these do not fit. den is not 0.
std::optional<Parts> find_lowest_terms(Wide num, Wide den) {
  const Wide gcd = compute_gcd(num, den);
  num /= gcd;
  den /= gcd;
  if (den < 0) {
    num = -num;
    den = -den;
  }
  if (!fits(num) || !fits(den)) return std::nullopt;
  return Parts{static_cast<std::int64_t>(num), static_cast<std::int64_t>(den)};
}

Rational make_rational(Wide num, Wide den, std::string_view operation) {
  if (den == 0) {
    throw Error(ErrorCode::numerical, "exact fraction",
                fmt::format("{}: the divisor is 0", operation));
  }
  const auto parts = find_lowest_terms(num, den);
  if (!parts) {
    throw Error(
        ErrorCode::numerical, "exact fraction",
        fmt::format("{}: the result does not fit a fraction of 64-bit integers (about {:.6g})",
                    operation, static_cast<double>(num) / static_cast<double>(den)));
  }
  return {parts->num, parts->den};
}

[[noreturn]] void refuse(std::string_view text, std::string_view rule) {
  throw Error(ErrorCode::bad_input, "", fmt::format("'{}': {}", text, rule));
}

// mantissa × 10^exponent from its digits; nothing if it does not fit.
std::optional<Parts> find_decimal_parts(const DecimalText& decimal) {
  Wide num = 0;
  int exponent = decimal.exponent;
  bool behind_point = false;
  int zeros = 0;  // seen and not yet used, so that "1.000…0" fits
  for (const char c : decimal.mantissa) {
    if (c == '.') behind_point = true;
    if (c < '0' || c > '9') continue;
    if (behind_point) --exponent;
    ++zeros;
    if (c == '0') continue;
    for (; zeros > 0; --zeros) {
      if (num > Wide{largest}) return std::nullopt;
      num *= 10;
    }
    num += c - '0';
  }
  exponent += zeros;
  if (num == 0) return Parts{0, 1};
  if (decimal.mantissa.front() == '-') num = -num;
  Wide den = 1;
  for (; exponent > 0; --exponent) {
    if (!fits(num)) return std::nullopt;
    num *= 10;
  }
  for (; exponent < 0; ++exponent) {
    if (den > (Wide{1} << 120U)) return std::nullopt;
    den *= 10;
  }
  return find_lowest_terms(num, den);
}

struct WideFraction {
  Wide num;
  Wide den;
};

// The fraction with the smallest denominator from a to b, 0 < a < b (the Stern-Brocot tree, by
// continued fractions).
WideFraction find_simplest(const WideFraction& a, const WideFraction& b) {
  const Wide whole = a.num / a.den;
  if (whole * a.den == a.num) return {whole, 1};
  if ((whole + 1) * b.den <= b.num) return {whole + 1, 1};
  // Both have the same whole part: the inverses of what is left, in the other order.
  const WideFraction rest =
      find_simplest({b.den, b.num - whole * b.den}, {a.den, a.num - whole * a.den});
  return {whole * rest.num + rest.den, rest.num};
}

// The simplest fraction within two units in the last place of a number that is not whole; nothing
// if it does not fit.
std::optional<Parts> find_simplest_parts(double value) {
  constexpr int digits = std::numeric_limits<double>::digits;
  int exponent = 0;
  const auto mantissa =
      static_cast<std::int64_t>(std::ldexp(std::frexp(std::abs(value), &exponent), digits));
  const int shift = digits - exponent;  // |value| = mantissa / 2^shift
  if (shift > 120) return std::nullopt;
  const Wide den = Wide{1} << static_cast<unsigned>(shift);
  const WideFraction found = find_simplest({mantissa - 2, den}, {mantissa + 2, den});
  return find_lowest_terms(value < 0 ? -found.num : found.num, found.den);
}

std::size_t count_significant_digits(std::string_view mantissa) {
  std::size_t count = 0;
  for (const char c : mantissa) {
    if (c >= '0' && c <= '9' && (c != '0' || count > 0)) ++count;
  }
  return count;
}

// The decimal, or fraction of decimals, at the start of the text, and what follows it.
struct NumberAndRest {
  Rational number;
  std::string_view rest;
};

Rational make_decimal(const DecimalText& decimal, std::string_view whole) {
  const auto parts = find_decimal_parts(decimal);
  if (!parts) refuse(whole, "an exact number needs at most 18 digits before and after the point");
  return {parts->num, parts->den};
}

std::optional<NumberAndRest> find_number(std::string_view text) {
  const auto decimal = find_decimal(text);
  if (!decimal) return std::nullopt;
  NumberAndRest found{make_decimal(*decimal, text), trim(text.substr(decimal->length))};
  if (!found.rest.starts_with('/')) return found;
  const auto divisor = find_decimal(trim(found.rest.substr(1)));
  if (!divisor) return found;
  const Rational den = make_decimal(*divisor, text);
  if (den == 0) refuse(text, "the divisor is 0");
  found.rest = trim(trim(found.rest.substr(1)).substr(divisor->length));
  // Not through operator/, for an overflow here is the user's and not numerical.
  const auto parts =
      find_lowest_terms(Wide{found.number.num()} * den.den(), Wide{found.number.den()} * den.num());
  if (!parts) refuse(text, "does not fit a fraction of 64-bit integers");
  found.number = Rational(parts->num, parts->den);
  return found;
}

}  // namespace

Rational::Rational(std::int64_t num, std::int64_t den) {
  if (den == 0) throw Error(ErrorCode::numerical, "exact fraction", "the denominator is 0");
  const auto parts = find_lowest_terms(num, den);
  if (!parts) {
    throw Error(ErrorCode::numerical, "exact fraction",
                fmt::format("{}/{} does not fit 64-bit integers", num, den));
  }
  num_ = parts->num;
  den_ = parts->den;
}

Rational Rational::from_decimal(std::string_view text) {
  const std::string_view trimmed = trim(text);
  const auto decimal = find_decimal(trimmed);
  if (!decimal || decimal->length != trimmed.size()) {
    refuse(text, "a decimal number is expected, such as \"0.001\"");
  }
  return make_decimal(*decimal, text);
}

Rational Rational::from_text(std::string_view text) {
  const auto found = find_number(trim(text));
  if (!found || !found->rest.empty()) {
    refuse(text, R"(a number or a fraction is expected, such as "0.001" or "1/60")");
  }
  return found->number;
}

Rational Rational::from_double(double value) {
  if (!std::isfinite(value)) refuse(format_number(value), "a finite number is expected");
  const std::string text = format_number(value);
  constexpr std::size_t most_digits_typed = 15;
  if (value != std::floor(value) &&
      count_significant_digits(find_decimal(text)->mantissa) > most_digits_typed) {
    if (const auto parts = find_simplest_parts(value)) return {parts->num, parts->den};
  }
  return from_decimal(text);
}

double Rational::to_double() const {
  constexpr std::int64_t exact = std::int64_t{1} << 53U;
  if (num_ > -exact && num_ < exact && den_ < exact) {
    return static_cast<double>(num_) / static_cast<double>(den_);
  }
  return static_cast<double>(static_cast<long double>(num_) / static_cast<long double>(den_));
}

std::string Rational::to_string() const {
  return fmt::format("{}/{}", num_, den_);
}

// The cross products of 64-bit integers fit 128 bits, and so does their sum since none is -2^63.
Rational operator+(const Rational& a, const Rational& b) {
  return make_rational(Wide{a.num_} * b.den_ + Wide{b.num_} * a.den_, Wide{a.den_} * b.den_,
                       "a sum");
}

Rational operator-(const Rational& a, const Rational& b) {
  return make_rational(Wide{a.num_} * b.den_ - Wide{b.num_} * a.den_, Wide{a.den_} * b.den_,
                       "a difference");
}

Rational operator*(const Rational& a, const Rational& b) {
  return make_rational(Wide{a.num_} * b.num_, Wide{a.den_} * b.den_, "a product");
}

Rational operator/(const Rational& a, const Rational& b) {
  return make_rational(Wide{a.num_} * b.den_, Wide{a.den_} * b.num_, "a quotient");
}

Rational operator-(const Rational& a) {
  return {-a.num_, a.den_};
}

std::strong_ordering operator<=>(const Rational& a, const Rational& b) {
  const Wide left = Wide{a.num_} * b.den_;
  const Wide right = Wide{b.num_} * a.den_;
  if (left < right) return std::strong_ordering::less;
  return left > right ? std::strong_ordering::greater : std::strong_ordering::equal;
}

std::int64_t floor_divide(const Rational& a, const Rational& b) {
  if (b <= 0) {
    throw Error(ErrorCode::numerical, "exact fraction", "floor division by " + b.to_string());
  }
  const Wide num = Wide{a.num()} * b.den();
  const Wide den = Wide{a.den()} * b.num();
  Wide quotient = num / den;
  if (num % den < 0) --quotient;  // the built-in division rounds towards zero
  if (!fits(quotient)) {
    throw Error(ErrorCode::numerical, "exact fraction",
                fmt::format("{} / {} has no 64-bit whole part", a.to_string(), b.to_string()));
  }
  return static_cast<std::int64_t>(quotient);
}

std::int64_t ceil_divide(const Rational& a, const Rational& b) {
  return -floor_divide(-a, b);
}

std::int64_t count_ticks(const Rational& period, const Rational& offset, const Rational& time) {
  return time < offset ? 0 : floor_divide(time - offset, period) + 1;
}

std::int64_t first_tick(const Rational& period, const Rational& offset, const Rational& time) {
  return time <= offset ? 0 : ceil_divide(time - offset, period);
}

Rational parse_time(std::string_view text) {
  struct TimeUnit {
    std::string_view name;
    std::int64_t num;
    std::int64_t den;
  };
  static constexpr std::array<TimeUnit, 7> units{{{"s", 1, 1},
                                                  {"ms", 1, 1000},
                                                  {"us", 1, 1000000},
                                                  {"\u00b5s", 1, 1000000},
                                                  {"\u03bcs", 1, 1000000},
                                                  {"ns", 1, 1000000000},
                                                  {"min", 60, 1}}};
  const auto found = find_number(trim(text));
  if (!found) refuse(text, R"(a time is expected, such as "1 ms", "1/60 s" or 0.001)");
  if (found->rest.empty()) return found->number;
  std::vector<std::string> known;
  for (const TimeUnit& unit : units) {
    if (unit.name == found->rest) {
      const auto parts = find_lowest_terms(Wide{found->number.num()} * unit.num,
                                           Wide{found->number.den()} * unit.den);
      if (!parts) refuse(text, "does not fit a fraction of 64-bit integers");
      return {parts->num, parts->den};
    }
    const bool is_typographic = static_cast<unsigned char>(unit.name.front()) >= 0x80;
    if (!is_typographic) known.emplace_back(unit.name);
  }
  refuse(text, describe_unknown_name("unit of time", found->rest, known));
}

}  // namespace gyrator
