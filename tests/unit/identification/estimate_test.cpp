#include "gyrator/identification/estimate.hpp"

#include <cmath>

#include <gtest/gtest.h>

namespace gyrator {
namespace {

// Of every table of Student's t.
TEST(Estimate, QuantilesAreThoseOfTheTables) {
  EXPECT_NEAR(find_student_quantile(0.995, 1), 63.657, 5e-4);
  EXPECT_NEAR(find_student_quantile(0.995, 9), 3.2498, 5e-5);
  EXPECT_NEAR(find_student_quantile(0.975, 1e6), 1.95996, 1e-5);
}

TEST(Estimate, AnIntervalIsSymmetricAboutTheValue) {
  const Interval interval = find_interval({10, 2, 9});
  EXPECT_NEAR(interval.high - 10, 2 * 3.2498, 1e-4);
  EXPECT_NEAR(10 - interval.low, interval.high - 10, 1e-12);
}

TEST(Estimate, AProductAddsRelativeVariances) {
  const Estimate product = multiply({2, 0.02, 10}, {5, 0.1, 10});
  EXPECT_DOUBLE_EQ(product.value, 10);
  EXPECT_NEAR(product.deviation, 10 * std::hypot(0.01, 0.02), 1e-12);
  // s^4 = (1 + 4)^2, shares 1 and 16
  EXPECT_NEAR(product.degrees, 25 * 10 / 17.0, 1e-9);
}

TEST(Estimate, AnErrorOfKnownSizeMakesTheDegreesOfFreedomMany) {
  const Estimate wider = add_error({1, 0.1, 5}, 1);
  EXPECT_NEAR(wider.deviation, std::hypot(0.1, 1), 1e-12);
  EXPECT_GT(wider.degrees, 500);
  EXPECT_EQ(add_error({1, 0.1, 5}, 0).degrees, 5);
}

}  // namespace
}  // namespace gyrator
