#include "gyrator/synthesis/pareto_front.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <string_view>

namespace gyrator {
namespace {

constexpr std::size_t levels = 40;

const DesignConstraint* find_inertia_bound(const DesignSpec& spec) {
  for (const DesignConstraint& constraint : spec.constraints)
    if (std::string_view(constraint.figure->name) == "apparent_inertia") return &constraint;
  return nullptr;
}

// By stiffness, with this bound in place of the spec's. What misses it goes before what misses any
// other constraint.
DesignMerit judge_within(const DesignSpec& spec, const DesignFigures& figures, double bound) {
  const DesignMerit merit = judge(spec, figures, find_inertia_bound(spec));
  if (!merit.feasible) return merit;
  const double excess = figures.apparent_inertia - bound;
  if (excess > 0) return {false, -1e-12 * excess / (std::abs(bound) + excess)};
  return {true, figures.max_stiffness};
}

class Sweep {
 public:
  Sweep(const DesignProblem& problem, const std::vector<Candidate>& found,
        const std::function<void(std::size_t)>& advance)
      : problem_(problem), advance_(advance), lattice_(problem.lattice()) {
    for (const auto& values : lattice_) sizes_.push_back(values.size());
    const bool is_lattice = problem.spec().series.has_value();
    for (const Candidate& candidate : found) {
      const LatticePoint point = nearest(candidate.values);
      if (is_lattice && candidate.figures.has_limits) known_.emplace(point, candidate.figures);
      if (!is_lattice && candidate.merit.feasible) look_at(point);
    }
  }

  void run() {
    const LatticePoint* start = nullptr;
    double lightest = HUGE_VAL;
    for (const auto& [point, figures] : known_) {
      if (!judge_within(problem_.spec(), figures, HUGE_VAL).feasible) continue;
      if (figures.apparent_inertia >= lightest) continue;
      lightest = figures.apparent_inertia;
      start = &point;
    }
    if (!start) return;
    // Lighter ones may be near: towards a bound that none keeps.
    LatticePoint point = climb(*start, lightest - 10 * std::abs(lightest));
    lightest = known_.at(point).apparent_inertia;
    const double heaviest = known_.at(climb(find_stiffest(), HUGE_VAL)).apparent_inertia;
    if (!(heaviest > lightest)) return;
    for (std::size_t i = 1; i < levels; ++i) {
      const double at = static_cast<double>(i) / (levels - 1);
      const double bound = lightest > 0 ? lightest * std::pow(heaviest / lightest, at)
                                        : lightest + (heaviest - lightest) * at;
      point = climb(point, bound);
    }
  }

  std::vector<Candidate> take() const {
    std::vector<Candidate> all;
    for (const auto& [point, figures] : known_) {
      all.push_back(
          {&problem_.option(), values_at(point), figures, judge(problem_.spec(), figures)});
    }
    return all;
  }

 private:
  std::vector<double> values_at(const LatticePoint& point) const {
    std::vector<double> values;
    for (std::size_t i = 0; i < point.size(); ++i) values.push_back(lattice_[i][point[i]]);
    return values;
  }
  LatticePoint nearest(const std::vector<double>& values) const {
    LatticePoint point;
    for (std::size_t i = 0; i < values.size(); ++i) {
      const auto at = std::lower_bound(lattice_[i].begin(), lattice_[i].end(), values[i]);
      point.push_back(
          std::min(static_cast<std::size_t>(at - lattice_[i].begin()), lattice_[i].size() - 1));
    }
    return point;
  }
  const DesignFigures& look_at(const LatticePoint& point) {
    const auto found = known_.find(point);
    if (found != known_.end()) return found->second;
    if (advance_) advance_(1);
    return known_
        .emplace(point, problem_.evaluate(values_at(point), LimitPrecision::on_grid,
                                          find_inertia_bound(problem_.spec())))
        .first->second;
  }
  LatticePoint find_stiffest() const {
    const auto merit = [&](const DesignFigures& figures) {
      return judge_within(problem_.spec(), figures, HUGE_VAL);
    };
    return std::max_element(
               known_.begin(), known_.end(),
               [&](const auto& a, const auto& b) { return merit(a.second) < merit(b.second); })
        ->first;
  }
  LatticePoint climb(const LatticePoint& start, double bound) {
    const auto merit = [&](const LatticePoint& point) {
      return judge_within(problem_.spec(), look_at(point), bound);
    };
    return climb_lattice(sizes_, start, sizes_.size() > 2 ? 1 : 2, merit).point;
  }

  const DesignProblem& problem_;
  const std::function<void(std::size_t)>& advance_;
  std::vector<std::vector<double>> lattice_;
  std::vector<std::size_t> sizes_;
  std::map<LatticePoint, DesignFigures> known_;
};

}  // namespace

std::vector<Candidate> sweep_inertia(const DesignProblem& problem,
                                     const std::vector<Candidate>& found,
                                     const std::function<void(std::size_t)>& advance) {
  Sweep sweep(problem, found, advance);
  sweep.run();
  return sweep.take();
}

std::vector<Candidate> find_pareto(const DesignSpec& spec, std::vector<Candidate> candidates) {
  std::erase_if(candidates, [&](const Candidate& candidate) {
    return !judge(spec, candidate.figures, find_inertia_bound(spec)).feasible;
  });
  std::sort(candidates.begin(), candidates.end(), [](const Candidate& a, const Candidate& b) {
    const auto& f = a.figures;
    const auto& g = b.figures;
    return f.apparent_inertia != g.apparent_inertia ? f.apparent_inertia < g.apparent_inertia
                                                    : f.max_stiffness > g.max_stiffness;
  });
  std::vector<Candidate> front;
  for (Candidate& candidate : candidates) {
    if (front.empty() || candidate.figures.max_stiffness > front.back().figures.max_stiffness)
      front.push_back(std::move(candidate));
  }
  if (front.size() <= levels) return front;
  std::vector<Candidate> thinned;
  for (std::size_t i = 0; i < levels; ++i)
    thinned.push_back(front[i * (front.size() - 1) / (levels - 1)]);
  return thinned;
}

}  // namespace gyrator
