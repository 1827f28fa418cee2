#include "gyrator/studies/worst_limit.hpp"

#include "gyrator/core/interrupt.hpp"
#include "gyrator/studies/parallel.hpp"
#include "gyrator/studies/progress.hpp"

#include <algorithm>
#include <cmath>
#include <exception>

#include <nlopt.hpp>

namespace gyrator {
namespace {

constexpr std::size_t most_starts = 4;

// A device whose limit is not bounded has nothing to lose; NLopt wants finite numbers.
constexpr double unbounded = 1e300;

bool is_lower(const BoxPoint& a, const BoxPoint& b) {
  return a.limit.max_stiffness < b.limit.max_stiffness;
}

// One search, over the box scaled to [0, 1] in every direction.
class Search {
 public:
  Search(const LimitSampler& sampler, BoxPoint start)
      : sampler_(sampler), best_(std::move(start)) {}

  BoxPoint run() {
    const auto& tolerances = sampler_.box().tolerances();
    const auto n = static_cast<unsigned>(tolerances.size());
    std::vector<double> x;
    for (std::size_t i = 0; i < n; ++i) {
      const Tolerance& t = tolerances[i];
      x.push_back(std::clamp((best_.values[i] - t.low) / (t.high - t.low), 0.0, 1.0));
    }
    optimizer_ = nlopt::opt(nlopt::LN_SBPLX, n);
    optimizer_.set_min_objective(&Search::evaluate, this);
    optimizer_.set_lower_bounds(0.0);
    optimizer_.set_upper_bounds(1.0);
    optimizer_.set_initial_step(0.2);
    optimizer_.set_xtol_abs(1e-3);
    optimizer_.set_ftol_rel(1e-6);
    optimizer_.set_maxeval(static_cast<int>(30 * (n + 1)));
    double value = 0;
    try {
      optimizer_.optimize(x, value);
    } catch (const nlopt::forced_stop&) {
      if (failure_) std::rethrow_exception(failure_);
    } catch (const nlopt::roundoff_limited&) {
      // The best point so far is kept.
    }
    return best_;
  }

 private:
  // Nothing may be thrown through NLopt.
  static double evaluate(const std::vector<double>& x, std::vector<double>&, void* data) {
    auto& search = *static_cast<Search*>(data);
    try {
      return search.limit_at(x);
    } catch (...) {
      search.failure_ = std::current_exception();
      search.optimizer_.force_stop();
      return unbounded;
    }
  }

  double limit_at(const std::vector<double>& x) {
    throw_if_interrupted("tolerance");
    BoxPoint point;
    const auto& tolerances = sampler_.box().tolerances();
    for (std::size_t i = 0; i < x.size(); ++i) {
      const Tolerance& t = tolerances[i];
      // The ends themselves, without rounding.
      point.values.push_back(x[i] >= 1 ? t.high : t.low + x[i] * (t.high - t.low));
    }
    point.limit = sampler_.at(point.values);
    const double limit = point.limit.max_stiffness;
    if (is_lower(point, best_)) best_ = std::move(point);
    return std::isfinite(limit) ? limit : unbounded;
  }

  const LimitSampler& sampler_;
  BoxPoint best_;
  nlopt::opt optimizer_;
  std::exception_ptr failure_;
};

std::vector<BoxPoint> evaluate_corners(const LimitSampler& sampler, const SearchOptions& options) {
  const auto corners = list_corners(sampler.box().tolerances());
  std::vector<BoxPoint> points(corners.size());
  Progress progress("corners", corners.size(), options.quiet);
  run_parallel(corners.size(), options.threads, [&](std::size_t i) {
    throw_if_interrupted("tolerance");
    points[i] = {corners[i], sampler.at(corners[i])};
    progress.advance();
  });
  return points;
}

}  // namespace

std::vector<std::vector<double>> list_corners(const std::vector<Tolerance>& tolerances) {
  if (tolerances.size() > most_parts_for_corners) return {};
  std::vector<std::vector<double>> corners;
  for (std::size_t bits = 0; bits < (std::size_t{1} << tolerances.size()); ++bits) {
    std::vector<double> corner;
    for (std::size_t i = 0; i < tolerances.size(); ++i)
      corner.push_back((bits >> i & 1U) != 0 ? tolerances[i].high : tolerances[i].low);
    corners.push_back(std::move(corner));
  }
  return corners;
}

WorstLimit find_worst_limit(const LimitSampler& sampler, const std::vector<BoxPoint>& known,
                            const SearchOptions& options) {
  const std::vector<BoxPoint> corners = evaluate_corners(sampler, options);
  WorstLimit worst;
  worst.limit.max_stiffness = INFINITY;
  // A corner is easier to understand than a point beside it that is lower by rounding.
  const auto consider = [&](const BoxPoint& point, const char* found_by, double gain = 0) {
    const bool first = worst.values.empty();
    if (first || point.limit.max_stiffness < (1 - gain) * worst.limit.max_stiffness)
      worst = {point.limit, point.values, found_by};
  };
  for (const BoxPoint& corner : corners) consider(corner, "corner");
  for (const BoxPoint& point : known) consider(point, "sample");
  if (!(worst.limit.max_stiffness > 0)) return worst;  // nothing is below

  // The lowest of each, since samples lead to places that corners do not.
  std::vector<BoxPoint> starts;
  for (const auto* points : {&corners, &known}) {
    std::vector<BoxPoint> sorted = *points;
    const std::size_t count = std::min(most_starts / 2, sorted.size());
    std::partial_sort(sorted.begin(), sorted.begin() + static_cast<std::ptrdiff_t>(count),
                      sorted.end(), is_lower);
    starts.insert(starts.end(), sorted.begin(),
                  sorted.begin() + static_cast<std::ptrdiff_t>(count));
  }
  Progress progress("searches", starts.size(), options.quiet);
  run_parallel(starts.size(), options.threads, [&](std::size_t i) {
    starts[i] = Search(sampler, starts[i]).run();
    progress.advance();
  });
  for (const BoxPoint& point : starts) consider(point, "search", 1e-6);
  return worst;
}

}  // namespace gyrator
