#include "gyrator/passivity/frequency_grid.hpp"

#include <algorithm>

#include <gtest/gtest.h>

#include "support/passivity_closed_forms.hpp"

namespace gyrator {
namespace {

using namespace passivity_tests;

constexpr double period = 1e-3;
constexpr double nyquist = pi / period;

Eigen::VectorXcd make_poles(std::vector<Complex> poles) {
  const std::size_t count = poles.size();
  for (std::size_t i = 0; i < count; ++i) poles.push_back(std::conj(poles[i]));
  return Eigen::Map<Eigen::VectorXcd>(poles.data(), static_cast<Eigen::Index>(poles.size()));
}

int count_within(const std::vector<double>& grid, double omega, double width) {
  return static_cast<int>(std::count_if(grid.begin(), grid.end(),
                                        [&](double at) { return std::abs(at - omega) <= width; }));
}

TEST(FrequencyGrid, ascends_from_far_below_the_slowest_pole_up_to_nyquist_itself) {
  const auto grid = make_judging_grid(make_poles({Complex(-2, 0), Complex(-300, 0)}), period);
  EXPECT_TRUE(std::is_sorted(grid.begin(), grid.end()));
  EXPECT_EQ(std::adjacent_find(grid.begin(), grid.end()), grid.end());
  EXPECT_NEAR(grid.front(), 2e-4, 1e-12);
  // The logarithmic part ends at Nyquist to a rounding of pow().
  EXPECT_NEAR(grid.back(), nyquist, 1e-12 * nyquist);
  EXPECT_LE(grid.back(), nyquist);
}

TEST(FrequencyGrid, has_no_gap_wider_than_a_thirtieth_of_a_decade_but_where_all_is_flat) {
  const auto grid = make_judging_grid(make_poles({Complex(-2, 0)}), period);
  for (std::size_t i = 1; i < grid.size(); ++i) {
    const double widest = grid[i] > 0.2 * (1 + 1e-9) ? 1.0 / 30 : 1.0 / 8;
    EXPECT_LE(grid[i] / grid[i - 1], std::pow(10.0, widest) * (1 + 1e-12)) << grid[i];
  }
}

TEST(FrequencyGrid, ignores_poles_at_zero_when_it_looks_for_the_slowest) {
  const auto grid = make_judging_grid(make_poles({Complex(0, 0), Complex(-50, 0)}), period);
  EXPECT_NEAR(grid.front(), 5e-3, 1e-12);
}

TEST(FrequencyGrid, is_dense_around_a_resonance_below_nyquist) {
  const double resonance = 0.3777 * nyquist;
  const double width = 1e-4 * resonance;
  const auto grid = make_judging_grid(make_poles({Complex(-width, resonance)}), period);
  EXPECT_GE(count_within(grid, resonance, 1.01 * width), 5);
}

TEST(FrequencyGrid, is_dense_where_a_resonance_beyond_nyquist_aliases_to) {
  struct Folded {
    double resonance, alias;  // in units of Nyquist
  };
  for (const Folded& f : {Folded{1.3, 0.7}, {2.4, 0.4}, {9.25, 0.75}, {38.9, 0.9}}) {
    const double width = 1e-5 * f.resonance * nyquist;
    const auto grid =
        make_judging_grid(make_poles({Complex(-width, f.resonance * nyquist)}), period);
    EXPECT_GE(count_within(grid, f.alias * nyquist, 1.01 * width), 5) << f.resonance;
  }
}

// A dip of the shape that a resonance gives, below a slope that hides it from a coarse search.
struct Dip {
  double at, width, depth;
  double operator()(double omega) const {
    return 1 + omega / nyquist - depth / (1 + std::pow((omega - at) / width, 2));
  }
};

TEST(FindMinimum, finds_planted_dips_down_to_their_bottom) {
  Random random(4);
  for (int i = 0; i < 200; ++i) {
    const double at = random.uniform(0.05, 0.99) * nyquist;
    const double width = random.log_uniform(1e-6, 1e-2) * nyquist;
    const Dip dip{at, width, random.uniform(1.5, 5)};
    // The pole that the grid is told lies beside the dip, so that no grid point hits its bottom.
    const auto grid = make_judging_grid(make_poles({Complex(-width, at + 0.23 * width)}), period);
    std::vector<double> values;
    for (const double omega : grid) values.push_back(dip(omega));
    const Minimum found = find_minimum(grid, values, dip);
    // The slope moves the bottom by width^2/(2 depth nyquist), well within the width; Brent leaves
    // sqrt(epsilon) of the frequency, which at the narrowest is 1.5e-8/1e-6 of the width.
    EXPECT_NEAR(found.omega, at, 0.02 * width) << width / nyquist;
    EXPECT_NEAR(found.value, dip(at), 1e-3 * dip.depth) << width / nyquist;
  }
}

TEST(FindMinimum, takes_the_end_of_the_grid_where_the_function_falls_towards_it) {
  const auto grid = make_judging_grid(make_poles({Complex(-1, 0)}), period);
  std::vector<double> values;
  const auto falling = [](double omega) { return 2 - omega / nyquist; };
  for (const double omega : grid) values.push_back(falling(omega));
  const Minimum found = find_minimum(grid, values, falling);
  EXPECT_EQ(found.omega, grid.back());
  EXPECT_EQ(found.value, values.back());
}

}  // namespace
}  // namespace gyrator
