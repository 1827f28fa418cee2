#include "gyrator/core/statistics.hpp"

#include "gyrator/core/error.hpp"

#include <cmath>
#include <limits>
#include <vector>

#include <gtest/gtest.h>

namespace gyrator {
namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();

TEST(Quantile, is_the_smallest_value_that_covers_the_share) {
  const std::vector<double> values{1, 2, 3, 4};
  EXPECT_EQ(find_quantile(values, 0), 1);
  EXPECT_EQ(find_quantile(values, 0.25), 1);
  EXPECT_EQ(find_quantile(values, 0.26), 2);
  EXPECT_EQ(find_quantile(values, 0.5), 2);
  EXPECT_EQ(find_quantile(values, 1), 4);
  EXPECT_EQ(find_quantile(std::vector<double>{1, infinity}, 0.9), infinity);
  EXPECT_THROW(find_quantile({}, 0.5), Error);
}

// The ends solve |k - n P| = z sqrt(n P (1 - P)), which is what Wilson's interval says.
TEST(Share, ends_of_the_interval_are_z_deviations_away) {
  constexpr double z = 1.959963984540054;
  for (const auto& [k, n] : std::vector<std::pair<int, int>>{{1, 10}, {7, 10}, {990, 1000}}) {
    const Share share = compute_share(static_cast<std::size_t>(k), static_cast<std::size_t>(n));
    EXPECT_DOUBLE_EQ(share.value, static_cast<double>(k) / n);
    for (const double P : {share.low, share.high})
      EXPECT_NEAR(std::abs(k - n * P), z * std::sqrt(n * P * (1 - P)), 1e-9 * n) << k << "/" << n;
    EXPECT_LT(share.low, share.value);
    EXPECT_GT(share.high, share.value);
  }
}

TEST(Share, of_all_or_none_has_one_open_side) {
  constexpr double z2 = 3.841458820694124;  // z^2
  const Share all = compute_share(100, 100);
  EXPECT_EQ(all.high, 1);
  EXPECT_NEAR(all.low, 100 / (100 + z2), 1e-12);
  const Share none = compute_share(0, 100);
  EXPECT_EQ(none.low, 0);
  EXPECT_NEAR(none.high, z2 / (100 + z2), 1e-12);
  EXPECT_THROW(compute_share(0, 0), Error);
}

TEST(RankCorrelation, knows_order_only) {
  const std::vector<double> x{1, 2, 3, 4, 5};
  EXPECT_DOUBLE_EQ(compute_rank_correlation(x, std::vector<double>{1, 8, 27, 64, infinity}), 1);
  EXPECT_DOUBLE_EQ(compute_rank_correlation(x, std::vector<double>{5, 4, 3, 2, -infinity}), -1);
  EXPECT_EQ(compute_rank_correlation(x, std::vector<double>(5, 7.0)), 0);
  // Ranks 0, 1.5, 1.5, 3 against 0, 1, 2, 3: covariance 4.5, variances 4.5 and 5.
  EXPECT_DOUBLE_EQ(
      compute_rank_correlation(std::vector<double>{1, 2, 2, 3}, std::vector<double>{1, 2, 3, 4}),
      4.5 / std::sqrt(4.5 * 5));
}

}  // namespace
}  // namespace gyrator
