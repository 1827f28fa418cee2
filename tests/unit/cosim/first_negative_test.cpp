#include "gyrator/cosim/first_negative.hpp"

#include <algorithm>
#include <initializer_list>
#include <limits>

#include <gtest/gtest.h>

namespace gyrator {
namespace {

Eigen::VectorXd coefficients(std::initializer_list<double> values) {
  Eigen::VectorXd c(static_cast<Eigen::Index>(values.size()));
  std::copy(values.begin(), values.end(), c.data());
  return c;
}

// Rounding of a value near one, of which the polynomials here have a few.
constexpr double rounding = 8 * std::numeric_limits<double>::epsilon();

TEST(FindFirstNegative, a_line_is_below_zero_from_its_root_on) {
  EXPECT_NEAR(find_first_negative(coefficients({0.3, -1})), 0.3, rounding);
}

TEST(FindFirstNegative, none_is_found_where_all_is_above_or_at_zero) {
  EXPECT_EQ(find_first_negative(coefficients({1, -0.5})), 2);
  EXPECT_EQ(find_first_negative(coefficients({0, 0, 1})), 2);
  EXPECT_EQ(find_first_negative(coefficients({0.25, -1, 1})), 2);  // touches zero at a half
}

TEST(FindFirstNegative, the_earlier_of_two_roots_is_taken) {
  // (x - 0.2)(x - 0.9)
  EXPECT_NEAR(find_first_negative(coefficients({0.18, -1.1, 1})), 0.2, rounding / 0.7);
}

TEST(FindFirstNegative, a_dip_between_two_samples_is_found) {
  // (x - a)² - d², whose roots lie within one twelfth of the way: 0.54 ± 0.01.
  const double a = 0.54;
  const double d = 0.01;
  // Rounding of the value is 1/(2 d) times larger in x.
  EXPECT_NEAR(find_first_negative(coefficients({a * a - d * d, -2 * a, 1})), a - d,
              rounding / (2 * d));
}

}  // namespace
}  // namespace gyrator
