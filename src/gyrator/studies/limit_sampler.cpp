#include "gyrator/studies/limit_sampler.hpp"

#include "gyrator/core/error.hpp"
#include "gyrator/mechanics/stability.hpp"
#include "gyrator/passivity/held_limit.hpp"
#include "gyrator/passivity/stiffness_limit.hpp"
#include "gyrator/passivity/verdict.hpp"

#include <cmath>
#include <numbers>
#include <optional>

namespace gyrator {
namespace {

// As require_stable_device, without a search for what to do about it.
bool is_stable_alone(const Device& whole) {
  Device device = whole;
  std::erase_if(device.drive.damping,
                [](const Damping& d) { return std::holds_alternative<HeldImpedance>(d); });
  return !find_unstable_pole(build_device_network(device, ClampedOperator{})) &&
         !find_unstable_pole(build_device_network(device, FreeOperator{}));
}

}  // namespace

WallValues require_wall(const Model& model) {
  if (const HeldImpedance* held = find_held_impedance(model.device))
    return {held->stiffness, held->damping};
  const auto wall = find_wall_values(model.controller);
  if (!wall) {
    throw Error(ErrorCode::bad_input, "controller/kind",
                "no wall whose largest stiffness could be found: use virtual_wall, "
                "predictive_wall or wave");
  }
  return *wall;
}

std::string_view name_of(WallOutcome outcome) {
  switch (outcome) {
    case WallOutcome::passive:
      return "passive";
    case WallOutcome::too_stiff:
      return "too_stiff";
    case WallOutcome::no_stiffness:
      return "no_stiffness";
    case WallOutcome::device_active:
      return "device_active";
    case WallOutcome::device_unstable:
      break;
  }
  return "device_unstable";
}

std::string_view name_of(SampleDistribution distribution) {
  return distribution == SampleDistribution::uniform ? "uniform" : "normal";
}

LimitSampler::LimitSampler(const Model& model)
    : box_(model.device_box()),
      wall_(require_wall(model)),
      controller_(model.sampled_controller()),
      sampling_(model.sampling),
      quantum_(model.sensor.quantum) {
  require_tolerances(box_);
}

LimitSample LimitSampler::at(std::span<const double> values, LimitSearch search) const {
  const Device device = box_.at(values);
  if (!is_stable_alone(device)) return {0, 0, WallOutcome::device_unstable};
  if (find_held_impedance(device)) {
    const StiffnessLimit limit = find_held_stiffness_limit(device, wall_.damping);
    const double K = limit.feasible ? limit.stiffness : 0;
    return {K, limit.worst_frequency_hz,
            !limit.feasible        ? WallOutcome::no_stiffness
            : wall_.stiffness <= K ? WallOutcome::passive
                                   : WallOutcome::too_stiff};
  }
  StiffnessLimits limits(device, sampling_, controller_, FreeOperator{}, GridDensity::coarse);
  const StiffnessLimit limit = search == LimitSearch::on_grid
                                   ? limits.find_on_grid(wall_.damping)
                                   : limits.find(Criterion::exact_disk, wall_.damping);
  if (!limit.feasible) {
    const bool active = limits.disk().least_damping().active;
    return {0, limit.worst_frequency_hz,
            active ? WallOutcome::device_active : WallOutcome::no_stiffness};
  }
  LimitSample sample{limit.stiffness, limit.worst_frequency_hz, WallOutcome::passive};
  if (wall_.stiffness < limit.stiffness) return sample;
  // Just above the first stiffness that fails, the disk is exceeded where it was met; far above,
  // the wall may be passive again.
  const double omega = 2 * std::numbers::pi * limit.worst_frequency_hz;
  const LawFamily family(controller_, sampling_.period.to_double());
  const auto law = family.at(family.prepare(omega), wall_.damping).at(wall_.stiffness);
  const bool fails_there = !(limits.disk().at(omega).damping_margin(law) > 0);
  if (fails_there || !is_passive_above_limit(device)) sample.outcome = WallOutcome::too_stiff;
  return sample;
}

bool LimitSampler::is_passive_above_limit(const Device& device) const {
  return judge_passivity({device, controller_, sampling_, quantum_}, false).passive;
}

std::vector<double> draw_values(const std::vector<Tolerance>& tolerances, std::uint64_t seed,
                                std::uint64_t index, SampleDistribution distribution) {
  constexpr double cut = 3;  // standard deviations
  RandomStream random(seed, index);
  std::vector<double> values;
  values.reserve(tolerances.size());
  for (const Tolerance& t : tolerances) {
    if (distribution == SampleDistribution::uniform) {
      values.push_back(t.low + random.uniform() * (t.high - t.low));
      continue;
    }
    double z = random.normal();
    while (std::abs(z) > cut) z = random.normal();
    values.push_back(t.nominal + z / cut * (z < 0 ? t.nominal - t.low : t.high - t.nominal));
  }
  return values;
}

}  // namespace gyrator
