#pragma once

// Random RC-damped devices, for the study that shows the exact disk's bound safe and tight.

#include "gyrator/cosim/sampled_plant.hpp"
#include "gyrator/cosim/simulation.hpp"
#include "gyrator/passivity/verdict.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include <fmt/core.h>

#include "../support/passivity_closed_forms.hpp"

namespace gyrator::reference {

using passivity_tests::Random;
using passivity_tests::RcParameters;

/// A current-driven motor with an RC branch under a sampled wall, and its exact-disk limit.
struct RcCase {
  RcParameters parameters;
  Device device;
  Sampling sampling;
  double virtual_damping = 0;
  double limit = 0;             ///< K by exact_disk [N.m/rad]
  double textbook = 0;          ///< K by frequency_dependent
  double share_of_nyquist = 0;  ///< where the disk binds

  PassivityModel model(double share) const {
    return {device, VirtualWall{share * limit, virtual_damping}, sampling, 0};
  }
  std::string describe() const {
    const RcParameters& p = parameters;
    return fmt::format(
        "J {:.4g} b {:.4g} K_t {:.4g} R_m {:.4g} L_m {:.4g} R_1 {:.4g} C {:.4g} T {} delay {} B "
        "{:.4g} K {:.5g} binds "
        "at {:.4g} of Nyquist",
        p.J, p.b, p.K_t, p.R_m, p.L_m, p.R_1, p.C, sampling.period.to_string(),
        sampling.delay.to_string(), virtual_damping, limit, share_of_nyquist);
  }
};

/// Draws a device; none where no stiffness at all is passive at the virtual damping drawn. That
/// lies between -b/2 and the whole damping at hand, b and the plateau K_t^2/(R_1 + R_m); half of
/// the devices compute without a delay, the others with up to two periods in hundredths of one.
inline std::optional<RcCase> draw_case(Random& random) {
  RcCase c;
  RcParameters& p = c.parameters;
  p.J = random.log_uniform(1e-6, 1e-4);
  p.b = random.log_uniform(1e-5, 1e-3);
  p.K_t = random.log_uniform(0.01, 0.1);
  p.R_m = random.log_uniform(0.5, 10);
  p.L_m = random.log_uniform(0.05e-3, 2e-3);
  p.R_1 = random.uniform(0, 20);
  p.C = random.log_uniform(10e-6, 5e-3);
  const double microseconds = random.log_uniform(250, 2000);
  c.sampling.period = Rational(static_cast<std::int64_t>(microseconds), 1'000'000);
  const bool late = random.chance(0.5);
  const double hundredths = random.uniform(0, 200);
  if (late)
    c.sampling.delay = c.sampling.period * Rational(static_cast<std::int64_t>(hundredths), 100);
  c.virtual_damping = random.uniform(-0.5 * p.b, p.b + p.K_t * p.K_t / (p.R_1 + p.R_m));
  c.device = passivity_tests::make_rc_motor(p).device;
  StiffnessLimits limits(c.device, c.sampling, DifferenceEstimator{}, FreeOperator{});
  const StiffnessLimit limit = limits.find(Criterion::exact_disk, c.virtual_damping);
  if (!limit.feasible) return std::nullopt;
  c.limit = limit.stiffness;
  c.share_of_nyquist = 2 * limit.worst_frequency_hz * c.sampling.period.to_double();
  const StiffnessLimit textbook = limits.find(Criterion::frequency_dependent, c.virtual_damping);
  c.textbook = textbook.feasible ? textbook.stiffness : 0;
  return c;
}

/// Devices from one seed, the infeasible ones counted and left out.
struct RcCases {
  std::vector<RcCase> cases;
  int infeasible = 0;
};
inline RcCases draw_cases(int count, std::uint64_t seed) {
  Random random(seed);
  RcCases drawn;
  while (static_cast<int>(drawn.cases.size()) < count) {
    if (auto c = draw_case(random)) {
      drawn.cases.push_back(*c);
    } else {
      ++drawn.infeasible;
    }
  }
  return drawn;
}

/// Inertias and springs over the orders of magnitude around the device's own J and J/T^2: alone,
/// together, half of them damped, a quarter with resonators.
inline std::vector<MassSpringDamper> draw_operators(Random& random, const RcCase& c, int count) {
  const double inertia = c.parameters.J;
  const double period = c.sampling.period.to_double();
  std::vector<MassSpringDamper> operators;
  for (int i = 0; i < count; ++i) {
    MassSpringDamper held_by;
    if (i % 3 != 0) held_by.inertia = inertia * random.log_uniform(1e-2, 1e5);
    if (i % 3 != 1) held_by.stiffness = inertia / (period * period) * random.log_uniform(1e-6, 10);
    if (random.chance(0.5)) held_by.damping = c.parameters.b * random.log_uniform(1e-2, 1e2);
    while (random.chance(0.25)) {
      const double hung = inertia * random.log_uniform(1e-2, 1e3);
      const double tuned = random.log_uniform(1e-3, 2) * passivity_tests::pi / period;
      held_by.resonators.push_back({hung, hung * tuned * tuned});
    }
    operators.push_back(held_by);
  }
  return operators;
}

/// Spectral radius of the exact loop at a share of the limit.
inline double find_radius(const RcCase& c, double share, const MassSpringDamper& held_by) {
  const PassivityModel model = c.model(share);
  const DiscreteStateSpace law = make_contact_law(model.controller, c.sampling.period.to_double());
  return judge_operator(c.device, c.sampling, law, held_by).spectral_radius;
}

enum class RunResult { diverges, does_not_diverge, too_slow };

/// Runs the loop with the counterexample at a share of the limit, long enough for the sixth of the
/// run that the classification compares to grow by 4 % (2 % is divergence); longer where modes that
/// decay as slowly still hide the one that grows. Too slow where `most_samples` do not do.
inline RunResult run_counterexample(const RcCase& c, double share,
                                    const Counterexample& counterexample, double most_samples) {
  const Plant plant = build_plant(build_device_network(c.device, counterexample.held_by));
  for (const double growth : {0.04, 0.2, 1.0, 4.0}) {
    const double samples = std::max(6 * growth / (counterexample.spectral_radius - 1), 600.0);
    if (samples > most_samples)
      return growth == 0.04 ? RunResult::too_slow : RunResult::does_not_diverge;
    SimulationOptions options;
    options.duration = c.sampling.period * Rational(static_cast<std::int64_t>(samples));
    options.initial_velocity = 1;
    options.engine_options.ledger = false;
    const PassivityModel model = c.model(share);
    const TimeRun result = simulate(plant, {}, model.controller, c.sampling, options);
    if (result.classification.outcome == Outcome::diverges) return RunResult::diverges;
  }
  return RunResult::does_not_diverge;
}

}  // namespace gyrator::reference
