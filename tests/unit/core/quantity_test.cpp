#include "gyrator/core/quantity.hpp"

#include "gyrator/core/error.hpp"

#include <cmath>
#include <numbers>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

namespace gyrator {
namespace {

constexpr double pi = std::numbers::pi;

// The message of the bad_input that a text gives, or "no error".
std::string find_message(std::string_view text, const Unit& unit) {
  try {
    parse_value(text, unit);
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::bad_input);
    EXPECT_EQ(error.place(), "");
    return error.message();
  }
  return "no error";
}

::testing::AssertionResult has(const std::string& message, std::string_view part) {
  if (message.find(part) != std::string::npos) return ::testing::AssertionSuccess();
  return ::testing::AssertionFailure() << "'" << part << "' is not in: " << message;
}

TEST(ParseQuantity, powers_of_ten_are_exact) {
  // As doubles: 2200 * 1e-6 would be 0.0021999999999999997.
  EXPECT_EQ(parse_value("2200 uF", dimension::capacitance), 2200e-6);
  EXPECT_EQ(parse_value("4.7 kohm", dimension::resistance), 4.7e3);
  EXPECT_EQ(parse_value("0.5 mH", dimension::inductance), 0.5e-3);
  EXPECT_EQ(parse_value("50 mN.m/A", dimension::torque_constant), 0.05);
  EXPECT_EQ(parse_value("60 g", dimension::mass), 0.06);
  EXPECT_EQ(parse_value("0.39 %/K", dimension::temperature_coefficient), 0.0039);
  EXPECT_EQ(parse_value("2 N/mm", dimension::linear_stiffness), 2000.0);
  EXPECT_EQ(parse_value("1 %", dimension::none), 0.01);
}

TEST(ParseQuantity, each_prefix_has_its_power) {
  const std::vector<std::pair<std::string, double>> cases{
      {"3 pF", 3e-12}, {"3 nF", 3e-9},      {"3 uF", 3e-6}, {"3 \u00b5F", 3e-6},
      {"3 mF", 3e-3},  {"3 \u03bcF", 3e-6}, {"3 cF", 3e-2}, {"3 kF", 3e3},
      {"3 MF", 3e6},   {"3 GF", 3e9},       {"3 F", 3.0}};
  for (const auto& [text, value] : cases) {
    EXPECT_EQ(parse_value(text, dimension::capacitance), value) << text;
  }
}

TEST(ParseQuantity, whole_symbol_goes_before_prefix_and_symbol) {
  EXPECT_EQ(parse_value("1 m", dimension::length), 1.0);
  EXPECT_EQ(parse_value("1 mm", dimension::length), 1e-3);
  EXPECT_EQ(parse_value("1 min", dimension::time), 60.0);
  EXPECT_EQ(parse_value("1 cm", dimension::length), 1e-2);
  EXPECT_EQ(parse_value("1 kg", dimension::mass), 1.0);
  EXPECT_EQ(parse_value("5 ppm", dimension::none), 5e-6);
}

TEST(ParseQuantity, reads_all_ways_to_write_a_product) {
  for (const char* text : {"3 mN.m/A", "3 mN*m/A", "3 mN\u00b7m/A", "3mN.m/A", "3 N.mm/A",
                           "3 mN.m.A^-1", "3 mV.s/rad", "3 (mN.m)/A", "3 mJ/A"}) {
    EXPECT_EQ(parse_value(text, dimension::torque_constant), 3e-3) << text;
  }
  EXPECT_EQ(parse_value("2 kg.m\u00b2", dimension::inertia), 2.0);
  EXPECT_EQ(parse_value("2 kg.cm^2", dimension::inertia), 2e-4);
  EXPECT_EQ(parse_value("5 k\u03a9", dimension::resistance), 5000.0);
  EXPECT_EQ(parse_value("5 k\u2126", dimension::resistance), 5000.0);
  EXPECT_EQ(parse_value("5 ohms", dimension::resistance), 5.0);
  EXPECT_EQ(parse_value("0.004 K\u207b\u00b9", dimension::temperature_coefficient), 0.004);
  EXPECT_EQ(parse_value("0.004 1/K", dimension::temperature_coefficient), 0.004);
  EXPECT_EQ(parse_value("0.004/K", dimension::temperature_coefficient), 0.004);
}

TEST(ParseQuantity, slash_divides_by_the_next_factor_only) {
  EXPECT_EQ(parse_quantity("1 N.m/rad/s").dimension, parse_quantity("1 N.m/(rad.s)").dimension);
  EXPECT_EQ(parse_quantity("1 N.m/(rad/s)").dimension, parse_quantity("1 N.m.s/rad").dimension);
  EXPECT_NE(parse_quantity("1 N.m/rad/s").dimension, parse_quantity("1 N.m/(rad/s)").dimension);
  EXPECT_EQ(parse_value("2 N.m/(rad/s)", dimension::rotary_damping), 2.0);
}

TEST(ParseQuantity, fraction_is_a_number) {
  EXPECT_EQ(parse_value("1/60 s", dimension::time), 1.0 / 60);
  EXPECT_EQ(parse_value("1/4 ms", dimension::time), 0.25e-3);
  EXPECT_EQ(parse_value("1/8", dimension::none), 0.125);
  EXPECT_EQ(find_message("1/0 s", dimension::time),
            "'1/0 s': not a finite number, which a quantity must be");
}

TEST(ParseQuantity, bare_number_has_no_dimension_and_fits_all) {
  EXPECT_EQ(parse_quantity("0.001").dimension, std::nullopt);
  EXPECT_NE(parse_quantity("0.1 %").dimension, std::nullopt);
  for (const Unit& unit : dimension::all) EXPECT_EQ(parse_value(" -2.5e-3 ", unit), -2.5e-3);
}

TEST(ParseQuantity, every_unit_reads_its_own_symbol_and_example) {
  for (const Unit& unit : dimension::all) {
    EXPECT_EQ(parse_value("3 " + std::string(unit.symbol == "1" ? "" : unit.symbol), unit), 3.0)
        << unit.symbol;
    EXPECT_GT(parse_value(unit.example, unit), 0.0) << unit.example;
    EXPECT_NE(parse_quantity(unit.example).dimension, std::nullopt) << unit.example;
  }
}

TEST(ParseQuantity, refuses_by_name_what_is_not_finite) {
  for (const char* text : {"nan", "NaN ohm", "inf ohm", "-Infinity"}) {
    EXPECT_TRUE(has(find_message(text, dimension::resistance), "not a finite number")) << text;
  }
  EXPECT_TRUE(has(find_message("1e999 ohm", dimension::resistance), "range of a double"));
  EXPECT_TRUE(has(find_message("1e305 Gohm", dimension::resistance), "range of a double"));
}

TEST(ParseQuantity, says_what_is_wrong_with_a_unit) {
  const std::vector<std::pair<std::string, std::string>> cases{
      {"5 KOhm", "did you mean 'kohm'?"},
      {"5 kOHM", "did you mean 'kohm'?"},
      {"5 khz", "did you mean 'kHz'?"},
      {"5 ma", "did you mean 'mA'?"},
      {"5 RPM", "did you mean 'rpm'?"},
      {"5 Kg", "did you mean 'kg'?"},
      {"5 mNm/A", "symbols are joined with '.'; did you mean 'mN.m'?"},
      {"5 Nms/rad", "did you mean 'N.m.s'?"},
      {"0.4 Nm/rad", "symbols are joined with '.'; did you mean 'N.m'?"},
      {"5 Nmm", "did you mean 'N.mm'?"},
      {"5 ohn", "did you mean 'ohm'?"},
      {"5 sec", "did you mean 's'?"},
      {"25 \u00b0C", "a temperature is written in K"},
      {"25 degC", "a temperature is written in K"},
      {"5 xy", "unknown unit 'xy'"},
      {"5 N m", "a space in the unit"},
      {"1,5 ohm", "decimals are written with a point"},
      {"1 000 ohm", "two numbers"},
      {"5 m2", "a power is written as in 'm^2'"},
      {"5 m^", "a whole number is expected after '^'"},
      {"5 m^x", "a whole number is expected after '^'"},
      {"5 m^10", "a power of more than one digit"},
      {"5 N.", "the unit ends too early"},
      {"5 N./m", "does not belong into a unit"},
      {"5 (N.m", "the unit lacks a ')'"},
      {"5 N.m)", "there is no '('"},
      {"5 ()", "there is no '('"},
      {"5 $", "'$' does not belong into a unit"},
      {"ohm", "a number is expected first"},
      {"", "a number is expected first"},
      {"0x10", "unknown unit 'x'"},
  };
  for (const auto& [text, part] : cases) {
    const std::string message = find_message(text, dimension::resistance);
    EXPECT_TRUE(has(message, part)) << text;
    EXPECT_TRUE(has(message, "'" + text + "'"));
  }
}

TEST(ParseValue, suggests_the_unit_that_a_circuit_diagram_leaves_out) {
  const std::vector<std::tuple<std::string_view, Unit, std::string_view>> cases{
      {"5 k", dimension::resistance, "did you mean '5 kohm'?"},
      {"4k7", dimension::resistance, "did you mean '4.7 kohm'?"},
      {"4R7", dimension::resistance, "did you mean '4.7 ohm'?"},
      {"1 K", dimension::resistance, "did you mean '1 kohm'?"},
      {"2200u", dimension::capacitance, "did you mean '2200 uF'?"},
      {"2200\u00b5", dimension::capacitance, "did you mean '2200 uF'?"},
  };
  for (const auto& [text, unit, hint] : cases) EXPECT_TRUE(has(find_message(text, unit), hint));
  EXPECT_FALSE(has(find_message("5 k", dimension::none), "did you mean"));
  EXPECT_FALSE(has(find_message("5 V", dimension::resistance), "did you mean"));
}

TEST(ParseValue, speed_constant_is_told_from_the_torque_constant) {
  EXPECT_TRUE(has(find_message("200 rpm/V", dimension::torque_constant), "speed constant k_n"));
  EXPECT_TRUE(has(find_message("200 rpm/V", dimension::torque_constant), "1/k_n = 47.7465 mN.m/A"));
  EXPECT_TRUE(has(find_message("0.5 m/s/V", dimension::force_constant), "1/k_n = 2 N/A"));
  EXPECT_FALSE(has(find_message("200 rpm", dimension::torque_constant), "speed constant"));
}

TEST(ParseQuantity, does_not_guess_from_unrelated_letters) {
  EXPECT_EQ(find_message("5 furlong", dimension::length), "'5 furlong': unknown unit 'furlong'");
}

TEST(ParseQuantity, hostile_text_is_refused_at_once) {
  EXPECT_TRUE(has(find_message("1 " + std::string(100000, '('), dimension::time), "at most 100"));
  EXPECT_TRUE(has(find_message("1 " + std::string(98, '('), dimension::time), "ends too early"));
  EXPECT_TRUE(has(find_message(std::string(98, '9') + "e9", dimension::time), "no error"));
  EXPECT_TRUE(has(find_message("1 " + std::string(97, 'm'), dimension::time), "unknown unit"));
  std::string powers = "m";
  for (int i = 0; i < 20; ++i) powers = "(" + powers + ")^9";
  EXPECT_TRUE(has(find_message("1 " + powers, dimension::time), "power of more than two digits"));
  EXPECT_TRUE(has(find_message("1 (mm^9)^4", dimension::time), "power of more than two digits"));
  EXPECT_TRUE(has(find_message("1 (mm^9)^3", dimension::time), "a quantity in m^27"));
}

TEST(ValueIn, angle_is_ignored_where_it_distinguishes_nothing) {
  EXPECT_EQ(parse_value("2 N.m.s", dimension::rotary_damping), 2.0);
  EXPECT_EQ(parse_value("2 N.m.s/rad", dimension::rotary_damping), 2.0);
  EXPECT_EQ(parse_value("2 N.m", dimension::rotary_stiffness), 2.0);
  EXPECT_EQ(parse_value("2 V.s", dimension::torque_constant), 2.0);
}

TEST(ValueIn, angle_counts_for_pure_numbers_angles_and_angular_velocities) {
  EXPECT_TRUE(has(find_message("30 deg", dimension::none), "an angle [rad]: a pure number"));
  EXPECT_TRUE(has(find_message("5 %", dimension::angle), "a pure number: an angle [rad]"));
  EXPECT_DOUBLE_EQ(parse_value("30 deg", dimension::angle), pi / 6);
  EXPECT_DOUBLE_EQ(parse_value("30\u00b0", dimension::angle), pi / 6);
  EXPECT_DOUBLE_EQ(parse_value("60 rpm", dimension::angular_velocity), 2 * pi);
  EXPECT_DOUBLE_EQ(parse_value("2 rev/s", dimension::angular_velocity), 4 * pi);
}

TEST(ValueIn, frequency_with_an_angle_is_converted_to_cycles) {
  EXPECT_EQ(parse_value("100 Hz", dimension::frequency), 100.0);
  EXPECT_EQ(parse_value("100 1/s", dimension::frequency), 100.0);
  EXPECT_DOUBLE_EQ(parse_value("100 rad/s", dimension::frequency), 100 / (2 * pi));
  EXPECT_DOUBLE_EQ(parse_value("60 rpm", dimension::frequency), 1.0);
  EXPECT_DOUBLE_EQ(parse_value("3 rev/s", dimension::frequency), 3.0);
  EXPECT_TRUE(has(find_message("3 s/rad", dimension::frequency), "a frequency [Hz] is expected"));
}

TEST(ValueIn, hertz_is_ambiguous_as_an_angular_velocity) {
  EXPECT_EQ(find_message("2 Hz", dimension::angular_velocity),
            "'2 Hz': ambiguous as an angular velocity: write it in rad/s, rev/s or rpm");
}

TEST(ValueIn, encoder_step_may_be_given_as_a_resolution) {
  EXPECT_DOUBLE_EQ(parse_value("8192 counts/rev", dimension::angle_quantum), 2 * pi / 8192);
  EXPECT_DOUBLE_EQ(parse_value("1 count/deg", dimension::angle_quantum), pi / 180);
  EXPECT_EQ(parse_value("200 counts/mm", dimension::length_quantum), 5e-6);
  EXPECT_EQ(parse_value("5 um/count", dimension::length_quantum), 5e-6);
  EXPECT_EQ(parse_value("5 um", dimension::length_quantum), 5e-6);
  EXPECT_EQ(parse_value("0", dimension::length_quantum), 0.0);
}

TEST(ValueIn, resolution_must_be_of_the_right_motion_and_above_zero) {
  EXPECT_TRUE(has(find_message("8192 counts/rev", dimension::length_quantum), "is expected"));
  EXPECT_TRUE(has(find_message("200 counts/mm", dimension::angle_quantum), "is expected"));
  EXPECT_TRUE(has(find_message("0 counts/rev", dimension::angle_quantum), "must be above 0"));
  EXPECT_TRUE(has(find_message("-5 counts/rev", dimension::angle_quantum), "must be above 0"));
  EXPECT_TRUE(has(find_message("8192 counts/rev", dimension::angle), "is expected"));
  EXPECT_TRUE(has(find_message("8192 counts", dimension::angle_quantum), "is expected"));
}

TEST(ValueIn, message_tells_given_found_and_expected) {
  EXPECT_EQ(find_message("5 uF", dimension::resistance),
            "'5 uF': this is a capacitance [F]: a resistance [ohm] is expected, such as "
            "\"1.5 ohm\"");
  EXPECT_EQ(find_message("5 A.s", dimension::inductance),
            "'5 A.s': this is a quantity in s.A: an inductance [H] is expected, such as "
            "\"0.5 mH\"");
}

TEST(ValueIn, each_dimension_refuses_each_other_one) {
  for (const Unit& given : dimension::all) {
    for (const Unit& expected : dimension::all) {
      Dimension same_angle = given.dimension;
      same_angle.angle = expected.dimension.angle;
      // Alike but for the angle: some of these fit, as the tests above tell which.
      if (same_angle == expected.dimension) continue;
      const std::string text = given.symbol == "1" ? "3 %" : "3 " + std::string(given.symbol);
      EXPECT_THROW(parse_value(text, expected), Error) << text << " as " << expected.name;
    }
  }
}

TEST(FormatQuantity, uses_the_engineering_prefix) {
  EXPECT_EQ(format_quantity(2200e-6, dimension::capacitance), "2.2 mF");
  EXPECT_EQ(format_quantity(0.05, dimension::torque_constant), "50 mN.m/A");
  EXPECT_EQ(format_quantity(4700, dimension::resistance), "4.7 kohm");
  EXPECT_EQ(format_quantity(-1.5, dimension::resistance), "-1.5 ohm");
  EXPECT_EQ(format_quantity(1e-6, dimension::time), "1 us");
  EXPECT_EQ(format_quantity(0.06, dimension::mass), "60 g");
  EXPECT_EQ(format_quantity(60, dimension::mass), "60 kg");
}

TEST(FormatQuantity, never_shows_a_negative_zero) {
  EXPECT_EQ(format_quantity(-0.0, dimension::rotary_damping), "0 N.m.s/rad");
  EXPECT_EQ(format_quantity(-0.0, dimension::none), "0");
}

TEST(FormatQuantity, leaves_what_takes_no_prefix) {
  EXPECT_EQ(format_quantity(0, dimension::resistance), "0 ohm");
  EXPECT_EQ(format_quantity(0.05, dimension::none), "0.05");
  EXPECT_EQ(format_quantity(2e-5, dimension::inertia), "2e-05 kg.m^2");
  EXPECT_EQ(format_quantity(0.0039, dimension::temperature_coefficient), "0.0039 1/K");
  EXPECT_EQ(format_quantity(3600, dimension::time), "3600 s");
  EXPECT_EQ(format_quantity(1e-20, dimension::resistance), "1e-20 ohm");
  EXPECT_EQ(format_quantity(INFINITY, dimension::resistance), "inf ohm");
}

TEST(FormatQuantity, rounds_before_it_chooses_the_prefix) {
  EXPECT_EQ(format_quantity(0.9999999, dimension::voltage), "1 V");
  EXPECT_EQ(format_quantity(0.999999, dimension::voltage), "999.999 mV");
  EXPECT_EQ(format_quantity(999999.9, dimension::voltage), "1 MV");
}

TEST(FormatQuantity, reads_back_to_six_digits_in_every_unit) {
  for (const Unit& unit : dimension::all) {
    for (const double value : {1.23456e-13, 1.23456e-5, 0.123456, 1.0, 123.456, 1.23456e7, 1e12}) {
      const std::string text = format_quantity(value, unit);
      // Printed with six digits, so half a unit of the sixth is the error.
      EXPECT_NEAR(parse_value(text, unit), value, 5e-6 * value) << text;
    }
  }
}

}  // namespace
}  // namespace gyrator
