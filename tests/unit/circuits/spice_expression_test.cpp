#include "gyrator/circuits/spice_expression.hpp"

#include "gyrator/circuits/spice_scope.hpp"

#include <cmath>
#include <string>

#include "unit/circuits/spice_bench.hpp"

namespace gyrator {
namespace {

double none(const std::string& name) {
  throw Error(ErrorCode::bad_input, "", "asked for " + name);
}

double number(std::string_view text) {
  const auto found = find_spice_number(text);
  if (!found) return std::nan("");
  EXPECT_EQ(found->length, text.size()) << text;
  return found->value;
}

double evaluate(std::string_view text) {
  return evaluate_spice_expression(text, "f:1", none);
}

TEST(SpiceExpression, suffixes_scale_the_decimal_text_exactly) {
  EXPECT_EQ(number("1t"), 1e12);
  EXPECT_EQ(number("2.5G"), 2.5e9);
  EXPECT_EQ(number("3Meg"), 3e6);
  EXPECT_EQ(number("4.7k"), 4.7e3);
  EXPECT_EQ(number("1M"), 1e-3) << "as in SPICE, in any case";
  EXPECT_EQ(number("2200u"), 2200e-6);
  EXPECT_EQ(number("10\u00B5"), 10e-6);
  EXPECT_EQ(number("47n"), 47e-9);
  EXPECT_EQ(number("33p"), 33e-12);
  EXPECT_EQ(number("1F"), 1e-15) << "a femto, not a farad";
  EXPECT_EQ(number("2mil"), 2 * 25.4e-6);
}

TEST(SpiceExpression, units_behind_a_number_mean_nothing) {
  EXPECT_EQ(number("10uF"), 10e-6);
  EXPECT_EQ(number("2.2kOhm"), 2200);
  EXPECT_EQ(number("5V"), 5);
  EXPECT_EQ(number("1k\u03A9"), 1000);
  EXPECT_EQ(number("1k\u2126"), 1000);
  EXPECT_EQ(number("1e3H"), 1e3);
  EXPECT_EQ(number("10MEGohm"), 10e6);
}

TEST(SpiceExpression, numbers_take_every_form) {
  EXPECT_EQ(number("1."), 1);
  EXPECT_EQ(number(".5"), 0.5);
  EXPECT_EQ(number("1.e3"), 1e3);
  EXPECT_EQ(number("-1.5e-3k"), -1.5);
  EXPECT_EQ(number("+2"), 2);
  EXPECT_EQ(number("2e+2"), 200);
  EXPECT_EQ(number("1e"), 1) << "a unit that begins with e";
}

TEST(SpiceExpression, a_suffix_may_stand_for_the_decimal_point) {
  EXPECT_EQ(number("4K7"), 4700);
  EXPECT_EQ(number("6k34"), 6340);
  EXPECT_EQ(number("2u2F"), 2.2e-6);
  EXPECT_EQ(number("1Meg5"), 1.5e6);
  EXPECT_EQ(find_spice_number("4.7k7")->length, 4U) << "two points";
  EXPECT_EQ(find_spice_number("4R7")->length, 2U) << "R is a unit, not a suffix";
}

TEST(SpiceExpression, what_is_no_number_is_none) {
  for (const char* text :
       {"", "k", "-", ".", "e3", "abc", "1e400", "1e99999999999", "nan", "inf"}) {
    EXPECT_FALSE(find_spice_number(text).has_value()) << text;
  }
}

TEST(SpiceExpression, arithmetic_has_the_usual_order) {
  EXPECT_EQ(evaluate("{1+2*3}"), 7);
  EXPECT_EQ(evaluate("'(1+2)*3'"), 9);
  EXPECT_EQ(evaluate("2**3**2"), 512) << "power binds to the right";
  EXPECT_EQ(evaluate("2^-2"), 0.25);
  EXPECT_EQ(evaluate("-2**2"), -4);
  EXPECT_EQ(evaluate("10k/4k"), 2.5);
  EXPECT_EQ(evaluate("1 - -1"), 2);
  EXPECT_EQ(evaluate("3 > 2 ? 10u : 1"), 10e-6);
  EXPECT_EQ(evaluate("1 <= 2 && 2 != 3"), 1);
}

TEST(SpiceExpression, functions_and_pi_are_those_of_mathematics) {
  // One rounding of each library function.
  EXPECT_DOUBLE_EQ(evaluate("2*PI*50"), 100 * std::numbers::pi);
  EXPECT_DOUBLE_EQ(evaluate("sqrt(2)"), std::sqrt(2));
  EXPECT_DOUBLE_EQ(evaluate("SIN(1)+cos(1)"), std::sin(1) + std::cos(1));
  EXPECT_DOUBLE_EQ(evaluate("ln(2)"), std::log(2));
  EXPECT_DOUBLE_EQ(evaluate("log(2)"), std::log(2)) << "natural, as in SPICE";
  EXPECT_DOUBLE_EQ(evaluate("log10(1k)"), 3);
  EXPECT_DOUBLE_EQ(evaluate("exp(1)"), std::exp(1));
  EXPECT_DOUBLE_EQ(evaluate("atan2(1, 2)"), std::atan2(1, 2));
  EXPECT_EQ(evaluate("min(3, 1, 2) + max(1, 5)"), 6);
  EXPECT_EQ(evaluate("abs(-2) + pow(2, 3) + sgn(-3)"), 9);
  EXPECT_EQ(evaluate("if(1 > 2, 7, 8)"), 8);
  EXPECT_EQ(evaluate("int(-2.7) + floor(-2.2) + ceil(2.2)"), -2);
}

TEST(SpiceExpression, what_is_no_expression_is_refused_with_place_and_text) {
  for (const char* text : {"{}", "", "1+", "(1", "1)", "1 2", "1,2", "1=3", "1..2", "2 % 3", "#",
                           "\"x\"", "1 \u20AC", "min()", "4R7"}) {
    EXPECT_TRUE(mentions(refusal([&] { evaluate(text); }), {"f:1: expression '"})) << text;
  }
  EXPECT_TRUE(mentions(refusal([] { evaluate("sqr(2)"); }),
                       {"f:1: ", "unknown function 'sqr'", "did you mean 'sqrt'?"}));
  EXPECT_TRUE(mentions(refusal([] { evaluate("{" + std::string(5000, '1') + "}"); }), {"5000"}));
}

TEST(SpiceExpression, a_result_that_is_not_finite_is_refused) {
  EXPECT_TRUE(mentions(refusal([] { evaluate("{1/0}"); }), {"f:1", "'1/0'", "finite"}));
  EXPECT_TRUE(mentions(refusal([] { evaluate("sqrt(-1)"); }), {"finite"}));
}

TEST(SpiceScope, parameters_refer_to_each_other_in_any_order) {
  SpiceScope scope;
  scope.define({"a", "2*b", "f:1"});
  scope.define({"b", "{c + 1}", "f:2"});
  scope.define({"c", "1k", "f:3"});
  EXPECT_EQ(scope.evaluate("{A}", "f:9"), 2002);
}

TEST(SpiceScope, a_circle_of_parameters_is_named) {
  SpiceScope scope;
  scope.define({"a", "b + 1", "f:1"});
  scope.define({"b", "2*c", "f:2"});
  scope.define({"c", "a", "f:3"});
  scope.define({"x", "b", "f:4"});
  EXPECT_EQ(refusal([&] { scope.evaluate("{x}", "f:9"); }),
            "f:2: parameter b depends on itself: b -> c -> a -> b");
}

TEST(SpiceScope, an_unknown_parameter_is_named_with_the_nearest_one) {
  SpiceScope outer;
  outer.define({"rload", "1", "f:1"});
  SpiceScope inner(&outer);
  EXPECT_EQ(refusal([&] { inner.evaluate("2*rlaod", "f:9"); }),
            "f:9: parameter 'rlaod' is not defined; did you mean 'rload'?");
}

TEST(SpiceScope, a_parameter_of_the_inner_scope_hides_the_outer_one) {
  SpiceScope outer;
  outer.define({"r", "1", "f:1"});
  outer.define({"s", "10*r", "f:2"});
  SpiceScope inner(&outer);
  inner.define({"r", "2", "f:3"});
  EXPECT_EQ(inner.evaluate("r", "f:9"), 2);
  EXPECT_EQ(inner.evaluate("s", "f:9"), 10) << "in the scope of its own definition";
}

TEST(SpiceScope, a_value_from_outside_goes_before_the_definition) {
  SpiceScope scope;
  scope.define({"r", "1", "f:1"});
  scope.define({"s", "10*r", "f:1"});
  scope.override_value("r", 3, "f:2");
  EXPECT_EQ(scope.evaluate("s", "f:9"), 30);
  EXPECT_EQ(scope.find_useless_override(), std::nullopt);
  scope.override_value("q", 3, "f:2");
  EXPECT_EQ(scope.find_useless_override(), "q");
  EXPECT_EQ(scope.evaluate("q", "f:9"), 3);
  EXPECT_EQ(scope.find_useless_override(), std::nullopt) << "asked for";
}

TEST(SpiceScope, names_are_unique_and_a_long_chain_ends) {
  SpiceScope scope;
  scope.define({"r", "1", "f:1"});
  EXPECT_EQ(refusal([&] {
              scope.define({"r", "2", "f:2"});
            }),
            "f:2: parameter r is defined a second time: first at f:1");
  scope.override_value("r", 1, "f:3");
  EXPECT_EQ(refusal([&] { scope.override_value("r", 1, "f:3"); }),
            "f:3: parameter r is given twice");
  for (int i = 0; i < 1000; ++i) {
    scope.define({"p" + std::to_string(i), "p" + std::to_string(i + 1), "f:4"});
  }
  EXPECT_TRUE(mentions(refusal([&] { scope.evaluate("p0", "f:9"); }), {"more than 200"}));
}

}  // namespace
}  // namespace gyrator
