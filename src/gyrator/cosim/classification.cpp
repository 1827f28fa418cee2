#include "gyrator/cosim/classification.hpp"

#include <algorithm>
#include <cmath>
#include <span>

namespace gyrator {
namespace {

double half_swing(std::span<const double> values) {
  if (values.empty()) return 0;
  const auto [low, high] = std::minmax_element(values.begin(), values.end());
  return (*high - *low) / 2;
}

// Mean frequency from the upward crossings of the middle value, interpolated between samples.
double find_frequency(std::span<const double> velocity, double period) {
  if (velocity.size() < 3) return 0;
  const auto [low, high] = std::minmax_element(velocity.begin(), velocity.end());
  const double middle = (*low + *high) / 2;
  double first = -1;
  double last = -1;
  int crossings = 0;
  for (std::size_t i = 1; i < velocity.size(); ++i) {
    const double before = velocity[i - 1] - middle;
    const double after = velocity[i] - middle;
    if (!(before < 0 && after >= 0)) continue;
    last = static_cast<double>(i) - after / (after - before);
    if (crossings == 0) first = last;
    ++crossings;
  }
  return crossings > 1 ? (crossings - 1) / ((last - first) * period) : 0;
}

}  // namespace

std::string_view name_of(Outcome outcome) {
  switch (outcome) {
    case Outcome::settles: return "settles";
    case Outcome::limit_cycle: return "limit_cycle";
    case Outcome::diverges: break;
  }
  return "diverges";
}

Classification classify(const std::vector<double>& position, const std::vector<double>& velocity, double period,
                        bool stopped_early, const ClassificationOptions& options) {
  Classification c;
  const std::size_t third = velocity.size() / 3;
  const std::span<const double> tail = std::span(velocity).last(third);
  const double early = half_swing(tail.first(third / 2));
  const double late = half_swing(tail.last(third / 2));
  const double largest = half_swing(velocity);
  c.growth = early > 0 ? late / early : 0;
  c.amplitude = half_swing(std::span(position).last(third));
  c.frequency_hz = find_frequency(tail, period);
  if (stopped_early) {
    c.outcome = Outcome::diverges;
  } else if (late <= options.rest_fraction * largest || c.growth < 1 / options.growth_limit) {
    c.outcome = Outcome::settles;
  } else {
    c.outcome = c.growth > options.growth_limit ? Outcome::diverges : Outcome::limit_cycle;
  }
  return c;
}

}  // namespace gyrator
