#include "gyrator/synthesis/design_study.hpp"

#include "gyrator/core/interrupt.hpp"
#include "gyrator/studies/limit_sampler.hpp"
#include "gyrator/studies/parallel.hpp"
#include "gyrator/studies/progress.hpp"
#include "gyrator/studies/results.hpp"
#include "gyrator/synthesis/design_reasons.hpp"
#include "gyrator/synthesis/pareto_front.hpp"
#include "gyrator/synthesis/rated_model.hpp"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <utility>

#include <fmt/core.h>

namespace gyrator {
namespace {

using nlohmann::json;

bool is_better(const Candidate& a, const Candidate& b) {
  return b.merit < a.merit;
}

// The same option with all values within a tenth: no choice worth showing.
bool is_alike(const Candidate& a, const Candidate& b) {
  if (a.option != b.option) return false;
  for (std::size_t i = 0; i < a.values.size(); ++i)
    if (std::abs(std::log(a.values[i] / b.values[i])) > 0.095) return false;
  return true;
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
      const DesignFigures figures =
          problem.evaluate_port(sampler.box().at(values), model.controller);
      for (const DesignConstraint& constraint : spec.constraints)
        kept = kept && (constraint.figure->is_minimum || find_violation(constraint, figures) == 0);
    }
    if (kept) ++good;
    progress.advance();
  });
  return compute_share(good, spec.samples);
}

// K over B of the model's device and controller, by the grid's limit.
Boundary trace_boundary(const json& document, const DesignSpec& spec) {
  constexpr int points = 25;
  const Model model = parse_model(document, spec.model.file);
  Boundary boundary{choose_damping_range(model, points), {}};
  StiffnessLimits limits(model.device, model.sampling, model.sampled_controller(), FreeOperator{},
                         GridDensity::coarse);
  for (const double damping : boundary.damping) {
    const StiffnessLimit limit = limits.find_on_grid(damping);
    boundary.max_stiffness.push_back(limit.feasible ? limit.stiffness : 0);
  }
  return boundary;
}

class Study {
 public:
  Study(const DesignSpec& spec, bool quiet) : spec_(spec), quiet_(quiet) {
    for (const DesignOption& option : spec.options) {
      problems_.emplace_back(spec, option);
      problems_.back().lattice();  // refuses a range without values before long work
    }
  }

  DesignStudy run() {
    search();
    std::vector<Candidate> chosen = choose();
    prove(chosen);
    prove(study_.continuous);
    report(chosen);
    explain_infeasible();
    if (chosen.empty()) study_.binding = find_binding();
    return std::move(study_);
  }

 private:
  const DesignProblem& problem_of(const Candidate& candidate) const {
    return *std::find_if(problems_.begin(), problems_.end(), [&](const DesignProblem& problem) {
      return &problem.option() == candidate.option;
    });
  }

  std::size_t count_steps() const {
    std::size_t steps = 0;
    for (const DesignProblem& problem : problems_) steps += count_search_steps(problem);
    return steps;
  }

  // The options side by side; each is searched by one thread with random numbers of its own.
  void search() {
    Progress progress("search", count_steps() + problems_.size() * sweep_steps, quiet_);
    const auto advance = [&](std::size_t n) { progress.advance(n); };
    searches_.resize(problems_.size());
    std::vector<std::vector<Candidate>> swept(problems_.size());
    run_parallel(problems_.size(), 0, [&](std::size_t i) {
      searches_[i] = search_option(problems_[i], nullptr, advance);
      swept[i] = sweep_inertia(problems_[i], searches_[i].on_lattice, advance);
    });
    std::vector<Candidate> all;
    std::vector<Candidate> of_topology;
    for (std::size_t i = 0; i < searches_.size(); ++i) {
      if (searches_[i].continuous.merit.feasible)
        study_.continuous.push_back(searches_[i].continuous);
      all.insert(all.end(), swept[i].begin(), swept[i].end());
      of_topology.insert(of_topology.end(), swept[i].begin(), swept[i].end());
      const Topology* topology = spec_.options[i].topology;
      if (i + 1 < spec_.options.size() && spec_.options[i + 1].topology == topology) continue;
      study_.fronts.push_back({topology, find_pareto(spec_, std::exchange(of_topology, {}))});
    }
    study_.pareto = find_pareto(spec_, std::move(all));
  }

