#pragma once

#include <cstddef>
#include <functional>
#include <vector>

namespace gyrator {

/// How good a point is: those that meet all constraints go before those that do not, and among
/// equals the higher score is better (of those that do not, less is missing).
struct DesignMerit {
  bool feasible = false;
  double score = 0;

  friend bool operator<(const DesignMerit& a, const DesignMerit& b) {
    return a.feasible != b.feasible ? b.feasible : a.score < b.score;
  }
};

using LatticePoint = std::vector<std::size_t>;
using LatticeMerit = std::function<DesignMerit(const LatticePoint&)>;

struct LatticeResult {
  LatticePoint point;
  DesignMerit merit;
};

/// Climbs from `start` over a lattice of `sizes` to the best of all neighbours, those up to `reach`
/// steps away in every direction at once, until none is better; asks for the merit of each point
/// once. What it ends at is the best of its own neighbourhood, not of the whole lattice: start from
/// several points. Requires start within sizes.
LatticeResult climb_lattice(const std::vector<std::size_t>& sizes, const LatticePoint& start,
                            std::size_t reach, const LatticeMerit& merit);

}  // namespace gyrator
