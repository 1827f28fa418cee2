#include "gyrator/synthesis/design_search.hpp"

#include "gyrator/core/random_stream.hpp"
#include "gyrator/studies/parallel.hpp"

#include <algorithm>
#include <cmath>
#include <exception>
#include <set>

#include <nlopt.hpp>

namespace gyrator {
namespace {

constexpr std::size_t scan_points = 400;
constexpr int global_steps = 300;  // for each variable
constexpr int local_steps = 100;
constexpr std::size_t lattice_starts = 6;
constexpr std::size_t lattice_reach = 2;

bool is_better(const Candidate& a, const Candidate& b) {
  return b.merit < a.merit;
}

class Searcher {
 public:
  Searcher(const DesignProblem& problem, const DesignConstraint* free,
           const std::function<void(std::size_t)>& advance)
      : problem_(problem), free_(free), advance_(advance) {
    for (const SoughtValue& value : problem.option().values) {
      low_.push_back(std::log(value.range.low));
      high_.push_back(std::log(value.range.high));
    }
  }

  OptionSearch run() {
    scan();
    const int n = static_cast<int>(problem_.size());
    optimize(nlopt::GN_CRS2_LM, global_steps * n);
    optimize(nlopt::LN_SBPLX, local_steps * n);
    refine_on_mesh();
    result_.continuous = best_of(result_.seen);
    if (problem_.spec().series) {
      climb();
      result_.best = best_of(result_.on_lattice);
    } else {
      result_.on_lattice = result_.seen;
      result_.best = result_.continuous;
    }
    return std::move(result_);
  }

 private:
  static const Candidate& best_of(const std::vector<Candidate>& candidates) {
    return *std::min_element(candidates.begin(), candidates.end(), is_better);
  }

  Candidate make_candidate(std::vector<double> values) const {
    Candidate candidate{&problem_.option(), std::move(values), {}, {}};
    candidate.figures = problem_.evaluate(candidate.values, LimitPrecision::on_grid, free_);
    candidate.merit = judge(problem_.spec(), candidate.figures, free_);
    return candidate;
  }
  const Candidate& look_at(const std::vector<double>& values) {
    result_.seen.push_back(make_candidate(values));
    if (advance_) advance_(1);
    return result_.seen.back();
  }
  std::vector<double> values_at(const std::vector<double>& x) const {
    std::vector<double> values;
    for (std::size_t i = 0; i < x.size(); ++i) {
      const auto [low, high] = problem_.option().values[i].range;
      values.push_back(std::clamp(std::exp(x[i]), low, high));  // the ends without rounding
    }
    return values;
  }
  std::vector<double> logarithms_of(const Candidate& candidate) const {
    std::vector<double> x;
    for (std::size_t i = 0; i < candidate.values.size(); ++i)
      x.push_back(std::clamp(std::log(candidate.values[i]), low_[i], high_[i]));
    return x;
  }

  void scan() {
    const std::size_t n = problem_.size();
    const auto side = static_cast<std::size_t>(
        std::lround(std::pow(static_cast<double>(scan_points), 1.0 / static_cast<double>(n))));
    std::size_t count = 1;
    for (std::size_t i = 0; i < n; ++i) count *= side;
    std::vector<Candidate> found(count);
    run_parallel(count, 0, [&](std::size_t index) {
      RandomStream random(problem_.spec().seed, index);
      std::vector<double> x(n);
      std::size_t rest = index;
      for (std::size_t i = 0; i < n; ++i) {
        const double at = static_cast<double>(rest % side) + random.uniform();
        rest /= side;
        x[i] = low_[i] + (high_[i] - low_[i]) * at / static_cast<double>(side);
      }
      found[index] = make_candidate(values_at(x));
      if (advance_) advance_(1);
    });
    result_.seen = std::move(found);
  }

