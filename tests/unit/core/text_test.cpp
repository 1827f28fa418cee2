#include "gyrator/core/text.hpp"

#include <limits>
#include <string>

#include <gtest/gtest.h>

namespace gyrator {
namespace {

const std::vector<std::string> keys{"resistance", "inductance", "inertia", "damping", "delay"};

TEST(FindNearestName, finds_one_letter_missing_added_changed_or_swapped) {
  EXPECT_EQ(find_nearest_name("resistnce", keys), "resistance");
  EXPECT_EQ(find_nearest_name("resisttance", keys), "resistance");
  EXPECT_EQ(find_nearest_name("resistence", keys), "resistance");
  EXPECT_EQ(find_nearest_name("resitsance", keys), "resistance");
}

TEST(FindNearestName, swap_of_neighbours_counts_once) {
  EXPECT_EQ(find_nearest_name("dlea", {"dela"}), "dela");
  EXPECT_EQ(find_nearest_name("dxyz", {"dela"}), std::nullopt);
}

TEST(FindNearestName, case_is_free) {
  EXPECT_EQ(find_nearest_name("RESISTANCE", keys), "resistance");
}

TEST(FindNearestName, exact_name_wins_over_its_other_case) {
  EXPECT_EQ(find_nearest_name("mhz", {"MHz", "mhz"}), "mhz");
}

TEST(FindNearestName, unrelated_words_give_nothing) {
  EXPECT_EQ(find_nearest_name("capacitor", keys), std::nullopt);
  EXPECT_EQ(find_nearest_name("x", keys), std::nullopt);
  EXPECT_EQ(find_nearest_name("x", {"m"}), std::nullopt);
  EXPECT_EQ(find_nearest_name("", keys), std::nullopt);
  EXPECT_EQ(find_nearest_name("damping", {}), std::nullopt);
}

TEST(FindNearestName, three_edits_are_the_most_whatever_the_length) {
  EXPECT_EQ(find_nearest_name("temperature_coeff", {"temperature_coefxxx"}), "temperature_coefxxx");
  EXPECT_EQ(find_nearest_name("temperature_coef", {"temperature_coefxxxx"}), std::nullopt);
}

TEST(FindNearestName, overlong_word_is_not_compared) {
  EXPECT_EQ(find_nearest_name(std::string(100000, 'a'), keys), std::nullopt);
}

TEST(SuggestName, is_the_tail_of_a_message_or_empty) {
  EXPECT_EQ(suggest_name("dampng", keys), "; did you mean 'damping'?");
  EXPECT_EQ(suggest_name("colour", keys), "");
}

TEST(DescribeUnknownName, lists_what_is_allowed_and_the_nearest) {
  EXPECT_EQ(describe_unknown_name("engine", "cvod", {"exact", "cvode"}),
            "unknown engine 'cvod': allowed: exact, cvode; did you mean 'cvode'?");
}

TEST(Join, puts_the_separator_between) {
  EXPECT_EQ(join({}), "");
  EXPECT_EQ(join({"a"}), "a");
  EXPECT_EQ(join({"a", "b", "c"}), "a, b, c");
  EXPECT_EQ(join({"a", "b"}, " or "), "a or b");
}

TEST(FormatNumber, is_the_shortest_text_that_reads_back_the_same) {
  EXPECT_EQ(format_number(0.1), "0.1");
  EXPECT_EQ(format_number(2200e-6), "0.0022");
  EXPECT_EQ(format_number(1e300), "1e+300");
  for (const double value : {0.1 + 0.2, 1.0 / 3, -std::numeric_limits<double>::min(),
                             std::numeric_limits<double>::max()}) {
    EXPECT_EQ(std::stod(format_number(value)), value);
  }
}

TEST(FindDecimal, reads_sign_digits_point_and_exponent) {
  const auto decimal = find_decimal("-4.70e+3 kohm");
  ASSERT_TRUE(decimal);
  EXPECT_EQ(decimal->mantissa, "-4.70");
  EXPECT_EQ(decimal->exponent, 3);
  EXPECT_EQ(decimal->length, 8U);
  EXPECT_EQ(find_decimal("+5")->mantissa, "5");
  EXPECT_EQ(find_decimal(".5")->mantissa, ".5");
  EXPECT_EQ(find_decimal("2e-07")->exponent, -7);
}

TEST(FindDecimal, leaves_what_only_looks_like_an_exponent_or_a_fraction) {
  EXPECT_EQ(find_decimal("5e")->length, 1U);
  EXPECT_EQ(find_decimal("5em")->length, 1U);
  EXPECT_EQ(find_decimal("5e+")->length, 1U);
  EXPECT_EQ(find_decimal("5.m")->length, 1U);
  EXPECT_EQ(find_decimal("1.2.3")->length, 3U);
}

TEST(FindDecimal, clamps_an_exponent_that_no_integer_holds) {
  EXPECT_EQ(find_decimal("1e99999999999999999999")->exponent, 100000);
  EXPECT_EQ(find_decimal("1e-99999999999999999999")->exponent, -100000);
}

TEST(FindDecimal, needs_a_digit) {
  for (const char* text : {"", "-", "+", ".", "e5", "-.e3", "nan", "inf", "-inf", "--5", " 5"}) {
    EXPECT_FALSE(find_decimal(text)) << text;
  }
}

TEST(FindInvalidUtf8, accepts_each_length_at_both_ends_of_its_range) {
  EXPECT_EQ(find_invalid_utf8(""), std::nullopt);
  EXPECT_EQ(find_invalid_utf8("a\x7f \u0080\u07ff \u0800\uffff \U00010000\U0010ffff"),
            std::nullopt);
}

TEST(FindInvalidUtf8, tells_where_the_first_ill_formed_byte_is) {
  EXPECT_EQ(find_invalid_utf8("ab\xff"), 2U);            // no lead byte
  EXPECT_EQ(find_invalid_utf8("\x80"), 0U);              // continuation without a lead
  EXPECT_EQ(find_invalid_utf8("\xc0\xaf"), 0U);          // overlong '/'
  EXPECT_EQ(find_invalid_utf8("\xe0\x80\x80"), 0U);      // overlong, three bytes
  EXPECT_EQ(find_invalid_utf8("\xed\xa0\x80"), 0U);      // surrogate
  EXPECT_EQ(find_invalid_utf8("\xf4\x90\x80\x80"), 0U);  // above U+10FFFF
  EXPECT_EQ(find_invalid_utf8("x\xc3"), 1U);             // cut off
  EXPECT_EQ(find_invalid_utf8("x\xc3y"), 1U);
}

TEST(Count, has_the_singular_for_one_and_the_plural_for_all_others) {
  EXPECT_EQ(describe_count(1, "part"), "1 part");
  EXPECT_EQ(describe_count(3, "part"), "3 parts");
  EXPECT_EQ(describe_count(0, "part"), "0 parts");
  EXPECT_EQ(describe_count(1, "box", "boxes"), "1 box");
  EXPECT_EQ(describe_count(2, "box", "boxes"), "2 boxes");
}

TEST(RepeatedName, is_found_wherever_the_two_stand) {
  EXPECT_EQ(find_repeated({"a", "b", "a"}), "a");
  EXPECT_EQ(find_repeated({"a", "b", "c"}), std::nullopt);
  EXPECT_EQ(find_repeated({}), std::nullopt);
}

}  // namespace
}  // namespace gyrator
