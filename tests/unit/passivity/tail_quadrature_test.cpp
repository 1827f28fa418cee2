#include "gyrator/passivity/tail_quadrature.hpp"

#include <gtest/gtest.h>

namespace gyrator {
namespace {

Eigen::VectorXcd pair_of(double real, double imaginary) {
  Eigen::VectorXcd poles(2);
  poles << std::complex<double>(real, imaginary), std::complex<double>(real, -imaginary);
  return poles;
}

TEST(ResonantAliases, reach_to_twice_the_fastest_resonance) {
  constexpr double w_s = 1000;
  // |p| = 5000: up to 10 w_s, and the one beyond.
  EXPECT_EQ(count_resonant_aliases(pair_of(-3000, 4000), w_s), 11);
  Eigen::VectorXcd several(4);
  several << pair_of(-10, 700), pair_of(-3000, 4000);
  EXPECT_EQ(count_resonant_aliases(several, w_s), 11);
}

TEST(ResonantAliases, are_not_needed_for_what_is_smooth_over_a_sampling_frequency) {
  constexpr double w_s = 1000;
  EXPECT_EQ(count_resonant_aliases(Eigen::VectorXcd(), w_s), 1) << "no pole at all";
  EXPECT_EQ(count_resonant_aliases(pair_of(-5000, 0), w_s), 1) << "real poles";
  EXPECT_EQ(count_resonant_aliases(pair_of(-4001, 4001), w_s), 1) << "wider than 4 w_s";
  EXPECT_EQ(count_resonant_aliases(pair_of(-3000, 900), w_s), 1) << "does not ring";
}

TEST(ResonantAliases, are_at_most_a_million_however_fast_the_resonance) {
  EXPECT_EQ(count_resonant_aliases(pair_of(-1, 1e300), 1), 1000000);
}

}  // namespace
}  // namespace gyrator
