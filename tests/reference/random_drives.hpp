#pragma once

// Random devices of every linear kind of damping, for the exact disk's bound on each of them.

#include "gyrator/core/error.hpp"
#include "gyrator/mechanics/stability.hpp"

#include <functional>
#include <string>
#include <utility>

#include "random_rc.hpp"

namespace gyrator::reference {

struct DampingKind {
  std::string name;
  /// Gives the device, which has a motor and nothing else, its amplifier and damping.
  std::function<void(Random&, const RcParameters&, Device&)> equip;
};

inline std::optional<double> maybe_hz(Random& random, double from, double to) {
  const double hz = random.log_uniform(from, to);
  return random.chance(0.5) ? std::optional<double>(hz) : std::nullopt;
}

inline void drive_by_current(Random& random, Device& device) {
  device.drive.amplifier = CurrentAmplifier{maybe_hz(random, 200, 5e3)};
}

inline std::vector<DampingKind> make_damping_kinds() {
  return {
      {"resistor",
       [](Random& random, const RcParameters&, Device& device) {
         drive_by_current(random, device);
         device.drive.damping = {ResistorDamping{random.log_uniform(0.5, 50)}};
       }},
      {"resistance_cancellation",
       [](Random& random, const RcParameters& p, Device& device) {
         const double R_o = random.chance(0.5) ? random.uniform(0, 0.5) : 0;
         device.drive.amplifier = VoltageAmplifier{maybe_hz(random, 500, 5e3), R_o};
         const double R_c = random.uniform(0.2, 0.95) * (p.R_m + R_o);
         device.drive.damping = {ResistanceCancellation{R_c, maybe_hz(random, 1e3, 1e5)}};
       }},
      {"back_emf",
       [](Random& random, const RcParameters& p, Device& device) {
         drive_by_current(random, device);
         BackEmfDamping d;
         // Two lags turn an eighth of the damping round: more than eight times b is active.
         d.damping = p.b * random.log_uniform(0.1, 8);
         d.resistance_estimate = p.R_m * random.uniform(0.8, 1.05);
         d.inductance_estimate = p.L_m * random.uniform(0.7, 1);
         d.low_pass_hz = random.log_uniform(50, 2e3);
         if (random.chance(0.3)) d.high_pass_hz = random.log_uniform(0.5, 20);
         device.drive.damping = {d};
       }},
      {"torque_sensed_damper",
       [](Random& random, const RcParameters& p, Device& device) {
         drive_by_current(random, device);
         device.drive.damping = {
             TorqueSensedDamper{p.b * random.log_uniform(0.1, 100), random.log_uniform(1, 200)}};
       }},
      {"eddy_current_brake",
       [](Random& random, const RcParameters& p, Device& device) {
         drive_by_current(random, device);
         device.drive.damping = {EddyCurrentBrake{p.b * random.log_uniform(0.1, 100), true}};
       }},
      {"high_pass_damper",
       [](Random& random, const RcParameters& p, Device& device) {
         drive_by_current(random, device);
         device.drive.damping = {HighPassDamper{p.J * random.log_uniform(0.01, 10),
                                                p.b * random.log_uniform(0.1, 100)}};
       }},
  };
}

/// Draws a device of the kind; none where no stiffness is passive at the virtual damping drawn, or
/// where the device is unstable alone.
inline std::optional<RcCase> draw_drive_case(Random& random, const DampingKind& kind) {
  RcCase c;
  RcParameters& p = c.parameters;
  p.J = random.log_uniform(1e-6, 1e-4);
  p.b = random.log_uniform(1e-5, 1e-3);
  p.K_t = random.log_uniform(0.01, 0.1);
  p.R_m = random.log_uniform(0.5, 10);
  p.L_m = random.log_uniform(0.05e-3, 2e-3);
  const double microseconds = random.log_uniform(250, 2000);
  c.sampling.period = Rational(static_cast<std::int64_t>(microseconds), 1'000'000);
  const bool late = random.chance(0.5);
  const double hundredths = random.uniform(0, 200);
  if (late)
    c.sampling.delay = c.sampling.period * Rational(static_cast<std::int64_t>(hundredths), 100);
  c.virtual_damping = random.uniform(-0.5 * p.b, p.b);
  c.device.mechanics.inertia = p.J;
  c.device.mechanics.damping = p.b;
  c.device.drive.motor = Motor{p.K_t, p.R_m, p.L_m};
  kind.equip(random, p, c.device);
  try {
    require_stable_device(c.device);
  } catch (const Error&) {
    return std::nullopt;
  }
  StiffnessLimits limits(c.device, c.sampling, DifferenceEstimator{}, FreeOperator{});
  const StiffnessLimit limit = limits.find(Criterion::exact_disk, c.virtual_damping);
  if (!limit.feasible || !std::isfinite(limit.stiffness)) return std::nullopt;
  c.limit = limit.stiffness;
  c.share_of_nyquist = 2 * limit.worst_frequency_hz * c.sampling.period.to_double();
  const StiffnessLimit textbook = limits.find(Criterion::frequency_dependent, c.virtual_damping);
  c.textbook = textbook.feasible ? textbook.stiffness : 0;
  return c;
}

inline RcCases draw_drive_cases(const DampingKind& kind, int count, std::uint64_t seed) {
  Random random(seed);
  RcCases drawn;
  while (static_cast<int>(drawn.cases.size()) < count) {
    if (auto c = draw_drive_case(random, kind)) {
      drawn.cases.push_back(*c);
    } else if (++drawn.infeasible > 100 * count) {
      break;
    }
  }
  return drawn;
}

}  // namespace gyrator::reference
