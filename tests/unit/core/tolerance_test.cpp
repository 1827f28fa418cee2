#include "gyrator/core/tolerance.hpp"

#include "gyrator/core/error.hpp"

#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

namespace gyrator {
namespace {

TolerancedValue read(std::string_view text, const Unit& unit) {
  EXPECT_TRUE(has_tolerance(text)) << text;
  return parse_toleranced_value(text, unit);
}

std::string find_message(std::string_view text, const Unit& unit) {
  try {
    parse_toleranced_value(text, unit);
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::bad_input);
    return error.message();
  }
  return "no error";
}

// The ends are one rounded operation away from the decimal numbers.
void expect_value(const TolerancedValue& value, double nominal, double low, double high,
                  std::string_view text) {
  EXPECT_DOUBLE_EQ(value.nominal, nominal) << text;
  EXPECT_DOUBLE_EQ(value.low, low) << text;
  EXPECT_DOUBLE_EQ(value.high, high) << text;
}

TEST(ParseTolerance, a_part_in_per_cent_is_one_of_the_value) {
  for (const char* text : {"5 ohm ± 5 %", "5 ohm +- 5 %", "5 ohm +/- 5 %", "5ohm±5%",
                           "5 \u03a9 ± 50000 ppm", "5 ohm\u00a0±\u00a05\u202f%"})
    expect_value(read(text, dimension::resistance), 5, 4.75, 5.25, text);
  expect_value(read("0.8 ± 5 %", dimension::none), 0.8, 0.76, 0.84, "pure number");
  expect_value(read("0.39 %/K ± 10 %", dimension::temperature_coefficient), 0.0039, 0.00351,
               0.00429, "a unit with a per cent in it");
  expect_value(read("-10 K ± 20 %", dimension::temperature), -10, -12, -8, "negative");
}

TEST(ParseTolerance, a_part_with_a_unit_is_added_and_may_have_another_prefix) {
  expect_value(read("5 ohm ± 0.2 ohm", dimension::resistance), 5, 4.8, 5.2, "same unit");
  expect_value(read("1 kohm ± 50 ohm", dimension::resistance), 1000, 950, 1050, "prefix");
  expect_value(read("0.05 ± 0.002", dimension::torque_constant), 0.05, 0.048, 0.052, "both bare");
  expect_value(read("0.05 ± 2 mN.m/A", dimension::torque_constant), 0.05, 0.048, 0.052, "bare SI");
}

TEST(ParseTolerance, two_sides_may_differ) {
  for (const char* text : {"2200 uF +20 % -10 %", "2200 uF -10 % +20 %", "2200 uF +20 % / -10 %",
                           "2200 uF +20/-10 %", "2200 uF +20% -10%", "2200 uF +20 % \u221210 %"})
    expect_value(read(text, dimension::capacitance), 2200e-6, 1980e-6, 2640e-6, text);
  expect_value(read("5 ohm +0.2 ohm -0 ohm", dimension::resistance), 5, 5, 5.2, "one side");
  expect_value(read("10 V +1 V -5 %", dimension::voltage), 10, 9.5, 11, "mixed");
}

TEST(ParseTolerance, a_range_has_the_middle_or_the_value_before_it) {
  expect_value(read("0 K to 40 K", dimension::temperature), 20, 0, 40, "middle");
  expect_value(read("-10 to 40", dimension::temperature), 15, -10, 40, "bare");
  expect_value(read("20 K (-10 K to 40 K)", dimension::temperature), 20, -10, 40, "value");
  expect_value(read("3 mN.m/(rad/s) (2 mN.m/(rad/s) to 5 mN.m/(rad/s))", dimension::rotary_damping),
               3e-3, 2e-3, 5e-3, "parentheses in the unit");
  expect_value(read("2 N.m/(rad/s) to 5 N.m/(rad/s)", dimension::rotary_damping), 3.5, 2, 5,
               "parenthesis at the end");
}

TEST(ParseTolerance, a_plain_quantity_has_none) {
  for (const char* text : {"5 ohm", "1e-5", "-3 K", "+3 K", "1/60 s", "0.004 K^-1", "2 N.m.A^-1",
                           "1 / -60 s", "8192 counts/rev", "", "to"})
    EXPECT_FALSE(has_tolerance(text)) << text;
}

TEST(ParseTolerance, what_is_wrong_is_named) {
  struct Case {
    const char* text;
    const Unit& unit;
    const char* part;
  };
  const std::vector<Case> cases{
      {"5 ohm ± 0.2", dimension::resistance, "of what?"},
      {"5 ohm ±", dimension::resistance, "nothing follows the ±"},
      {"5 ohm ± -5 %", dimension::resistance, "must not be negative"},
      {"5 ohm ± 0.2 V", dimension::resistance, "this is a voltage [V]"},
      {"5 V ± 5 %", dimension::resistance, "this is a voltage [V]"},
      {"0 K ± 5 %", dimension::temperature, "of nothing"},
      {"80 % ± 5 %", dimension::none, "of the value, or points of it?"},
      {"5 ohm +5 %", dimension::resistance, "to one side"},
      {"5 ohm +5 % +3 %", dimension::resistance, "to one side"},
      {"40 K to 0 K", dimension::temperature, "must be above the first"},
      {"0 to 40 K", dimension::temperature, "write it at both"},
      {"50 K (0 K to 40 K)", dimension::temperature, "is outside its range"},
      {"5 ohm", dimension::resistance, "no tolerance"},
      {"± 5 %", dimension::resistance, "no value before the tolerance"},
      {"(1 ohm to 2 ohm)", dimension::resistance, "no value before the tolerance"},
      {"1 ohm - 2 ohm", dimension::resistance, "a range is written"},
      {"1e308 ohm ± 100 %", dimension::resistance, "beyond the range of a double"},
  };
  for (const Case& c : cases) {
    const std::string message = find_message(c.text, c.unit);
    EXPECT_NE(message.find(c.part), std::string::npos) << c.text << ": " << message;
  }
  EXPECT_NE(find_message(std::string(400, '5'), dimension::none).find("400 characters"),
            std::string::npos);
}

}  // namespace
}  // namespace gyrator
