#include "gyrator/synthesis/lattice_search.hpp"

#include <cmath>
#include <set>

#include <gtest/gtest.h>

namespace gyrator {
namespace {

// A tilted ridge that ends at a bound which is no line of the lattice, as that of a constraint.
DesignMerit ridge(const LatticePoint& at, double bound) {
  const auto x = static_cast<double>(at[0]);
  const auto y = static_cast<double>(at[1]);
  const double excess = x + 0.7 * y - bound;
  if (excess > 0) return {false, -excess};
  return {true, x + y - 0.3 * std::abs(x - 1.3 * y)};
}

LatticeResult search_all(const std::vector<std::size_t>& sizes, const LatticeMerit& merit) {
  LatticeResult best{{0, 0}, merit({0, 0})};
  for (std::size_t i = 0; i < sizes[0]; ++i) {
    for (std::size_t j = 0; j < sizes[1]; ++j) {
      const LatticePoint at{i, j};
      if (best.merit < merit(at)) best = {at, merit(at)};
    }
  }
  return best;
}

TEST(LatticeSearch, ClimbsToTheBestOfAllOnAConstrainedRidge) {
  const std::vector<std::size_t> sizes{30, 40};
  for (const double bound : {5.5, 12.2, 20.9, 33.3}) {
    const LatticeMerit merit = [&](const LatticePoint& at) { return ridge(at, bound); };
    const LatticeResult all = search_all(sizes, merit);
    for (const LatticePoint& start : {LatticePoint{0, 0}, {29, 39}, {3, 2}, {0, 39}}) {
      const LatticeResult found = climb_lattice(sizes, start, 2, merit);
      EXPECT_EQ(found.merit.feasible, all.merit.feasible);
      EXPECT_DOUBLE_EQ(found.merit.score, all.merit.score) << bound;
    }
  }
}

TEST(LatticeSearch, StaysInsideAndAsksForEachPointOnce) {
  std::set<LatticePoint> asked;
  const LatticeMerit merit = [&](const LatticePoint& at) {
    EXPECT_LT(at[0], 4U);
    EXPECT_LT(at[1], 3U);
    EXPECT_TRUE(asked.insert(at).second);
    return DesignMerit{true, static_cast<double>(at[0] + at[1])};
  };
  EXPECT_EQ(climb_lattice({4, 3}, {0, 0}, 1, merit).point, (LatticePoint{3, 2}));
}

TEST(LatticeSearch, WhatKeepsItsConstraintsGoesBeforeWhatDoesNot) {
  EXPECT_TRUE((DesignMerit{false, 100} < DesignMerit{true, -100}));
  EXPECT_TRUE((DesignMerit{false, -2} < DesignMerit{false, -1}));
  EXPECT_FALSE((DesignMerit{true, 1} < DesignMerit{true, 1}));
}

}  // namespace
}  // namespace gyrator
