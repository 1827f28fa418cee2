#pragma once

#include <compare>
#include <cstdint>
#include <string>
#include <string_view>

namespace gyrator {

/// An exact fraction of two 64-bit integers, always in lowest terms with a positive denominator.
///
/// Time is kept in it (seconds), because 1/60 s is a whole number of no decimal unit. Arithmetic is
/// exact or throws numerical: a result whose lowest terms do not fit 64 bits is never rounded.
class Rational {
 public:
  constexpr Rational() = default;
  // An integer is a rational: the conversion is exact, hence implicit.
  Rational(std::int64_t integer) : Rational(integer, 1) {}
  /// Throws numerical for a zero denominator and for what lowest terms do not bring into ±(2^63-1).
  Rational(std::int64_t num, std::int64_t den);

  /// Exact value of a decimal text: "0.001", "-2.5e-3". Throws bad_input for another text and for
  /// a number that needs more than 64 bits.
  static Rational from_decimal(std::string_view text);
  /// A decimal or a fraction of two: "1/60", "0.5/3", "0.001". The inverse of to_string.
  static Rational from_text(std::string_view text);
  /// Exact value of the shortest decimal that reads back as the double: 0.1 is 1/10. One with more
  /// than 15 digits was computed: then the simplest fraction within two units in the last place,
  /// 1/3000 for 0.0003333333333333333 and 1/10000 for 9.999999999999999e-05.
  static Rational from_double(double value);

  constexpr std::int64_t num() const { return num_; }
  constexpr std::int64_t den() const { return den_; }

  /// The nearest double, correctly rounded while both parts are below 2^53.
  double to_double() const;
  /// "num/den", also for an integer: "1/60", "3/1".
  std::string to_string() const;

  friend Rational operator+(const Rational& a, const Rational& b);
  friend Rational operator-(const Rational& a, const Rational& b);
  friend Rational operator*(const Rational& a, const Rational& b);
  /// Throws numerical for b = 0.
  friend Rational operator/(const Rational& a, const Rational& b);
  friend Rational operator-(const Rational& a);

  friend constexpr bool operator==(const Rational&, const Rational&) = default;
  friend std::strong_ordering operator<=>(const Rational& a, const Rational& b);

 private:
  std::int64_t num_ = 0;
  std::int64_t den_ = 1;
};

/// The largest integer n with n b ≤ a. Throws numerical for b ≤ 0.
std::int64_t floor_divide(const Rational& a, const Rational& b);
/// The smallest integer n with n b ≥ a. Throws numerical for b ≤ 0.
std::int64_t ceil_divide(const Rational& a, const Rational& b);

/// How many of the ticks offset + k period, k = 0, 1, …, fall at or before `time`.
std::int64_t count_ticks(const Rational& period, const Rational& offset, const Rational& time);
/// The index k ≥ 0 of the first of these ticks at or after `time`.
std::int64_t first_tick(const Rational& period, const Rational& offset, const Rational& time);

/// Exact seconds from "1 ms", "1/60 s", "50 us" or bare seconds "0.001"; the units are s, ms, us
/// (µs), ns and min. Throws bad_input, without a place, for anything else.
Rational parse_time(std::string_view text);

}  // namespace gyrator
