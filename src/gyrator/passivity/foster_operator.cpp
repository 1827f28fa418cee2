#include "gyrator/passivity/foster_operator.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include <Eigen/Dense>

namespace gyrator {
namespace {

using Eigen::Index;

constexpr double nearest = 1e-5;
constexpr int rounds =
    4;  // the resonators' sides depend on the inertia found, which depends on them

// One attempt with given nearness; `inertia_free`: the inertia is solved for and the spring given.
class Attempt {
 public:
  Attempt(const std::vector<WantedReactance>& wanted, double nearness, double both,
          bool inertia_free)
      : wanted_(wanted),
        nearness_(nearness),
        base_(wanted.front().omega),
        given_(both * std::abs(wanted.front().reactance)),
        inertia_free_(inertia_free) {}

  std::optional<MassSpringDamper> solve() const {
    double free = (wanted_.front().reactance - given(base_)) / unit(base_);
    for (int round = 0; free >= 0 && round < rounds; ++round) {
      const std::vector<double> tuned = tune(free);
      const auto n = static_cast<Index>(wanted_.size());
      Eigen::MatrixXd equations(n, n);
      Eigen::VectorXd sought(n);
      for (Index row = 0; row < n; ++row) {
        const WantedReactance& point = wanted_[static_cast<std::size_t>(row)];
        sought(row) = point.reactance - given(point.omega);
        equations(row, 0) = unit(point.omega);
        for (Index i = 1; i < n; ++i) {
          const double pole = tuned[static_cast<std::size_t>(i)];
          equations(row, i) = point.omega / (pole * pole - point.omega * point.omega);
        }
      }
      const Eigen::VectorXd parts = equations.partialPivLu().solve(sought);
      if (parts.allFinite() && parts.minCoeff() >= 0) return assemble(parts, tuned);
      free = parts(0);
    }
    return std::nullopt;
  }

 private:
  // Reactance of the given part, and of the free one per unit of its reactance at the first point.
  double given(double omega) const {
    return inertia_free_ ? -given_ * base_ / omega : given_ * omega / base_;
  }
  double unit(double omega) const { return inertia_free_ ? omega / base_ : -base_ / omega; }

  std::vector<double> tune(double free) const {
    std::vector<double> tuned(wanted_.size(), 0);
    for (std::size_t i = 1; i < wanted_.size(); ++i) {
      const double at = wanted_[i].omega;
      double gap = at;
      for (std::size_t j = 0; j < wanted_.size(); ++j) {
        if (j != i) gap = std::min(gap, std::abs(wanted_[j].omega - at));
      }
      const bool raise = wanted_[i].reactance > given(at) + free * unit(at);
      tuned[i] = at + (raise ? 1 : -1) * nearness_ * gap;
    }
    return tuned;
  }

  MassSpringDamper assemble(const Eigen::VectorXd& parts, const std::vector<double>& tuned) const {
    MassSpringDamper held_by;
    held_by.inertia = (inertia_free_ ? parts(0) : given_) / base_;
    held_by.stiffness = (inertia_free_ ? given_ : parts(0)) * base_;
    for (Index i = 1; i < parts.size(); ++i) {
      const double pole = tuned[static_cast<std::size_t>(i)];
      if (parts(i) > 0) held_by.resonators.push_back({parts(i) / (pole * pole), parts(i)});
    }
    return held_by;
  }

  const std::vector<WantedReactance>& wanted_;
  double nearness_, base_, given_;
  bool inertia_free_;
};

}  // namespace

std::optional<MassSpringDamper> interpolate_reactances(const std::vector<WantedReactance>& wanted,
                                                       double nearness, double both) {
  for (const WantedReactance& point : wanted) {
    if (!std::isfinite(point.reactance)) return std::nullopt;
  }
  for (; nearness > nearest; nearness /= 2) {
    for (const bool inertia_free : {true, false}) {
      if (auto held_by = Attempt(wanted, nearness, both, inertia_free).solve()) return held_by;
    }
  }
  return std::nullopt;
}

}  // namespace gyrator
