#include "gyrator/core/random_stream.hpp"

#include <cmath>
#include <vector>

#include <gtest/gtest.h>

namespace gyrator {
namespace {

constexpr int count = 100000;
// A mean of `count` independent numbers is normal to all that matters here; beyond five of its
// standard deviations lies one seed in two million, and the seeds are fixed.
constexpr double deviations = 5;

TEST(RandomStream, gives_the_same_numbers_everywhere) {
  // The exact values of this seed: another standard library or machine must give them too.
  RandomStream stream(1, 1);
  EXPECT_EQ(stream.uniform(), 0x1.c41664bccfccap-2);
  EXPECT_EQ(stream.normal(), 0x1.3fb1688d7ad8cp-1);
}

TEST(RandomStream, normal_numbers_have_the_moments_of_the_normal_law) {
  RandomStream stream(7, 3);
  double sum = 0;
  double squares = 0;
  double fourths = 0;
  for (int i = 0; i < count; ++i) {
    const double x = stream.normal();
    sum += x;
    squares += x * x;
    fourths += x * x * x * x;
  }
  // Variances of one term: of x 1, of x^2 2, of x^4 105 - 9.
  EXPECT_NEAR(sum / count, 0, deviations * std::sqrt(1.0 / count));
  EXPECT_NEAR(squares / count, 1, deviations * std::sqrt(2.0 / count));
  EXPECT_NEAR(fourths / count, 3, deviations * std::sqrt(96.0 / count));
}

TEST(RandomStream, uniform_numbers_fill_the_unit_interval_evenly) {
  RandomStream stream(7, 3);
  std::vector<int> bins(10);
  for (int i = 0; i < count; ++i) {
    const double x = stream.uniform();
    ASSERT_GE(x, 0);
    ASSERT_LT(x, 1);
    ++bins[static_cast<std::size_t>(10 * x)];
  }
  for (const int bin : bins) EXPECT_NEAR(bin, count / 10.0, deviations * std::sqrt(0.09 * count));
}

TEST(RandomStream, symmetric_integers_reach_both_ends_and_no_further) {
  RandomStream stream(2, 2);
  std::vector<int> bins(5);
  for (int i = 0; i < 1000; ++i) {
    const auto n = stream.symmetric_integer(2);
    ASSERT_LE(std::abs(n), 2);
    ++bins[static_cast<std::size_t>(n + 2)];
  }
  for (const int bin : bins) EXPECT_NEAR(bin, 200, deviations * std::sqrt(1000 * 0.2 * 0.8));
}

TEST(RandomStream, streams_and_seeds_differ_and_are_not_correlated) {
  RandomStream one(1, 1);
  RandomStream same(1, 1);
  RandomStream other_stream(1, 2);
  RandomStream other_seed(2, 1);
  double with_stream = 0;
  double with_seed = 0;
  for (int i = 0; i < count; ++i) {
    const double x = one.normal();
    ASSERT_EQ(x, same.normal());
    with_stream += x * other_stream.normal();
    with_seed += x * other_seed.normal();
  }
  // A product of two independent normal numbers has variance 1.
  EXPECT_NEAR(with_stream / count, 0, deviations * std::sqrt(1.0 / count));
  EXPECT_NEAR(with_seed / count, 0, deviations * std::sqrt(1.0 / count));
}

}  // namespace
}  // namespace gyrator
