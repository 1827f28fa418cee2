#include "gyrator/studies/tolerance_study.hpp"

#include "gyrator/core/interrupt.hpp"
#include "gyrator/mechanics/stability.hpp"
#include "gyrator/studies/parallel.hpp"
#include "gyrator/studies/progress.hpp"
#include "gyrator/studies/result_parts.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>

namespace gyrator {
namespace {

using nlohmann::json;

std::vector<BoxPoint> draw_samples(const LimitSampler& sampler, const ToleranceRequest& request) {
  std::vector<BoxPoint> samples(request.samples);
  Progress progress("samples", request.samples, request.quiet);
  run_parallel(request.samples, request.threads, [&](std::size_t i) {
    throw_if_interrupted("tolerance");
    samples[i].values =
        draw_values(sampler.box().tolerances(), request.seed, i, request.distribution);
    samples[i].limit = sampler.at(samples[i].values, LimitSearch::on_grid);
    progress.advance();
  });
  return samples;
}

double limit_with(const LimitSampler& sampler, std::size_t part, double value) {
  std::vector<double> values = sampler.box().nominal_values();
  values[part] = value;
  return sampler.at(values).max_stiffness;
}

PartEffect find_effect(const LimitSampler& sampler, std::size_t part, double nominal_limit) {
  constexpr double step = 0.05;  // of the range: well above the limit's rounding
  const Tolerance& t = sampler.box().tolerances()[part];
  PartEffect effect;
  effect.part = part;
  effect.at_low = limit_with(sampler, part, t.low);
  effect.at_high = limit_with(sampler, part, t.high);
  // One-sided where the nominal value is an end.
  const double below = std::max(t.low, t.nominal - step * (t.high - t.low));
  const double above = std::min(t.high, t.nominal + step * (t.high - t.low));
  const double rise = limit_with(sampler, part, above) - limit_with(sampler, part, below);
  const double slope = rise / (above - below);
  if (!std::isfinite(slope) || !(nominal_limit > 0)) return effect;
  effect.sensitivity = slope * (t.high - t.low) / (2 * nominal_limit);        // (tol-6)
  if (t.nominal != 0) effect.elasticity = slope * t.nominal / nominal_limit;  // (tol-5)
  return effect;
}

// How far the limit moves when the part does; what makes it infinite moves it most.
double strength(const PartEffect& effect, double nominal_limit) {
  const auto distance = [&](double limit) {
    return limit == nominal_limit ? 0 : std::abs(limit - nominal_limit);
  };
  return std::max(distance(effect.at_low), distance(effect.at_high));
}

std::vector<PartEffect> find_effects(const LimitSampler& sampler, double nominal_limit,
                                     const std::vector<BoxPoint>& samples,
                                     const ToleranceRequest& request) {
  std::vector<PartEffect> effects(sampler.box().tolerances().size());
  run_parallel(effects.size(), request.threads,
               [&](std::size_t i) { effects[i] = find_effect(sampler, i, nominal_limit); });
  std::vector<double> limits;
  for (const BoxPoint& sample : samples) limits.push_back(sample.limit.max_stiffness);
  for (PartEffect& effect : effects) {
    std::vector<double> values;
    for (const BoxPoint& sample : samples) values.push_back(sample.values[effect.part]);
    effect.rank_correlation = compute_rank_correlation(values, limits);
  }
  std::stable_sort(effects.begin(), effects.end(), [&](const PartEffect& a, const PartEffect& b) {
    return strength(a, nominal_limit) > strength(b, nominal_limit);
  });
  return effects;
}

json optional_json(const std::optional<double>& value) {
  return value ? finite_or_null(*value) : json(nullptr);
}

json limit_json(const LimitSample& limit) {
  return {{"max_stiffness", finite_or_null(limit.max_stiffness)},
          {"worst_frequency_hz", limit.worst_frequency_hz},
          {"outcome", name_of(limit.outcome)},
          {"passive", limit.outcome == WallOutcome::passive}};
}

// The model's own wall on one device: what is left of damping, and why not.
void add_verdict(json& result, const Model& model, const Device& device) {
  try {
    PassivityModel judged = model.passivity_model();
    judged.device = device;
    const Verdict verdict = judge_passivity(judged, false);
    const auto exact =
        std::find_if(verdict.criteria.begin(), verdict.criteria.end(),
                     [](const CriterionResult& c) { return c.name == "exact_disk"; });
    result["margin"] = finite_or_null(exact->margin);
    result["explanation"] = verdict.explanation;
  } catch (const Error& error) {  // unstable alone: no margin
    result["margin"] = nullptr;
    result["explanation"] = error.message();
  }
}

json part_json(const Tolerance& t, const PartEffect& effect) {
  return {{"name", t.name},
          {"pointer", t.pointer},
          {"unit", t.unit.symbol},
          {"written", t.text},
          {"nominal", t.nominal},
          {"low", t.low},
          {"high", t.high},
          {"max_stiffness_at_low", finite_or_null(effect.at_low)},
          {"max_stiffness_at_high", finite_or_null(effect.at_high)},
          {"elasticity", optional_json(effect.elasticity)},
          {"sensitivity", optional_json(effect.sensitivity)},
          {"rank_correlation", effect.rank_correlation}};
}

// Equal bins over the finite limits.
json histogram_json(const std::vector<double>& sorted) {
  const auto finite =
      std::find_if(sorted.begin(), sorted.end(), [](double limit) { return std::isinf(limit); });
  const auto count = static_cast<double>(finite - sorted.begin());
  json edges = json::array();
  json counts = json::array();
  const double low = count > 0 ? sorted.front() : 0;
  const double high = count > 0 ? *std::prev(finite) : 0;
  if (high > low) {
    const int bins = static_cast<int>(std::clamp(std::sqrt(count), 5.0, 60.0));
    auto from = sorted.begin();
    for (int i = 0; i < bins; ++i) {
      const double edge = low + (high - low) * (i + 1) / bins;
      const auto to = i + 1 == bins ? finite : std::upper_bound(from, finite, edge);
      edges.push_back(low + (high - low) * i / bins);
      counts.push_back(to - from);
      from = to;
    }
    edges.push_back(high);
  }
  return {{"edges", edges}, {"count", counts}};
}

json samples_json(const ToleranceRequest& request, const ToleranceStudy& study) {
  std::vector<double> sorted;
  std::map<std::string_view, std::size_t> outcomes;
  for (const auto outcome :
       {WallOutcome::passive, WallOutcome::too_stiff, WallOutcome::no_stiffness,
        WallOutcome::device_active, WallOutcome::device_unstable})
    outcomes[name_of(outcome)] = 0;
  double sum = 0;
  for (const BoxPoint& sample : study.samples) {
    sorted.push_back(sample.limit.max_stiffness);
    sum += sample.limit.max_stiffness;
    ++outcomes[name_of(sample.limit.outcome)];
  }
  std::sort(sorted.begin(), sorted.end());
  const auto n = static_cast<double>(sorted.size());
  const double mean = sum / n;
  double squares = 0;
  for (const double limit : sorted) squares += (limit - mean) * (limit - mean);
  const Share yield = compute_share(outcomes["passive"], sorted.size());
  json quantiles = json::array();
  for (const double p : {0.0, 0.01, 0.05, 0.25, 0.5, 0.75, 0.95, 0.99, 1.0}) {
    quantiles.push_back(
        {{"probability", p}, {"max_stiffness", finite_or_null(find_quantile(sorted, p))}});
  }
  constexpr int steps = 200;
  json probability = json::array();
  json stiffness = json::array();
  for (int i = 0; i <= steps; ++i) {
    const double p = static_cast<double>(i) / steps;
    probability.push_back(p);
    stiffness.push_back(finite_or_null(find_quantile(sorted, p)));
  }
  return {{"count", sorted.size()},
          {"seed", request.seed},
          {"distribution", name_of(request.distribution)},
          {"outcomes", outcomes},
          {"yield", yield.value},
          {"yield_low", yield.low},
          {"yield_high", yield.high},
          {"mean", finite_or_null(mean)},
          {"standard_deviation", finite_or_null(std::sqrt(squares / std::max(1.0, n - 1)))},
          {"quantiles", quantiles},
          {"cumulative", {{"probability", probability}, {"max_stiffness", stiffness}}},
          {"histogram", histogram_json(sorted)}};
}

}  // namespace

ToleranceStudy run_tolerance_study(const Model& model, const ToleranceRequest& request) {
  naming_file(model, [&] { require_stable_device(model.device); });
  const LimitSampler sampler = naming_file(model, [&] { return LimitSampler(model); });
  ToleranceStudy study;
  const std::vector<double> nominal = sampler.box().nominal_values();
  study.nominal = sampler.at(nominal);
  study.samples = draw_samples(sampler, request);
  study.worst = find_worst_limit(sampler, study.samples, {request.threads, request.quiet});
  if (study.nominal.max_stiffness <= study.worst.limit.max_stiffness)  // nothing is worse
    study.worst = {study.nominal, nominal, "nominal"};
  study.effects = find_effects(sampler, study.nominal.max_stiffness, study.samples, request);
  return study;
}

bool is_robust(const ToleranceStudy& study) {
  const auto passes = [](const LimitSample& limit) {
    return limit.outcome == WallOutcome::passive;
  };
  return passes(study.nominal) && passes(study.worst.limit) &&
         std::all_of(study.samples.begin(), study.samples.end(),
                     [&](const BoxPoint& sample) { return passes(sample.limit); });
}

json make_tolerance_result(const Model& model, const ToleranceRequest& request,
                           const ToleranceStudy& study) {
  json result = start_result("tolerance", model);
  const DeviceBox box = model.device_box();
  const WallValues wall = LimitSampler(model).wall();
  result["robust"] = is_robust(study);
  result["stiffness"] = wall.stiffness;
  result["virtual_damping"] = wall.damping;
  result["nominal"] = limit_json(study.nominal);
  add_verdict(result["nominal"], model, box.nominal());
  result["worst"] = limit_json(study.worst.limit);
  add_verdict(result["worst"], model, box.at(study.worst.values));
  result["worst"]["found_by"] = study.worst.found_by;
  result["parts"] = json::array();
  for (const PartEffect& effect : study.effects) {
    json part = part_json(box.tolerances()[effect.part], effect);
    part["worst"] = study.worst.values[effect.part];
    result["parts"].push_back(std::move(part));
  }
  result["samples"] = samples_json(request, study);
  return result;
}

}  // namespace gyrator