  // Infeasible points lie below all feasible ones, by what they miss; NLopt minimizes.
  static double cost_of(const DesignMerit& merit) {
    return merit.feasible ? -std::min(merit.score, 1e12) : 1e15 * (1 - merit.score);
  }
  static double evaluate(const std::vector<double>& x, std::vector<double>&, void* data) {
    auto& searcher = *static_cast<Searcher*>(data);
    try {
      return cost_of(searcher.look_at(searcher.values_at(x)).merit);
    } catch (...) {  // nothing may be thrown through NLopt
      searcher.failure_ = std::current_exception();
      searcher.optimizer_.force_stop();
      return HUGE_VAL;
    }
  }
  void optimize(nlopt::algorithm algorithm, int steps) {
    std::vector<double> x = logarithms_of(best_of(result_.seen));
    optimizer_ = nlopt::opt(algorithm, static_cast<unsigned>(x.size()));
    nlopt::srand(static_cast<unsigned long>(problem_.spec().seed + 1));  // 0 would mean the clock
    optimizer_.set_min_objective(&Searcher::evaluate, this);
    optimizer_.set_lower_bounds(low_);
    optimizer_.set_upper_bounds(high_);
    optimizer_.set_xtol_abs(1e-5);
    optimizer_.set_maxeval(steps);
    if (algorithm == nlopt::LN_SBPLX) optimizer_.set_initial_step(0.1);
    double cost = 0;
    try {
      optimizer_.optimize(x, cost);
    } catch (const nlopt::forced_stop&) {
      if (failure_) std::rethrow_exception(failure_);
    } catch (const nlopt::roundoff_limited&) {
      // All that it looked at is kept.
    }
  }

  void refine_on_mesh() {
    constexpr std::size_t half = 50;
    for (double step = 0.05; step > 1e-4; step /= 3) {
      const std::vector<double> centre = logarithms_of(best_of(result_.seen));
      const auto merit = [&](const LatticePoint& point) {
        std::vector<double> x = centre;
        for (std::size_t i = 0; i < x.size(); ++i) {
          const double steps = static_cast<double>(point[i]) - static_cast<double>(half);
          x[i] = std::clamp(x[i] + steps * step, low_[i], high_[i]);
        }
        return look_at(values_at(x)).merit;
      };
      climb_lattice(std::vector<std::size_t>(centre.size(), 2 * half + 1),
                    LatticePoint(centre.size(), half), 1, merit);
    }
  }

  void climb() {
    const auto lattice = problem_.lattice();
    std::vector<std::size_t> sizes;
    for (const auto& values : lattice) sizes.push_back(values.size());
    const auto merit = [&](const LatticePoint& point) {
      std::vector<double> values;
      for (std::size_t i = 0; i < point.size(); ++i) values.push_back(lattice[i][point[i]]);
      const Candidate& candidate = look_at(values);
      result_.on_lattice.push_back(candidate);
      return candidate.merit;
    };
    for (const LatticePoint& start : find_starts(lattice))
      climb_lattice(sizes, start, lattice_reach, merit);
  }

  // The lattice's points nearest to the best candidates.
  std::set<LatticePoint> find_starts(const std::vector<std::vector<double>>& lattice) const {
    std::vector<Candidate> best = result_.seen;
    std::stable_sort(best.begin(), best.end(), is_better);
    std::set<LatticePoint> starts;
    for (const Candidate& candidate : best) {
      LatticePoint point;
      for (std::size_t i = 0; i < lattice.size(); ++i) {
        const auto distance = [&](double a) { return std::abs(std::log(a / candidate.values[i])); };
        const auto nearest =
            std::min_element(lattice[i].begin(), lattice[i].end(),
                             [&](double a, double b) { return distance(a) < distance(b); });
        point.push_back(static_cast<std::size_t>(nearest - lattice[i].begin()));
      }
      starts.insert(point);
      if (starts.size() == lattice_starts) break;
    }
    return starts;
  }

  const DesignProblem& problem_;
  const DesignConstraint* free_;
  const std::function<void(std::size_t)>& advance_;
  std::vector<double> low_, high_;
  OptionSearch result_;
  nlopt::opt optimizer_;
  std::exception_ptr failure_;
};

}  // namespace

std::size_t count_search_steps(const DesignProblem& problem) {
  constexpr std::size_t refinement = 150;  // mesh and lattice, for each variable
  return scan_points + problem.size() * (global_steps + local_steps + refinement);
}

OptionSearch search_option(const DesignProblem& problem, const DesignConstraint* free,
                           const std::function<void(std::size_t)>& advance) {
  return Searcher(problem, free, advance).run();
}

}  // namespace gyrator