  // The best of each topology, the best of each option, then the next best that differ from them.
  std::vector<Candidate> choose() const {
    std::vector<Candidate> chosen;
    std::vector<Candidate> rest;
    for (const OptionSearch& found : searches_) {
      for (const Candidate& candidate : found.on_lattice)
        if (candidate.merit.feasible) rest.push_back(candidate);
    }
    std::stable_sort(rest.begin(), rest.end(), is_better);
    const auto add_best_of_each = [&](const auto& kind) {
      for (const Candidate& candidate : rest) {
        const bool known = std::any_of(chosen.begin(), chosen.end(), [&](const Candidate& other) {
          return kind(*candidate.option) == kind(*other.option);
        });
        if (!known) chosen.push_back(candidate);
      }
    };
    add_best_of_each([](const DesignOption& option) { return option.topology; });
    add_best_of_each([](const DesignOption& option) { return &option; });
    for (const Candidate& candidate : rest) {
      if (chosen.size() >= spec_.count) break;
      const bool known = std::any_of(chosen.begin(), chosen.end(), [&](const Candidate& other) {
        return is_alike(candidate, other);
      });
      if (!known) chosen.push_back(candidate);
    }
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
      Design design;
      design.candidate = candidate;
      design.rated_stiffness = rated_stiffness(candidate);
      const DesignProblem& problem = problem_of(candidate);
      design.extremes = candidate.figures.extremes;
      design.model = make_rated_model(spec_, candidate, design.rated_stiffness);
      design.boundary = trace_boundary(design.model, spec_);
      design.yield = find_yield(problem, design.model, progress);
      study_.designs.push_back(std::move(design));
    }
    sort_designs(spec_, study_.designs);
    for (Design& design : study_.designs)
      if (&design != study_.designs.data())
        design.reason = describe_loss(spec_, study_.designs.front(), design);
  }

  // The options of a topology stand together.
  void explain_infeasible() {
    const Candidate* nearest = nullptr;
    for (std::size_t i = 0; i < searches_.size(); ++i) {
      const Candidate& best = searches_[i].best;
      if (!nearest || is_better(best, *nearest)) nearest = &best;
      const Topology* topology = spec_.options[i].topology;
      if (i + 1 < spec_.options.size() && spec_.options[i + 1].topology == topology) continue;
      if (!nearest->merit.feasible) {
        const DesignFigures figures =
            problem_of(*nearest).evaluate(nearest->values, LimitPrecision::proved);
        study_.infeasible.push_back({topology, describe_miss(spec_, figures)});
      }
      nearest = nullptr;
    }
  }

  double rated_stiffness(const Candidate& candidate) const {
    if (spec_.objective == DesignObjective::lightest) return spec_.constraints.front().limit;
    return round_down(spec_.rated_share * candidate.figures.least_stiffness);
  }

  // Of the constraints that would make a design feasible by giving way alone, the one that has to
  // give least; where none would, the one that the nearest candidate misses most.
  std::optional<BindingConstraint> find_binding() const {
    Progress progress("what would have to give", spec_.constraints.size() * count_steps(), quiet_);
    const std::size_t trials = spec_.constraints.size() * problems_.size();
    std::vector<Candidate> found(trials);
    run_parallel(trials, 0, [&](std::size_t i) {
      const DesignConstraint& constraint = spec_.constraints[i / problems_.size()];
      found[i] = search_option(problems_[i % problems_.size()], &constraint, [&](std::size_t n) {
                   progress.advance(n);
                 }).best;
    });
    std::optional<BindingConstraint> binding;
    double least = HUGE_VAL;
    for (std::size_t i = 0; i < trials; ++i) {
      const DesignMerit& merit = found[i].merit;
      if (!merit.feasible || -merit.score >= least || -merit.score >= hopeless) continue;
      least = -merit.score;
      binding = make_binding(spec_.constraints[i / problems_.size()], found[i], true);
    }
    return binding ? binding : name_worst_missed();
  }

  std::optional<BindingConstraint> name_worst_missed() const {
    const Candidate* nearest = nullptr;
    for (const OptionSearch& found : searches_)
      if (!nearest || is_better(found.best, *nearest)) nearest = &found.best;
    Candidate judged = *nearest;
    judged.figures = problem_of(judged).evaluate(judged.values, LimitPrecision::proved);
    const DesignConstraint* missed = find_worst_missed(spec_, judged.figures);
    if (!missed) return std::nullopt;
    BindingConstraint binding = make_binding(*missed, judged, false);
    for (const DesignConstraint& constraint : spec_.constraints) {
      const bool is_other = &constraint != missed && !constraint.figure->is_minimum;
      if (is_other && find_violation(constraint, judged.figures) > 0)
        binding.others.push_back({constraint.figure->name, constraint.figure->unit,
                                  constraint.limit, constraint.figure->value(judged.figures)});
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
            candidate.option->topology->name};
  }

  const DesignSpec& spec_;
  bool quiet_;
  std::vector<DesignProblem> problems_;
  std::vector<OptionSearch> searches_;
  DesignStudy study_;
};

}  // namespace

DesignStudy run_design_study(const DesignSpec& spec, bool quiet) {
  return Study(spec, quiet).run();
}

}  // namespace gyrator
