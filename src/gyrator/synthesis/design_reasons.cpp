#include "gyrator/synthesis/design_reasons.hpp"

#include "gyrator/core/text.hpp"

#include <algorithm>
#include <cmath>
#include <tuple>
#include <vector>

#include <fmt/core.h>

namespace gyrator {
namespace {

// The proof of a limit leaves as much open.
constexpr double as_good = 1e-3;
constexpr double equal = 1e-6;

// By how much the objective of `other` is worse, relative.
double find_loss(const DesignSpec& spec, const Design& first, const Design& other) {
  const DesignFigures& f = first.candidate.figures;
  const DesignFigures& g = other.candidate.figures;
  if (spec.objective == DesignObjective::stiffest) {
    if (f.max_stiffness == g.max_stiffness) return 0;
    return 1 - g.max_stiffness / f.max_stiffness;
  }
  if (f.apparent_inertia == g.apparent_inertia) return 0;
  return (g.apparent_inertia - f.apparent_inertia) / std::abs(f.apparent_inertia);
}

// The constraints that a candidate runs into, and the ends of its ranges.
std::string describe_end(const DesignSpec& spec, const Candidate& candidate) {
  constexpr double near = 0.1;  // log of a tenth: steps of the series apart
  std::vector<std::string> ends;
  for (const DesignConstraint& constraint : spec.constraints) {
    const double value = constraint.figure->value(candidate.figures);
    if (!(value > 0) || std::abs(std::log(value / constraint.limit)) > near) continue;
    ends.push_back(fmt::format("{} is at {:.3g} % of its limit", constraint.figure->name,
                               100 * value / constraint.limit));
  }
  for (std::size_t i = 0; i < candidate.values.size(); ++i) {
    const auto& [name, part, unit, range] = candidate.option->values[i];
    if (candidate.values[i] < range.low * (1 + near))
      ends.push_back(name + " is at the low end of its range");
    if (candidate.values[i] > range.high * (1 - near))
      ends.push_back(name + " is at the high end of its range");
  }
  return join(ends);
}

// In what else two designs that are as good differ.
std::string describe_differences(const DesignSpec& spec, const Design& first, const Design& other) {
  std::vector<std::string> texts;
  const auto per_cent = [](double share) { return fmt::format("{:.4g} %", 100 * share); };
  if (first.yield.value != other.yield.value) {
    texts.push_back(fmt::format("its yield is {}, {} against {}",
                                other.yield.value < first.yield.value ? "lower" : "higher",
                                per_cent(other.yield.value), per_cent(first.yield.value)));
  }
  const int parts = count_parts(spec, *other.candidate.option);
  if (const int fewest = count_parts(spec, *first.candidate.option); parts != fewest)
    texts.push_back(fmt::format("it has {} instead of {}", describe_count(parts, "part"), fewest));
  const double inertia = other.candidate.figures.apparent_inertia;
  const double least = first.candidate.figures.apparent_inertia;
  const double change = (inertia - least) / std::abs(least);
  if (spec.objective == DesignObjective::stiffest && std::abs(change) > as_good) {
    texts.push_back(fmt::format("it adds {:.3g} % {} apparent inertia", 100 * std::abs(change),
                                change > 0 ? "more" : "less"));
  }
  return texts.empty() ? "nothing else tells them apart" : join(texts);
}

}  // namespace

int count_parts(const DesignSpec& spec, const DesignOption& option) {
  int parts = 0;
  for (const SoughtValue& value : option.values) {
    if (value.part == DesignPart::resistor) ++parts;
    if (value.part == DesignPart::capacitor) parts += spec.bipolar_capacitor ? 1 : 2;
  }
  return parts;
}

// "Equal within a millionth" is no order by itself, since it does not pass on from one pair to the
// next: hence groups that begin with the best that is left.
void sort_designs(const DesignSpec& spec, std::vector<Design>& designs) {
  std::stable_sort(designs.begin(), designs.end(), [](const Design& a, const Design& b) {
    return b.candidate.merit < a.candidate.merit;
  });
  const auto rank = [&](const Design& design) {
    return std::tuple(-design.yield.value, count_parts(spec, *design.candidate.option),
                      design.candidate.figures.apparent_inertia);
  };
  for (auto first = designs.begin(); first != designs.end();) {
    const auto end = std::find_if(first, designs.end(), [&](const Design& other) {
      return find_loss(spec, *first, other) > equal;
    });
    std::stable_sort(first, end,
                     [&](const Design& a, const Design& b) { return rank(a) < rank(b); });
    first = end;
  }
}

const DesignConstraint* find_worst_missed(const DesignSpec& spec, const DesignFigures& figures) {
  const DesignConstraint* missed = nullptr;
  double worst = 0;
  for (const DesignConstraint& constraint : spec.constraints) {
    const double violation = find_violation(constraint, figures);
    const bool gives_way = missed && missed->figure->is_minimum;
    if (violation == 0 || (missed && constraint.figure->is_minimum)) continue;
    if (violation <= worst && !gives_way) continue;
    worst = violation;
    missed = &constraint;
  }
  return missed;
}

std::string describe_miss(const DesignSpec& spec, const DesignFigures& figures) {
  const DesignConstraint* missed = find_worst_missed(spec, figures);
  if (!missed || !figures.stable) {
    return spec.constraints.empty()
               ? "no values were found with which any stiffness is passive"
               : "no values were found that keep every constraint and with which any stiffness is "
                 "passive";
  }
  const BoundedFigure& figure = *missed->figure;
  return fmt::format(
      "no values were found that keep every constraint; the nearest have {} {:.4g} {}, "
      "{} {:.4g} {} is asked for",
      figure.name, figure.value(figures), figure.unit.symbol,
      figure.is_minimum ? "at least" : "at most", missed->limit, figure.unit.symbol);
}

std::string describe_loss(const DesignSpec& spec, const Design& first, const Design& other) {
  const bool stiffest = spec.objective == DesignObjective::stiffest;
  const double loss = find_loss(spec, first, other);
  if (loss <= as_good) {
    return fmt::format("{} within 0.1 %; {}", stiffest ? "as stiff" : "as light",
                       describe_differences(spec, first, other));
  }
  std::string text =
      fmt::format("{:.3g} % {}", 100 * loss, stiffest ? "less stiff" : "more apparent inertia");
  if (const std::string end = describe_end(spec, other.candidate); !end.empty())
    text += "; there " + end;
  return text;
}

}  // namespace gyrator
