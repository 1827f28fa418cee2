#include "gyrator/passivity/passive_walls.hpp"

#include "gyrator/core/error.hpp"
#include "gyrator/core/interrupt.hpp"

#include <algorithm>
#include <cmath>
#include <complex>

#include <fmt/core.h>

namespace gyrator {
namespace {

constexpr int first_sides = 8;
constexpr int most_halvings = 12;
constexpr int range_bisections = 18;

class Boundary {
 public:
  Boundary(StiffnessLimits& limits, const LawFamily& family, Criterion criterion)
      : limits_(limits), criterion_(criterion) {
    for (const double omega : limits.grid()) laws_.push_back(family.prepare(omega));
  }

  std::vector<WallPoint> trace() {
    if (!find(0).feasible) {
      throw Error(ErrorCode::bad_input, "controller",
                  fmt::format("no envelope: by {} not even the bare device is passive, K = B = 0",
                              name_of(criterion_)));
    }
    const double low = -find_end(-1);
    const double high = find_end(1);
    std::vector<WallPoint> points{{limit(low), low}};
    double peak = points.front().stiffness;
    std::vector<WallPoint> coarse = points;
    for (int i = 1; i <= first_sides; ++i) {
      const double damping = low + (high - low) * i / first_sides;
      coarse.push_back({limit(damping), damping});
      peak = std::max(peak, coarse.back().stiffness);
    }
    for (int i = 1; i <= first_sides; ++i)
      refine(points, coarse[static_cast<std::size_t>(i)], peak, most_halvings);
    return points;
  }

 private:
  StiffnessLimit find(double damping) {
    throw_if_interrupted("zwidth");
    return limits_.find(criterion_, damping);
  }

  double limit(double damping) {
    const StiffnessLimit found = find(damping);
    if (!found.feasible) return 0;
    if (!std::isfinite(found.stiffness)) {
      throw Error(ErrorCode::bad_input, "controller",
                  fmt::format("no envelope: at a virtual damping of {:.6g} {} allows any stiffness",
                              damping, name_of(criterion_)));
    }
    return found.stiffness;
  }

  // Whether K = 0 meets the disk with this B on the grid: necessary, and all that fails first next
  // to the edge of a passive range. There rounding makes minima without end, and refining each
  // would take most of the time.
  bool meets_grid(double damping) {
    if (criterion_ != Criterion::exact_disk) return find(damping).feasible;
    const auto& disks = limits_.disks();
    for (std::size_t i = 0; i < disks.size(); ++i) {
      const std::complex<double> law = laws_[i].output * damping * laws_[i].velocity;
      if (!(disks[i].damping_margin(law) > 0)) return false;
    }
    return true;
  }

  // How far B goes up (or down) from zero while K = 0 is passive.
  double find_end(double sign) {
    double most = 0;
    for (const double omega : limits_.grid())
      most = std::max(most, limits_.disk().model().at(omega).impedance.real());
    double good = 0;
    double bad = 1e-3 * most;
    bool on_grid = true;
    for (int doublings = 0;; ++doublings) {
      on_grid = meets_grid(sign * bad);
      // With a large B the disk may be met by a loop that is not stable.
      if (!on_grid || !find(sign * bad).feasible) break;
      if (doublings == 60) {
        throw Error(ErrorCode::bad_input, "controller",
                    fmt::format("no envelope: {} allows any virtual damping", name_of(criterion_)));
      }
      good = bad;
      bad *= 2;
    }
    for (int i = 0; i < range_bisections; ++i) {
      const double middle = (good + bad) / 2;
      const bool passive = on_grid ? find(sign * middle).feasible : meets_grid(sign * middle);
      (passive ? good : bad) = middle;
    }
    // Between the grid's points it may fail a little earlier.
    for (double inside = 1e-6; !find(sign * good).feasible; inside *= 4)
      good *= 1 - std::min(inside, 1.0);
    return good;
  }

  void refine(std::vector<WallPoint>& points, const WallPoint& end, double peak, int halvings) {
    const WallPoint start = points.back();
    const double damping = (start.damping + end.damping) / 2;
    const WallPoint middle{limit(damping), damping};
    const double chord = (start.stiffness + end.stiffness) / 2;
    if (halvings > 0 && std::abs(middle.stiffness - chord) > outline_tolerance * peak) {
      refine(points, middle, peak, halvings - 1);
      refine(points, end, peak, halvings - 1);
      return;
    }
    points.push_back(middle);
    points.push_back(end);
  }

  StiffnessLimits& limits_;
  Criterion criterion_;
  std::vector<LawFamily::Point> laws_;
};

}  // namespace

PassiveWalls trace_passive_walls(StiffnessLimits& limits, const LawFamily& family,
                                 Criterion criterion) {
  const std::vector<WallPoint> limit = Boundary(limits, family, criterion).trace();
  PassiveWalls walls;
  walls.outline = {{0, limit.front().damping}, {0, limit.back().damping}};
  walls.outline.insert(walls.outline.end(), limit.rbegin(), limit.rend());
  // The ends may lie on K = 0 already.
  const auto same = [](const WallPoint& a, const WallPoint& b) {
    return a.stiffness == b.stiffness && a.damping == b.damping;
  };
  walls.outline.erase(std::unique(walls.outline.begin(), walls.outline.end(), same),
                      walls.outline.end());
  return walls;
}

bool PassiveWalls::contains(const WallPoint& wall) const {
  bool inside = false;
  for (std::size_t i = 0; i < outline.size(); ++i) {
    const WallPoint& a = outline[i];
    const WallPoint& b = outline[(i + 1) % outline.size()];
    if ((a.damping > wall.damping) == (b.damping > wall.damping)) continue;
    const double share = (wall.damping - a.damping) / (b.damping - a.damping);
    if (wall.stiffness < a.stiffness + share * (b.stiffness - a.stiffness)) inside = !inside;
  }
  return inside;
}

double PassiveWalls::area() const {
  double area = 0;
  for (std::size_t i = 0; i < outline.size(); ++i) {
    WallPoint a = outline[i];
    WallPoint b = outline[(i + 1) % outline.size()];
    // The boundary runs from high to low damping; what lies left of B = 0 is cut off.
    if (a.damping < b.damping) std::swap(a, b);
    if (a.damping <= 0) continue;
    if (b.damping < 0) {
      const double share = a.damping / (a.damping - b.damping);
      b = {a.stiffness + share * (b.stiffness - a.stiffness), 0};
    }
    area += (a.damping - b.damping) * (a.stiffness + b.stiffness) / 2;
  }
  return area;
}

}  // namespace gyrator
