#include "gyrator/passivity/environment_activity.hpp"

#include "gyrator/core/error.hpp"
#include "gyrator/cosim/sampled_plant.hpp"
#include "gyrator/passivity/aliased_disk.hpp"
#include "gyrator/passivity/criteria.hpp"
#include "gyrator/passivity/frequency_grid.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <fmt/core.h>

namespace gyrator {

void EnvironmentProfile::check() const {
  if (position.size() != effort.size()) {
    throw Error(ErrorCode::bad_input, "effort",
                fmt::format("{} values for {} positions", effort.size(), position.size()));
  }
  if (position.size() < 2) {
    throw Error(ErrorCode::bad_input, "position",
                fmt::format("{} row: a profile needs at least two", position.size()));
  }
  for (std::size_t i = 1; i < position.size(); ++i) {
    if (position[i] > position[i - 1]) continue;
    throw Error(
        ErrorCode::bad_input, fmt::format("{}", i),
        fmt::format("position {:.17g} after {:.17g}: positions must increase from row to row",
                    position[i], position[i - 1]));
  }
}

double EnvironmentProfile::at(double x) const {
  if (x <= position.front()) return effort.front();
  if (x >= position.back()) return effort.back();
  const auto after = std::upper_bound(position.begin(), position.end(), x);
  const auto i = static_cast<std::size_t>(after - position.begin());
  const double share = (x - position[i - 1]) / (position[i] - position[i - 1]);
  return effort[i - 1] + share * (effort[i] - effort[i - 1]);
}

EnvironmentActivity compute_environment_activity(const EnvironmentProfile& profile,
                                                 const Sampling& sampling) {
  profile.check();
  EnvironmentActivity activity;
  for (std::size_t i = 1; i < profile.position.size(); ++i) {
    const double from = profile.position[i - 1];
    const double to = profile.position[i];
    const double slope = (profile.effort[i] - profile.effort[i - 1]) / (to - from);
    if (slope > activity.rising.slope) activity.rising = {slope, from, to};
    if (-slope > activity.falling.slope) activity.falling = {-slope, from, to};
  }
  const SplitDelay delay = split_delay(sampling);
  const double T = delay.period;
  const double kappa = activity.rising.slope;
  const double L = std::max(kappa, activity.falling.slope);
  const double s = kappa * T / 2 + L * sampling.delay.to_double();
  activity.alpha = (s + std::sqrt(s * s + L * L * delay.rest * (T - delay.rest))) / 2;
  return activity;
}

double find_worst_share(const EnvironmentActivity& activity, const Sampling& sampling) {
  const SplitDelay delay = split_delay(sampling);
  if (delay.rest == 0) return 0;
  // (p + q) (g (p + q) + L p) = alpha (p^2/rho + q^2/(T - rho)), stationary in p for p + q = 1:
  //   L = 2 alpha (p/rho - (1 - p)/(T - rho)).
  const double L = std::max(activity.rising.slope, activity.falling.slope);
  const double late = delay.rest;
  const double rest = delay.period - delay.rest;
  return (L / (2 * activity.alpha) + 1 / rest) / (1 / late + 1 / rest);
}

namespace {

std::vector<std::string> find_reasons(const Assumptions& a) {
  if (a.reads_wave) return {"the controller reads a wave, not the position"};
  std::vector<std::string> reasons;
  if (!a.ideal_drive) {
    reasons.push_back(fmt::format(
        "the command reaches the shaft through the circuit (A is not 1; it lags by {:.3g} s at low "
        "frequency)",
        a.lag_s));
  }
  if (!a.collocated) reasons.emplace_back("the sensor is not at the port");
  if (a.held) reasons.emplace_back("an analog loop of the device renders a wall of its own");
  return reasons;
}

}  // namespace

EnvironmentVerdict judge_environment(const EnvironmentProfile& profile, const Device& device,
                                     const Sampling& sampling,
                                     std::optional<double> coupling_damping) {
  if (coupling_damping && !(*coupling_damping > 0)) {
    throw Error(ErrorCode::bad_input, "coupling damping",
                fmt::format("{:g}: must be above 0", *coupling_damping));
  }
  EnvironmentVerdict verdict;
  verdict.activity = compute_environment_activity(profile, sampling);
  AliasedDisk disk(device, sampling);
  const std::vector<double> grid = make_judging_grid(disk.model().poles(), disk.period());
  for (const double omega : grid) disk.at(omega);
  verdict.dissipation = disk.least_damping().value;
  // A constant damping is least nowhere: only rounding would tell a frequency.
  const double slow = disk.model().at(grid.front()).impedance.real();
  const bool constant = verdict.dissipation > slow * (1 - 1e-6);
  const double where = constant ? grid.front() : disk.least_damping().omega;
  verdict.dissipation_frequency_hz = where / (2 * std::numbers::pi);
  verdict.coupling = coupling_damping;
  const double delta = verdict.dissipation;
  verdict.allowed = coupling_damping && delta > 0
                        ? delta * *coupling_damping / (delta + *coupling_damping)
                        : delta;
  verdict.inequality = verdict.activity.alpha < verdict.allowed;
  verdict.reasons = find_reasons(test_assumptions(device, sampling, disk.model()));
  return verdict;
}

}  // namespace gyrator
