#include "gyrator/sweeps/sweep_analyses.hpp"

#include "gyrator/core/error.hpp"
#include "gyrator/core/text.hpp"
#include "gyrator/mechanics/stability.hpp"
#include "gyrator/passivity/held_limit.hpp"
#include "gyrator/passivity/stiffness_limit.hpp"
#include "gyrator/passivity/verdict.hpp"
#include "gyrator/studies/limit_sampler.hpp"
#include "gyrator/studies/motion_terms.hpp"
#include "gyrator/studies/result_parts.hpp"
#include "gyrator/studies/simulation_result.hpp"

#include <algorithm>
#include <limits>

namespace gyrator {
namespace {

constexpr double nothing = std::numeric_limits<double>::quiet_NaN();

std::string symbol(const Unit& unit) {
  return std::string(unit.symbol);
}

std::vector<SweepOutput> passivity_outputs(Motion motion) {
  const MotionUnits& units = units_of(motion);
  return {
      {"passive", "1", "1: passive with every operator; 0: not"},
      {"margin", symbol(units.damping), "damping left at the worst frequency"},
      {"worst_frequency_hz", "Hz", "where it is"},
      {"max_stiffness", symbol(units.stiffness), "largest K at the model's B; nan without a wall"}};
}

std::vector<double> compute_passivity(const Model& model) {
  const Verdict verdict =
      naming_file(model, [&] { return judge_passivity(model.passivity_model(), false); });
  const auto exact = std::find_if(verdict.criteria.begin(), verdict.criteria.end(),
                                  [](const CriterionResult& c) { return c.name == "exact_disk"; });
  return {verdict.passive ? 1.0 : 0.0, exact->margin, exact->worst_frequency_hz.value_or(nothing),
          exact->max_stiffness.value_or(nothing)};
}

std::vector<SweepOutput> limit_outputs(Motion motion) {
  return {{"max_stiffness", symbol(units_of(motion).stiffness),
           "largest K at the model's B; 0 where none is feasible"},
          {"worst_frequency_hz", "Hz", "where it binds"},
          {"feasible", "1", "1: K = 0 meets the criterion at this B; 0: not even that"}};
}

std::vector<double> find_limit(const Model& model, Criterion criterion) {
  const StiffnessLimit limit = naming_file(model, [&] {
    require_stable_device(model.device);
    const WallValues wall = require_wall(model);
    StiffnessLimits limits(model.device, model.sampling, model.sampled_controller(), model.held_by);
    return limits.find(criterion, wall.damping);
  });
  return {limit.feasible ? limit.stiffness : 0.0, limit.worst_frequency_hz,
          limit.feasible ? 1.0 : 0.0};
}

std::vector<double> find_passive_limit(const Model& model) {
  return find_limit(model, Criterion::exact_disk);
}

std::vector<double> find_coupled_limit(const Model& model) {
  return find_limit(model, Criterion::coupled);
}

std::vector<SweepOutput> simulation_outputs(Motion motion) {
  return {{"outcome", "1", "0: settles, 1: limit_cycle, 2: diverges"},
          {"growth", "1", "of the swing over a sixth of the run"},
          {"amplitude", symbol(units_of(motion).position), "of the position in the last third"},
          {"frequency_hz", "Hz", "of the motion in the last third; 0 without any"}};
}

std::vector<double> simulate_point(const Model& model) {
  const Classification found = run_simulation(model, {}).classification;
  return {static_cast<double>(found.outcome), found.growth, found.amplitude, found.frequency_hz};
}

}  // namespace

const std::vector<SweepAnalysis>& sweep_analyses() {
  static const std::vector<SweepAnalysis> analyses{
      {"passivity", "verdict by the exact disk, margin, worst frequency, largest stiffness",
       passivity_outputs, compute_passivity},
      {"zwidth", "largest passive stiffness by the exact disk, at the model's virtual damping",
       limit_outputs, find_passive_limit},
      {"coupled", "largest stiffness that is stable with the model's operator", limit_outputs,
       find_coupled_limit},
      {"simulate", "the motion: settles, limit cycle or diverges, with growth and amplitude",
       simulation_outputs, simulate_point},
  };
  return analyses;
}

const SweepAnalysis& find_sweep_analysis(const std::string& name, const std::string& place) {
  std::vector<std::string> names;
  for (const SweepAnalysis& analysis : sweep_analyses()) {
    if (analysis.name == name) return analysis;
    names.emplace_back(analysis.name);
  }
  throw Error(ErrorCode::bad_input, place, describe_unknown_name("analysis", name, names));
}

}  // namespace gyrator
