#include "gyrator/synthesis/preferred_values.hpp"

#include <algorithm>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

namespace gyrator {
namespace {

TEST(PreferredValues, EachSeriesIsCompleteAndRises) {
  const std::vector<std::pair<PreferredSeries, std::size_t>> sizes{
      {PreferredSeries::e12, 12}, {PreferredSeries::e24, 24}, {PreferredSeries::e96, 96}};
  for (const auto& [series, size] : sizes) {
    const auto& decade = list_decade(series);
    ASSERT_EQ(decade.size(), size);
    EXPECT_EQ(decade.front(), 1);
    for (std::size_t i = 0; i + 1 < size; ++i) EXPECT_LT(decade[i], decade[i + 1]);
  }
}

TEST(PreferredValues, NoGapOfASeriesIsWiderThanItsToleranceAllows) {
  // Neighbours a factor apart overlap with ± tolerance, but for what E12 and E24 lose by rounding
  // to two digits: half a digit of 1.0 … 2.7.
  const std::vector<std::pair<PreferredSeries, double>> steps{
      {PreferredSeries::e12, 1.25}, {PreferredSeries::e24, 1.155}, {PreferredSeries::e96, 1.031}};
  for (const auto& [series, largest] : steps) {
    auto decade = list_decade(series);
    decade.push_back(10);
    for (std::size_t i = 0; i + 1 < decade.size(); ++i)
      EXPECT_LE(decade[i + 1] / decade[i], largest) << decade[i];
  }
}

TEST(PreferredValues, EveryE12ValueIsOneOfE24) {
  const auto& e24 = list_decade(PreferredSeries::e24);
  for (const double value : list_decade(PreferredSeries::e12))
    EXPECT_TRUE(std::find(e24.begin(), e24.end(), value) != e24.end()) << value;
}

TEST(PreferredValues, ValuesOfARangeAreTheDoublesThatTheirTextReadsAs) {
  const auto values = list_preferred_values(PreferredSeries::e12, 330e-6, 680e-6);
  EXPECT_EQ(values, (std::vector<double>{330e-6, 390e-6, 470e-6, 560e-6, 680e-6}));
  EXPECT_TRUE(list_preferred_values(PreferredSeries::e12, 3.4, 3.8).empty());
  EXPECT_EQ(list_preferred_values(PreferredSeries::e96, 1, 9.99).size(), 96U);
}

TEST(PreferredValues, RoundedValuesHaveAllNumbersOfTheirDigits) {
  EXPECT_EQ(list_rounded_values(2, 0.095, 0.12),
            (std::vector<double>{0.095, 0.096, 0.097, 0.098, 0.099, 0.10, 0.11, 0.12}));
  EXPECT_EQ(list_rounded_values(3, 1, 9.99).size(), 900U);
}

}  // namespace
}  // namespace gyrator
