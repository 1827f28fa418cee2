#include "gyrator/synthesis/design_study.hpp"

#include "gyrator/core/interrupt.hpp"
#include "gyrator/studies/limit_sampler.hpp"
#include "gyrator/studies/parallel.hpp"
#include "gyrator/studies/progress.hpp"

#include <algorithm>
#include <atomic>
#include <cmath>

#include <fmt/core.h>

namespace gyrator {
namespace {

using nlohmann::json;

bool is_better(const Candidate& a, const Candidate& b) {
  return b.merit < a.merit;
}

// The same topology with all values within a tenth: no choice worth showing.
bool is_alike(const Candidate& a, const Candidate& b) {
  if (a.topology != b.topology) return false;
  for (std::size_t i = 0; i < a.values.size(); ++i)
    if (std::abs(std::log(a.values[i] / b.values[i])) > 0.095) return false;
  return true;
}

// "470 uF" where that reads as the very same number, else all its digits.
std::string write_value(double value, const Unit& unit) {
  const std::string text = format_quantity(value, unit);
  const auto reads_back = [&] { return parse_value(text, unit) == value; };
  if (unit == dimension::none) return fmt::format("{:.17g}", value);
  return reads_back() ? text : fmt::format("{:.17g} {}", value, unit.symbol);
}

// The candidate's model with its wall and tolerances.
json write_model(const DesignSpec& spec, const Candidate& candidate, double stiffness) {
  std::vector<json> values;
  for (std::size_t i = 0; i < candidate.values.size(); ++i) {
    const DesignVariable& variable = candidate.topology->variables[i];
    const double tolerance = spec.tolerances.at(variable.part);
    std::string text = write_value(candidate.values[i], variable.unit);
    if (tolerance > 0) text += fmt::format(" ± {:g} %", 100 * tolerance);
    if (variable.unit == dimension::none) {
      values.emplace_back(candidate.values[i]);
    } else {
      values.emplace_back(std::move(text));
    }
  }
  json model = make_designed_model(spec, *candidate.topology, values);
  model["name"] = fmt::format("{}, {}", spec.model.name, candidate.topology->name);
  if (!model.contains("controller")) model["controller"] = {{"kind", "virtual_wall"}};
  model["controller"]["stiffness"] = stiffness;
  model["controller"]["damping"] = spec.damping.front();
  if (spec.winding_rise && spec.winding_rise->low < spec.winding_rise->high) {
    model["motor"]["temperature_rise"] = fmt::format(
        "{:.17g} K ({:.17g} K to {:.17g} K)", spec.model.device.drive.motor->temperature_rise,
        spec.winding_rise->low, spec.winding_rise->high);
  }
  return model;
}

// Rounded down, for a wall that people read.
double round_down(double value) {
  if (!(value > 0) || value >= 1e299) return value;
  const double unit = std::pow(10, std::floor(std::log10(value)) - 3);
  return std::strtod(fmt::format("{:.4g}", std::floor(value / unit) * unit).c_str(), nullptr);
}

// Share of the devices of its parts on which the wall is passive and all constraints but the
// stiffness's are kept.
Share find_yield(const DesignProblem& problem, const json& document, Progress& progress) {
  const DesignSpec& spec = problem.spec();
  const Model model = parse_model(document, spec.model.file);
  if (model.parts.tolerances.empty()) return compute_share(spec.samples, spec.samples);
  const LimitSampler sampler(model);
  std::atomic<std::size_t> good{0};
  run_parallel(spec.samples, 0, [&](std::size_t i) {
    throw_if_interrupted("design");
    const auto values =
        draw_values(model.parts.tolerances, spec.seed, i, SampleDistribution::uniform);
    bool kept = sampler.at(values, LimitSearch::on_grid).outcome == WallOutcome::passive;
    if (kept && !spec.constraints.empty()) {
      const DesignFigures figures = problem.evaluate_port(sampler.box().at(values));
      for (const DesignConstraint& constraint : spec.constraints)
        kept = kept && (constraint.figure->is_minimum || find_violation(constraint, figures) == 0);
    }
    if (kept) ++good;
    progress.advance();
  });
  return compute_share(good, spec.samples);
}

// The next constraint that a candidate runs into, or the end of a range.
std::string describe_end(const DesignSpec& spec, const Candidate& candidate) {
  constexpr double near = 0.1;  // log of a tenth: steps of the series apart
  std::string text;
  const auto add = [&](const std::string& what) { text += (text.empty() ? "" : ", ") + what; };
  for (const DesignConstraint& constraint : spec.constraints) {
    const double value = constraint.figure->value(candidate.figures);
    if (!(value > 0) || std::abs(std::log(value / constraint.limit)) > near) continue;
    add(fmt::format("{} is at {:.3g} % of its limit", constraint.figure->name,
                    100 * value / constraint.limit));
  }
  for (std::size_t i = 0; i < candidate.values.size(); ++i) {
    const std::string name = name_of(*candidate.topology, candidate.topology->variables[i]);
    const DesignRange& range = spec.ranges.at(name);
    if (candidate.values[i] < range.low * (1 + near)) add(name + " is at the low end of its range");
    if (candidate.values[i] > range.high * (1 - near))
      add(name + " is at the high end of its range");
  }
  return text;
}

std::string describe_loss(const DesignSpec& spec, const Candidate& first, const Candidate& other) {
  const bool stiffest = spec.objective == DesignObjective::stiffest;
  const double change = stiffest
                            ? 1 - other.figures.max_stiffness / first.figures.max_stiffness
                            : other.figures.apparent_inertia / first.figures.apparent_inertia - 1;
  std::string text = change < 5e-5 ? "as good"
                                   : fmt::format("{:.3g} % {}", 100 * change,
                                                 stiffest ? "less stiff" : "more apparent inertia");
  if (const std::string end = describe_end(spec, other); !end.empty()) text += "; there " + end;
  return text;
}

// No other is at least as stiff and at least as light. Apparent inertia alone is not bounded.
std::vector<Candidate> find_pareto(const DesignSpec& spec, std::vector<Candidate> candidates) {
  std::erase_if(candidates, [&](const Candidate& candidate) {
    DesignMerit merit = candidate.merit;
    for (const DesignConstraint& constraint : spec.constraints)
      if (std::string_view(constraint.figure->name) == "apparent_inertia")
        merit = judge(spec, candidate.figures, &constraint);
    return !merit.feasible;
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
  constexpr std::size_t most = 40;
  if (front.size() <= most) return front;
  std::vector<Candidate> thinned;
  for (std::size_t i = 0; i < most; ++i)
    thinned.push_back(front[i * (front.size() - 1) / (most - 1)]);
  return thinned;
}

class Study {
 public:
  Study(const DesignSpec& spec, bool quiet) : spec_(spec), quiet_(quiet) {
    for (const Topology* topology : spec.topologies) problems_.emplace_back(spec, *topology);
  }

  DesignStudy run() {
    search();
    std::vector<Candidate> chosen = choose();
    prove(chosen);
    prove(study_.continuous);
    report(chosen);
    if (chosen.empty()) study_.binding = find_binding();
    return std::move(study_);
  }

 private:
  const DesignProblem& problem_of(const Candidate& candidate) const {
    return *std::find_if(problems_.begin(), problems_.end(), [&](const DesignProblem& problem) {
      return &problem.topology() == candidate.topology;
    });
  }

  void search() {
    std::size_t steps = 0;
    for (const DesignProblem& problem : problems_) steps += count_search_steps(problem);
    Progress progress("search", steps, quiet_);
    std::vector<Candidate> seen;
    for (const DesignProblem& problem : problems_) {
      problem.lattice();  // refuses a range without values before long work
      searches_.push_back(
          search_topology(problem, nullptr, [&](std::size_t n) { progress.advance(n); }));
      const TopologySearch& found = searches_.back();
      if (found.continuous.merit.feasible) study_.continuous.push_back(found.continuous);
      seen.insert(seen.end(), found.on_lattice.begin(), found.on_lattice.end());
      seen.insert(seen.end(), found.seen.begin(), found.seen.end());
    }
    study_.pareto = find_pareto(spec_, std::move(seen));
  }

  // The best of each topology, then the next best that differ from them.
  std::vector<Candidate> choose() const {
    std::vector<Candidate> chosen;
    std::vector<Candidate> rest;
    for (const TopologySearch& found : searches_) {
      if (found.best.merit.feasible) chosen.push_back(found.best);
      for (const Candidate& candidate : found.on_lattice)
        if (candidate.merit.feasible) rest.push_back(candidate);
    }
    std::stable_sort(rest.begin(), rest.end(), is_better);
    std::stable_sort(chosen.begin(), chosen.end(), is_better);
    for (const Candidate& candidate : rest) {
      if (chosen.size() >= spec_.count) break;
      const bool known = std::any_of(chosen.begin(), chosen.end(), [&](const Candidate& other) {
        return is_alike(candidate, other);
      });
      if (!known) chosen.push_back(candidate);
    }
    std::stable_sort(chosen.begin(), chosen.end(), is_better);
    if (chosen.size() > spec_.count) chosen.resize(spec_.count);
    return chosen;
  }

  void prove(std::vector<Candidate>& chosen) const {
    for (Candidate& candidate : chosen) {
      candidate.figures = problem_of(candidate).evaluate(candidate.values, LimitPrecision::proved);
      candidate.merit = judge(spec_, candidate.figures);
    }
    std::erase_if(chosen, [](const Candidate& candidate) { return !candidate.merit.feasible; });
    std::stable_sort(chosen.begin(), chosen.end(), is_better);
  }

  void report(const std::vector<Candidate>& chosen) {
    Progress progress("yield", chosen.size() * spec_.samples, quiet_);
    for (const Candidate& candidate : chosen) {
      Design design{candidate, rated_stiffness(candidate), {}, {}, {}, {}};
      const Device device = problem_of(candidate).make_device(candidate.values);
      design.extremes =
          compute_operating_extremes(device, device.drive.damping.size() - 1, spec_.operation);
      design.model = write_model(spec_, candidate, design.rated_stiffness);
      design.yield = find_yield(problem_of(candidate), design.model, progress);
      if (&candidate != chosen.data())
        design.reason = describe_loss(spec_, chosen.front(), candidate);
      study_.designs.push_back(std::move(design));
    }
  }

  double rated_stiffness(const Candidate& candidate) const {
    if (spec_.objective == DesignObjective::lightest) return spec_.constraints.front().limit;
    return round_down(spec_.rated_share * candidate.figures.least_stiffness);
  }

  // Of the constraints that would make a design feasible by giving way alone, the one that has to
  // give least; where none would, the one that the nearest candidate misses most.
  std::optional<BindingConstraint> find_binding() const {
    std::optional<BindingConstraint> binding;
    double least = HUGE_VAL;
    for (const DesignConstraint& constraint : spec_.constraints) {
      for (const DesignProblem& problem : problems_) {
        const Candidate found = search_topology(problem, &constraint).best;
        if (!found.merit.feasible || -found.merit.score >= least || -found.merit.score >= hopeless)
          continue;
        least = -found.merit.score;
        binding = make_binding(constraint, found, true);
      }
    }
    if (binding) return binding;
    const Candidate* nearest = nullptr;
    for (const TopologySearch& found : searches_)
      if (!nearest || is_better(found.best, *nearest)) nearest = &found.best;
    double worst = 0;
    for (const DesignConstraint& constraint : spec_.constraints) {
      const double violation = find_violation(constraint, nearest->figures);
      if (violation <= worst) continue;
      worst = violation;
      binding = make_binding(constraint, *nearest, false);
    }
    return binding;
  }

  static BindingConstraint make_binding(const DesignConstraint& constraint,
                                        const Candidate& candidate, bool alone) {
    return {constraint.figure->name,
            constraint.figure->unit,
            constraint.limit,
            constraint.figure->value(candidate.figures),
            alone,
            candidate.topology->name};
  }

  const DesignSpec& spec_;
  bool quiet_;
  std::vector<DesignProblem> problems_;
  std::vector<TopologySearch> searches_;
  DesignStudy study_;
};

}  // namespace

DesignStudy run_design_study(const DesignSpec& spec, bool quiet) {
  return Study(spec, quiet).run();
}

}  // namespace gyrator
