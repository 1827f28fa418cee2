#include "gyrator/synthesis/lattice_search.hpp"

#include <algorithm>
#include <map>

namespace gyrator {
namespace {

// Calls visit with every point of the box around `centre`.
void for_each_neighbour(const std::vector<std::size_t>& sizes, const LatticePoint& centre,
                        std::size_t reach, const std::function<void(const LatticePoint&)>& visit) {
  LatticePoint low = centre;
  LatticePoint high = centre;
  for (std::size_t i = 0; i < sizes.size(); ++i) {
    low[i] -= std::min(reach, centre[i]);
    high[i] = std::min(centre[i] + reach, sizes[i] - 1);
  }
  LatticePoint at = low;
  for (;;) {
    visit(at);
    std::size_t i = 0;
    while (i < at.size() && at[i] == high[i]) {
      at[i] = low[i];
      ++i;
    }
    if (i == at.size()) return;
    ++at[i];
  }
}

}  // namespace

LatticeResult climb_lattice(const std::vector<std::size_t>& sizes, const LatticePoint& start,
                            std::size_t reach, const LatticeMerit& merit) {
  std::map<LatticePoint, DesignMerit> known;
  const auto merit_at = [&](const LatticePoint& point) {
    const auto found = known.find(point);
    return found != known.end() ? found->second : known.emplace(point, merit(point)).first->second;
  };
  LatticeResult best{start, merit_at(start)};
  for (bool moved = true; moved;) {
    moved = false;
    for_each_neighbour(sizes, LatticePoint(best.point), reach, [&](const LatticePoint& point) {
      const DesignMerit found = merit_at(point);
      if (!(best.merit < found)) return;
      best = {point, found};
      moved = true;
    });
  }
  return best;
}

}  // namespace gyrator
