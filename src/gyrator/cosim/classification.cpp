#include "gyrator/cosim/classification.hpp"

#include "gyrator/cosim/motion_cycles.hpp"

#include <algorithm>
#include <cmath>
#include <span>

#include <Eigen/Core>

namespace gyrator {
namespace {

// Growth is told from at least this many cycles.
constexpr std::size_t fewest_cycles = 2;
constexpr double certain = 3;  // standard errors

struct Range {
  double low, high;
};

Range find_range(std::span<const double> values) {
  const Eigen::Map<const Eigen::ArrayXd> all(values.data(),
                                             static_cast<Eigen::Index>(values.size()));
  return {all.minCoeff(), all.maxCoeff()};
}

double half_swing(std::span<const double> values) {
  if (values.empty()) return 0;
  const Range range = find_range(values);
  return (range.high - range.low) / 2;
}

std::vector<MotionCycle> find_cycles(std::span<const double> velocity) {
  std::vector<MotionCycle> cycles;
  if (velocity.size() < 3) return cycles;
  const Range range = find_range(velocity);
  const double middle = (range.low + range.high) / 2;
  double start = -1;
  std::size_t first = 0;
  for (std::size_t i = 1; i < velocity.size(); ++i) {
    const double before = velocity[i - 1] - middle;
    const double after = velocity[i] - middle;
    if (!(before < 0 && after >= 0)) continue;
    const double crossing = static_cast<double>(i) - after / (after - before);
    if (start >= 0)
      cycles.push_back({start, crossing, half_swing(velocity.subspan(first, i - first))});
    start = crossing;
    first = i;
  }
  return cycles;
}

// By what the swing multiplies in `time`, and what that is known to: a straight line through its
// logarithm over the cycles.
struct Growth {
  double factor = 0;
  double error = 0;  ///< standard error of ln factor, from the scatter around the line
};
Growth find_growth(std::span<const MotionCycle> cycles, double time) {
  double mean_start = 0;
  double mean_log = 0;
  std::vector<double> logs;
  logs.reserve(cycles.size());
  for (const MotionCycle& cycle : cycles) {
    if (!(cycle.swing > 0)) return {};
    logs.push_back(std::log(cycle.swing));
    mean_start += cycle.start / static_cast<double>(cycles.size());
    mean_log += logs.back() / static_cast<double>(cycles.size());
  }
  double product = 0;
  double square = 0;
  for (std::size_t i = 0; i < cycles.size(); ++i) {
    const double since = cycles[i].start - mean_start;
    product += since * (logs[i] - mean_log);
    square += since * since;
  }
  const double slope = product / square;
  double scatter = 0;
  for (std::size_t i = 0; i < cycles.size(); ++i) {
    const double off = logs[i] - mean_log - slope * (cycles[i].start - mean_start);
    scatter += off * off;
  }
  const double freedom = std::max(1.0, static_cast<double>(cycles.size()) - 2);
  return {std::exp(slope * time), std::sqrt(scatter / freedom / square) * time};
}

// Growth of a motion without oscillation: the ratio of its sizes in the last two of six parts. An
// exponential grows by the same factor from part to part; a swing on its way to a peak, or back
// from one, does not, and counts as none.
double find_steady_growth(std::span<const double> velocity) {
  constexpr std::size_t parts = 6;
  const std::size_t part = velocity.size() / parts;
  if (part == 0) return 0;
  double growth = 0;
  double before = 0;
  for (std::size_t i = 0; i < parts; ++i) {
    double size = 0;
    for (const double v : velocity.subspan(i * part, part)) size = std::max(size, std::abs(v));
    if (i > 0) {
      const double ratio = before > 0 ? size / before : 0;
      if (ratio <= 1 || ratio < 0.99 * growth) return 0;
      growth = ratio;
    }
    before = size;
  }
  return growth;
}

}  // namespace

std::string_view name_of(Outcome outcome) {
  switch (outcome) {
    case Outcome::settles:
      return "settles";
    case Outcome::limit_cycle:
      return "limit_cycle";
    case Outcome::diverges:
      break;
  }
  return "diverges";
}

std::optional<Classification> classify_cycles(std::span<const MotionCycle> cycles,
                                              const RunSizes& sizes, double period,
                                              const ClassificationOptions& options) {
  if (cycles.size() < fewest_cycles) return std::nullopt;
  const Growth growth = find_growth(cycles, static_cast<double>(sizes.samples) / 6);
  Classification c;
  c.growth = growth.factor;
  c.amplitude = sizes.amplitude;
  c.frequency_hz =
      static_cast<double>(cycles.size()) / ((cycles.back().end - cycles.front().start) * period);
  // Whether growth stands out from the scatter of the cycles.
  const bool known =
      !(growth.factor > 0) || std::abs(std::log(growth.factor)) > certain * growth.error;
  const bool rests = sizes.last_swing <= options.rest_fraction * sizes.largest_swing;
  if (rests || (known && c.growth < 1 / options.growth_limit)) {
    c.outcome = Outcome::settles;
  } else {
    c.outcome = known && c.growth > options.growth_limit ? Outcome::diverges : Outcome::limit_cycle;
  }
  return c;
}

Classification classify(const std::vector<double>& position, const std::vector<double>& velocity,
                        double period, bool stopped_early, const ClassificationOptions& options) {
  const std::span<const double> all(velocity);
  const std::size_t third = velocity.size() / 3;
  const RunSizes sizes{velocity.size(), half_swing(all), half_swing(all.last(third / 2)),
                       half_swing(std::span(position).last(third))};
  Classification c;
  for (const std::size_t window : {third, 2 * third, velocity.size()}) {
    if (const auto found = classify_cycles(find_cycles(all.last(window)), sizes, period, options)) {
      c = *found;
      if (stopped_early) c.outcome = Outcome::diverges;
      return c;
    }
  }
  c.amplitude = sizes.amplitude;
  c.growth = find_steady_growth(all);
  // A single bounce that takes a third of the run and more is no rest: its size tells.
  const double first_third = half_swing(all.first(third));
  const double last_third = half_swing(all.last(third));
  if (c.growth == 0 && first_third > 0 && last_third > sizes.largest_swing / 2)
    c.growth = std::sqrt(last_third / first_third);
  const bool rests = sizes.last_swing <= options.rest_fraction * sizes.largest_swing;
  if (stopped_early || (!rests && c.growth > options.growth_limit)) c.outcome = Outcome::diverges;
  return c;
}

}  // namespace gyrator
