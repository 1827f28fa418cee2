#include "gyrator/regression/figure_check.hpp"

#include <limits>
#include <string>

#include <gtest/gtest.h>

namespace gyrator {
namespace {

using nlohmann::json;

std::string reason(const json& value, const json& reference, const FigureTolerance& tolerance) {
  const auto difference = find_difference(value, reference, tolerance, "N/m", "baseline");
  return difference ? difference->reason : "";
}

bool differs(const json& value, const json& reference, const FigureTolerance& tolerance) {
  return !reason(value, reference, tolerance).empty();
}

// Powers of two, so that limits are met exactly.
constexpr double just = 0x1p-40;

TEST(FigureCheck, AnAbsoluteToleranceHoldsUpToItsLimitOnBothSides) {
  const FigureTolerance tolerance{.absolute = 0.25};
  for (const double side : {1.0, -1.0}) {
    EXPECT_FALSE(differs(2 + side * 0.25, 2, tolerance));
    EXPECT_TRUE(differs(2 + side * (0.25 + just), 2, tolerance));
  }
}

TEST(FigureCheck, ARelativeToleranceIsAShareOfTheReferencesMagnitude) {
  const FigureTolerance tolerance{.relative = 0.125};
  for (const double reference : {16.0, -16.0}) {
    EXPECT_FALSE(differs(reference + 2, reference, tolerance));
    EXPECT_FALSE(differs(reference - 2, reference, tolerance));
    EXPECT_TRUE(differs(reference + 2 + just, reference, tolerance));
    EXPECT_TRUE(differs(reference - 2 - just, reference, tolerance));
  }
}

TEST(FigureCheck, AbsoluteAndRelativeAdd) {
  const FigureTolerance tolerance{.absolute = 1, .relative = 0.125};
  EXPECT_FALSE(differs(19, 16, tolerance));
  EXPECT_TRUE(differs(19 + just, 16, tolerance));
}

TEST(FigureCheck, WithoutAToleranceOnlyTheSameNumberPasses) {
  EXPECT_FALSE(differs(0.1, 0.1, {}));
  EXPECT_TRUE(differs(0.1 + 1e-16, 0.1, {}));
}

TEST(FigureCheck, OnlyTheSideThatCountsIsARegression) {
  const FigureTolerance below{.relative = 0.125, .side = Side::below};
  EXPECT_FALSE(differs(1000, 16, below));
  EXPECT_FALSE(differs(14, 16, below));
  EXPECT_TRUE(differs(14 - just, 16, below));
  const FigureTolerance above{.relative = 0.125, .side = Side::above};
  EXPECT_FALSE(differs(-1000, 16, above));
  EXPECT_FALSE(differs(18, 16, above));
  EXPECT_TRUE(differs(18 + just, 16, above));
}

TEST(FigureCheck, WhatIsNoNumberAnyMoreIsADifferenceWithAnyTolerance) {
  const FigureTolerance wide{.absolute = 1e300, .side = Side::below};
  EXPECT_NE(reason(nullptr, 2, wide).find("no number any more, baseline 2 N/m"), std::string::npos);
  EXPECT_TRUE(differs(2, nullptr, wide));
  EXPECT_FALSE(differs(nullptr, nullptr, wide));
  EXPECT_TRUE(differs("2", 2, wide));
  EXPECT_TRUE(differs(std::numeric_limits<double>::quiet_NaN(), 2, wide));
}

TEST(FigureCheck, TextsAndBooleansMustBeEqual) {
  EXPECT_FALSE(differs("passive", "passive", {}));
  EXPECT_EQ(reason("not_passive", "passive", {}), "not_passive, baseline passive");
  EXPECT_TRUE(differs(true, false, {.absolute = 2}));
}

TEST(FigureCheck, OfAListTheWorstItemIsTold) {
  const FigureTolerance tolerance{.relative = 0.01};
  EXPECT_FALSE(differs({1, 2, 3}, {1, 2, 3}, tolerance));
  const std::string text = reason({1, 2.1, 4}, {1, 2, 3}, tolerance);
  EXPECT_NE(text.find("[2]: 4 N/m, baseline 3 N/m ± 1 %: 33.3 % higher"), std::string::npos)
      << text;
  EXPECT_NE(reason({1, 2}, {1, 2, 3}, tolerance).find("2 values, baseline 3"), std::string::npos);
  EXPECT_TRUE(differs(json::array({json::array({1})}), json::array({json::array({2})}), tolerance));
}

TEST(FigureCheck, TheReasonTellsBothValuesApart) {
  EXPECT_EQ(reason(15.2, 15.84, {.relative = 1e-6}),
            "15.2 N/m, baseline 15.84 N/m ± 0.0001 %: 4.04 % lower");
  const std::string text = reason(1.00000001, 1, {});
  EXPECT_NE(text.find("1.00000001 N/m, baseline 1 N/m exactly: 1e-06 % higher"), std::string::npos)
      << text;
}

TEST(FigureCheck, BoundsIncludeTheirEndsAndRefuseWhatIsNoNumber) {
  Expectation bounds;
  bounds.at_least = 1;
  bounds.at_most = 2;
  EXPECT_FALSE(find_violation(1, bounds));
  EXPECT_FALSE(find_violation(2, bounds));
  EXPECT_TRUE(find_violation(1 - just, bounds));
  EXPECT_TRUE(find_violation(2 + just, bounds));
  EXPECT_TRUE(find_violation(nullptr, bounds));
  EXPECT_TRUE(find_violation("1.5", bounds));
  EXPECT_TRUE(find_violation(std::numeric_limits<double>::quiet_NaN(), bounds));
  const auto violation = find_violation({1.5, 3}, bounds);
  ASSERT_TRUE(violation);
  EXPECT_EQ(violation->reason, "[1]: 3: at most 2 is expected");
}

TEST(FigureCheck, EqualsIsOfEveryItemUnlessItIsAListItself) {
  Expectation expectation;
  expectation.equals = "passive";
  EXPECT_FALSE(find_violation({"passive", "passive"}, expectation));
  EXPECT_TRUE(find_violation({"passive", "not_passive"}, expectation));
  expectation.equals = json({"passive", "not_passive"});
  EXPECT_FALSE(find_violation({"passive", "not_passive"}, expectation));
  EXPECT_TRUE(find_violation(json::array({"passive"}), expectation));
}

TEST(FigureCheck, AnEmptyListKeepsNothingThatIsExpectedOfItsItems) {
  Expectation equals, none, bound;
  equals.equals = "passive";
  none.is_none = true;
  bound.at_most = 2;
  for (const Expectation& expectation : {equals, none, bound}) {
    const auto violation = find_violation(json::array(), expectation);
    ASSERT_TRUE(violation);
    EXPECT_EQ(violation->reason, "an empty list: at least one value is expected");
  }
  // Of a run that varies, one point's list.
  const auto inner = find_violation(json::array({json::array({1}), json::array()}), bound);
  ASSERT_TRUE(inner);
  EXPECT_EQ(inner->reason, "[1]: an empty list: at least one value is expected");
  EXPECT_EQ(inner->item, 1U);
  equals.equals = json::array();
  EXPECT_FALSE(find_violation(json::array(), equals));  // said so
  EXPECT_FALSE(find_violation(json::array(), Expectation{}));
}

TEST(FigureCheck, ADifferenceHasTheIndexOfItsItemAndNoneOfAListAsAWhole) {
  const auto find = [](const json& value, const json& reference) {
    return find_difference(value, reference, {}, "", "baseline").value();
  };
  EXPECT_EQ(find({1, 2, 4}, {1, 2, 3}).item, 2U);
  EXPECT_EQ(find(json::array({{1, 2}, {3, 5}}), json::array({{1, 2}, {3, 4}})).item, 1U);
  // These reasons begin with '[' too.
  EXPECT_FALSE(find({"passive", "passive"}, "passive").item);
  EXPECT_FALSE(find({0.5, 1}, nullptr).item);
}

TEST(FigureCheck, NoneIsTheAnswersNull) {
  Expectation expectation;
  expectation.is_none = true;
  EXPECT_FALSE(find_violation(nullptr, expectation));
  EXPECT_TRUE(find_violation(0, expectation));
}

}  // namespace
}  // namespace gyrator
