#include "gyrator/core/rational.hpp"

#include "gyrator/core/error.hpp"

#include <cmath>
#include <cstdint>
#include <limits>
#include <string>

#include <gtest/gtest.h>

namespace gyrator {
namespace {

constexpr std::int64_t largest = std::numeric_limits<std::int64_t>::max();
constexpr std::int64_t smallest = std::numeric_limits<std::int64_t>::min();

template <class Call>
ErrorCode find_code(Call call) {
  try {
    call();
  } catch (const Error& error) {
    return error.code();
  }
  ADD_FAILURE() << "no error";
  return ErrorCode::interrupted;
}

TEST(Rational, is_kept_in_lowest_terms_with_a_positive_denominator) {
  EXPECT_EQ(Rational(2, 4), Rational(1, 2));
  EXPECT_EQ(Rational(3, -6).num(), -1);
  EXPECT_EQ(Rational(3, -6).den(), 2);
  EXPECT_EQ(Rational(0, -7), Rational());
  EXPECT_EQ(Rational(0, 7).den(), 1);
}

TEST(Rational, computes_exactly) {
  EXPECT_EQ(Rational(1, 60) + Rational(1, 200), Rational(13, 600));
  EXPECT_EQ(Rational(1, 60) - Rational(1, 200), Rational(7, 600));
  EXPECT_EQ(Rational(2, 3) * Rational(9, 4), Rational(3, 2));
  EXPECT_EQ(Rational(2, 3) / Rational(-4, 9), Rational(-3, 2));
  EXPECT_EQ(-Rational(2, 3), Rational(-2, 3));
  EXPECT_EQ(Rational(3) * Rational(1, 60), Rational(1, 20));
}

TEST(Rational, compares_where_doubles_cannot) {
  // Both are 1.0 as doubles.
  EXPECT_LT(Rational(largest - 1, largest), Rational(1));
  EXPECT_GT(Rational(largest, largest - 1), Rational(1));
  EXPECT_LT(Rational(largest - 2, largest - 1), Rational(largest - 1, largest));
  EXPECT_LT(Rational(-1, 2), Rational(-1, 3));
  EXPECT_LE(Rational(1, 2), Rational(2, 4));
}

TEST(Rational, refuses_what_does_not_fit_instead_of_rounding) {
  EXPECT_EQ(find_code([] { return Rational(largest) + 1; }), ErrorCode::numerical);
  EXPECT_EQ(find_code([] { return Rational(largest) * 2; }), ErrorCode::numerical);
  EXPECT_EQ(find_code([] { return Rational(1, largest) + Rational(1, largest - 1); }),
            ErrorCode::numerical);
  EXPECT_EQ(find_code([] { return Rational(1) / 0; }), ErrorCode::numerical);
  EXPECT_EQ(find_code([] { return Rational(1, 0); }), ErrorCode::numerical);
  EXPECT_EQ(find_code([] { return Rational(smallest); }), ErrorCode::numerical);
}

TEST(Rational, intermediate_results_may_be_wider_than_the_result) {
  EXPECT_EQ(Rational(largest, 3) * Rational(3, largest), Rational(1));
  EXPECT_EQ(Rational(largest) - Rational(largest - 1), Rational(1));
  EXPECT_EQ(Rational(smallest, 2), Rational(smallest / 2));
  EXPECT_EQ(Rational(1, smallest / 2), Rational(-1, std::int64_t{1} << 62U));
}

TEST(Rational, double_is_the_nearest) {
  EXPECT_EQ(Rational(1, 60).to_double(), 1.0 / 60);
  EXPECT_EQ(Rational(-1, 3).to_double(), -1.0 / 3);
  EXPECT_EQ(Rational(largest, largest - 1).to_double(), 1.0);
  EXPECT_EQ(Rational((std::int64_t{1} << 60U) + 256, 1).to_double(), 0x1p60 + 256);
}

TEST(Rational, text_reads_back) {
  EXPECT_EQ(Rational(1, 60).to_string(), "1/60");
  EXPECT_EQ(Rational(3).to_string(), "3/1");
  for (const Rational& value :
       {Rational(1, 60), Rational(-7, 3), Rational(), Rational(largest, 2)}) {
    EXPECT_EQ(Rational::from_text(value.to_string()), value);
  }
}

TEST(RationalFromDecimal, is_exact) {
  EXPECT_EQ(Rational::from_decimal("0.001"), Rational(1, 1000));
  EXPECT_EQ(Rational::from_decimal("-2.50e-3"), Rational(-1, 400));
  EXPECT_EQ(Rational::from_decimal("1.5e3"), Rational(1500));
  EXPECT_EQ(Rational::from_decimal(" 0.000 "), Rational());
  EXPECT_EQ(Rational::from_decimal("0e99999999999"), Rational());
  EXPECT_EQ(Rational::from_decimal("9223372036854775807"), Rational(largest));
  EXPECT_EQ(Rational::from_decimal("1000000000000000000000000000000e-30"), Rational(1));
  EXPECT_EQ(Rational::from_decimal("0.5000000000000000000000000000000"), Rational(1, 2));
}

TEST(RationalFromDecimal, refuses_what_needs_more_than_64_bits_or_is_no_number) {
  for (const char* text : {"9223372036854775808", "1e19", "1e-19", "1e-100000", "1e100000",
                           "0.12345678901234567891", "", "abc", "1/60", "1 s", "nan"}) {
    EXPECT_EQ(find_code([text] { return Rational::from_decimal(text); }), ErrorCode::bad_input)
        << text;
  }
}

TEST(RationalFromDouble, is_the_decimal_that_the_user_wrote) {
  EXPECT_EQ(Rational::from_double(0.1), Rational(1, 10));
  EXPECT_EQ(Rational::from_double(1e-3), Rational(1, 1000));
  EXPECT_EQ(Rational::from_double(-2.5), Rational(-5, 2));
  EXPECT_EQ(Rational::from_double(0.123456789012345), Rational::from_decimal("0.123456789012345"));
  EXPECT_EQ(find_code([] { return Rational::from_double(std::nan("")); }), ErrorCode::bad_input);
  EXPECT_EQ(find_code([] { return Rational::from_double(1e300); }), ErrorCode::bad_input);
}

TEST(FromDouble, takes_what_a_program_computed_for_the_simplest_fraction_nearby) {
  for (const std::int64_t den : {3, 7, 60, 700, 3000, 7000, 44100, 99991}) {
    EXPECT_EQ(Rational::from_double(1.0 / static_cast<double>(den)), Rational(1, den)) << den;
    EXPECT_EQ(Rational::from_double(-2.0 / static_cast<double>(den)), Rational(-2, den)) << den;
  }
  EXPECT_EQ(Rational::from_double(9.999999999999999e-05), Rational(1, 10000));
  EXPECT_EQ(Rational::from_double(0.1 + 0.2), Rational(3, 10));
  EXPECT_EQ(Rational::from_double(3 * 1e-4), Rational(3, 10000));
  EXPECT_EQ(Rational::from_double(1.0000000000000002), Rational(1));
  EXPECT_EQ(Rational::from_double(12345678901234567.0), Rational(12345678901234568));
  EXPECT_NEAR(Rational::from_double(0.12345678901234567).to_double(), 0.12345678901234567, 4e-17);
}

TEST(FloorDivide, rounds_towards_minus_infinity) {
  EXPECT_EQ(floor_divide(Rational(7, 2), 1), 3);
  EXPECT_EQ(floor_divide(Rational(-7, 2), 1), -4);
  EXPECT_EQ(floor_divide(Rational(-3), 1), -3);
  EXPECT_EQ(floor_divide(1, Rational(1, 60)), 60);
  EXPECT_EQ(floor_divide(Rational(59, 3600), Rational(1, 60)), 0);
}

TEST(FloorDivide, and_ceiling_enclose_the_quotient) {
  EXPECT_EQ(ceil_divide(Rational(7, 2), 1), 4);
  EXPECT_EQ(ceil_divide(Rational(-7, 2), 1), -3);
  EXPECT_EQ(ceil_divide(Rational(3), 1), 3);
  EXPECT_EQ(find_code([] { return floor_divide(1, 0); }), ErrorCode::numerical);
  EXPECT_EQ(find_code([] { return floor_divide(1, -1); }), ErrorCode::numerical);
  EXPECT_EQ(find_code([] { return floor_divide(largest, Rational(1, 2)); }), ErrorCode::numerical);
}

TEST(CountTicks, counts_the_tick_at_the_very_instant) {
  const Rational period(1, 60);
  EXPECT_EQ(count_ticks(period, 0, 0), 1);
  EXPECT_EQ(count_ticks(period, 0, Rational(1, 20)), 4);
  EXPECT_EQ(count_ticks(period, 0, Rational(499999, 10000000)), 3);
  EXPECT_EQ(count_ticks(period, Rational(1, 100), Rational(1, 200)), 0);
  EXPECT_EQ(count_ticks(period, Rational(1, 100), Rational(1, 100)), 1);
}

TEST(FirstTick, is_the_first_at_or_after) {
  const Rational period(1, 60);
  EXPECT_EQ(first_tick(period, 0, 0), 0);
  EXPECT_EQ(first_tick(period, 0, Rational(1, 20)), 3);
  EXPECT_EQ(first_tick(period, 0, Rational(1, 19)), 4);
  EXPECT_EQ(first_tick(period, Rational(1, 100), 0), 0);
  EXPECT_EQ(first_tick(period, 0, -5), 0);
}

TEST(ParseTime, is_exact_in_each_unit) {
  EXPECT_EQ(parse_time("1 ms"), Rational(1, 1000));
  EXPECT_EQ(parse_time("1/60 s"), Rational(1, 60));
  EXPECT_EQ(parse_time("1 / 60 s"), Rational(1, 60));
  EXPECT_EQ(parse_time("0.001"), Rational(1, 1000));
  EXPECT_EQ(parse_time("50us"), Rational(1, 20000));
  EXPECT_EQ(parse_time("50 \u00b5s"), Rational(1, 20000));
  EXPECT_EQ(parse_time("50 \u03bcs"), Rational(1, 20000));
  EXPECT_EQ(parse_time("100 ns"), Rational(1, 10000000));
  EXPECT_EQ(parse_time("2 min"), Rational(120));
  EXPECT_EQ(parse_time("1000/3 us"), Rational(1, 3000));
  EXPECT_EQ(parse_time("-1 ms"), Rational(-1, 1000));
}

TEST(ParseTime, says_what_is_wrong) {
  const auto message = [](std::string_view text) {
    try {
      return parse_time(text).to_string();
    } catch (const Error& error) {
      EXPECT_EQ(error.code(), ErrorCode::bad_input);
      return error.message();
    }
  };
  EXPECT_EQ(message("1 mS"),
            "'1 mS': unknown unit of time 'mS': allowed: s, ms, us, ns, min; did you mean "
            "'ms'?");
  EXPECT_EQ(message("1 kHz"), "'1 kHz': unknown unit of time 'kHz': allowed: s, ms, us, ns, min");
  EXPECT_NE(message("1/0 s").find("the divisor is 0"), std::string::npos);
  EXPECT_NE(message("ms").find("a time is expected"), std::string::npos);
  EXPECT_NE(message("nan").find("a time is expected"), std::string::npos);
  EXPECT_NE(message("1e30 s").find("18 digits"), std::string::npos);
  EXPECT_NE(message("1e18 min").find("does not fit"), std::string::npos);
}

}  // namespace
}  // namespace gyrator
