#pragma once

// Random devices of every linear kind of drive and damping under random sampled walls, for the
// exact disk's bound from both sides.

#include "gyrator/core/error.hpp"
#include "gyrator/mechanics/actuation_roots.hpp"
#include "gyrator/mechanics/stability.hpp"
#include "gyrator/passivity/verdict.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <functional>
#include <numbers>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <fmt/core.h>

#include "random_drives.hpp"

namespace gyrator::reference {

/// A loop drawn at random, with the exact disk's limit of its wall.
struct RandomLoop {
  std::string kind;
  std::uint64_t seed = 0;  ///< of this loop alone: draw_loop() makes it again
  Device device;
  Sampling sampling;
  Controller controller;  ///< its wall at stiffness zero
  double virtual_damping = 0;
  double limit = 0;             ///< K by exact_disk
  double share_of_nyquist = 0;  ///< where the disk binds

  PassivityModel model(double share) const {
    PassivityModel m{device, controller, sampling, 0};
    if (auto* wall = std::get_if<VirtualWall>(&m.controller.law)) {
      wall->stiffness = share * limit;
    } else {
      auto& line = std::get<WaveController>(m.controller.law);
      std::get<WaveWall>(line.environment).stiffness = share * limit;
    }
    return m;
  }

  double spectral_radius(double share, const Operator& held_by) const {
    const PassivityModel m = model(share);
    const DiscreteStateSpace law = make_contact_law(m.controller, sampling.period.to_double());
    const Plant plant = build_plant(build_device_network(device, held_by));
    return compute_spectral_radius(build_loop_matrix(sample_plant(plant, sampling), law));
  }

  /// What is random beside the kind.
  std::string describe() const {
    std::string text =
        fmt::format("{} seed {} T {} delay {} B {:.4g} K {:.6g} binds at {:.3g} of Nyquist", kind,
                    seed, sampling.period.to_string(), sampling.delay.to_string(), virtual_damping,
                    limit, share_of_nyquist);
    if (device.mechanics.transmission) text += ", transmission";
    if (device.sensor == SensorLocation::motor) text += ", sensor at the motor";
    if (device.sensor_filter)
      text += fmt::format(", filter {:.4g} Hz order {}", device.sensor_filter->cutoff_hz,
                          device.sensor_filter->order);
    if (const auto* wall = std::get_if<VirtualWall>(&controller.law))
      text += fmt::format(", {}", name_of(wall->velocity));
    if (!controller.wrappers.empty()) text += ", pre-emphasis";
    return text;
  }
};

/// The linear kinds of drive. Beside make_damping_kinds(): an RC branch, a voltage amplifier alone,
/// a wave drive whose position is sensed, and the wave line of an amplifier 10 % stronger than its
/// controller believes (otherwise nothing limits it).
inline std::vector<DampingKind> make_loop_kinds() {
  std::vector<DampingKind> kinds = make_damping_kinds();
  kinds.push_back(
      {"rc", [](Random& random, const RcParameters&, Device& device) {
         drive_by_current(random, device);
         device.drive.damping = {RcDamping{random.uniform(0, 20), random.log_uniform(10e-6, 5e-3)}};
       }});
  kinds.push_back({"voltage", [](Random& random, const RcParameters&, Device& device) {
                     device.drive.amplifier =
                         VoltageAmplifier{maybe_hz(random, 500, 5e3), random.uniform(0, 2)};
                   }});
  const auto wave = [](Random& random, const RcParameters& p, Device& device) {
    device.drive.amplifier = VoltageAmplifier{};
    // b_w = K_t^2/R_w, R_w from half to five times the winding
    const double b_w = p.K_t * p.K_t / (p.R_m * random.log_uniform(0.5, 5));
    device.drive.damping = {WaveDamping{b_w}};
    if (random.chance(0.5))
      device.drive.damping.push_back(ResistanceCancellation{p.R_m * random.uniform(0.2, 0.9), {}});
  };
  kinds.push_back({"wave", wave});
  kinds.push_back({"wave line", [wave](Random& random, const RcParameters& p, Device& device) {
                     wave(random, p, device);
                     device.sensor = SensorLocation::outgoing_wave;
                   }});
  return kinds;
}

inline VelocityEstimator draw_estimator(Random& random, double period) {
  if (random.chance(0.4)) return DifferenceEstimator{};
  const double which = random.uniform(0, 3);
  const double cutoff = random.log_uniform(0.02, 0.4) / period;  // Nyquist is 0.5
  if (which < 1) return DifferenceEstimator{2 + static_cast<int>(random.uniform(0, 7))};
  if (which < 2) return FilteredDifferenceEstimator{cutoff};
  return ButterworthEstimator{1 + static_cast<int>(random.uniform(0, 4)), cutoff};
}

/// Half of the devices have a compliant transmission, half of these the sensor at the motor; one in
/// four an analog filter before the sampler.
inline void draw_mechanics(Random& random, double period, Device& device) {
  if (device.sensor == SensorLocation::outgoing_wave) return;
  if (random.chance(0.5)) {
    const double load = device.mechanics.inertia * random.log_uniform(0.1, 10);
    const double resonance = random.log_uniform(0.2, 20) / period;
    const double both = 1 / (1 / load + 1 / device.mechanics.inertia);
    const double stiffness = both * resonance * resonance;
    const double loss = random.log_uniform(1e-3, 0.3) * std::sqrt(stiffness * both);
    device.mechanics.transmission = Transmission{stiffness, loss, load};
    if (random.chance(0.5)) device.sensor = SensorLocation::motor;
  }
  if (random.chance(0.25))
    device.sensor_filter =
        SensorFilter{random.log_uniform(0.02, 2) / period, random.chance(0.5) ? 1 : 2};
}

/// None, whole periods, or hundredths of one, a third of the loops each.
inline Rational draw_delay(Random& random, const Rational& period) {
  const double which = random.uniform(0, 3);
  const double hundredths = random.uniform(0, 200);
  if (which < 1) return 0;
  if (which < 2) return period * Rational(1 + static_cast<std::int64_t>(hundredths / 100));
  return period * Rational(static_cast<std::int64_t>(hundredths), 100);
}

inline void draw_controller(Random& random, double b, RandomLoop& loop) {
  const double period = loop.sampling.period.to_double();
  loop.virtual_damping = random.uniform(-0.5 * b, b);
  if (loop.device.sensor == SensorLocation::outgoing_wave) {
    const auto& drive = loop.device.drive;
    WaveController wave;
    loop.virtual_damping = random.uniform(0, b);
    wave.environment = WaveWall{.damping = loop.virtual_damping};
    wave.impedance = std::get<WaveDamping>(drive.damping[0]).impedance;
    wave.volts_per_velocity = drive.motor->torque_constant;
    wave.volts_per_command =
        build_device_network(loop.device, FreeOperator{}).drive.volts_per_command / 1.1;
    loop.controller = wave;
    return;
  }
  loop.controller =
      VirtualWall{.damping = loop.virtual_damping, .velocity = draw_estimator(random, period)};
  if (!random.chance(0.2)) return;
  const ActuationRoots roots = find_actuation_roots(loop.device);
  loop.controller.wrappers.emplace_back(make_pre_emphasis(
      roots.poles, roots.zeros, random.uniform(0.2, 1) * std::numbers::pi / period, period));
}

/// The loop of a seed; none where no stiffness is passive at the virtual damping drawn, where none
/// is too large, or where the device is unstable or active alone.
inline std::optional<RandomLoop> draw_loop(const DampingKind& kind, std::uint64_t seed) {
  Random random(seed);
  RandomLoop loop;
  loop.kind = kind.name;
  loop.seed = seed;
  RcParameters p;
  p.J = random.log_uniform(1e-6, 1e-4);
  p.b = random.log_uniform(1e-5, 1e-3);
  p.K_t = random.log_uniform(0.01, 0.1);
  p.R_m = random.log_uniform(0.5, 10);
  p.L_m = random.log_uniform(0.05e-3, 2e-3);
  loop.device.mechanics.inertia = p.J;
  loop.device.mechanics.damping = p.b;
  loop.device.drive.motor = Motor{p.K_t, p.R_m, p.L_m};
  loop.sampling.period =
      Rational(static_cast<std::int64_t>(random.log_uniform(250, 2000)), 1'000'000);
  loop.sampling.delay = draw_delay(random, loop.sampling.period);
  try {
    kind.equip(random, p, loop.device);
    draw_mechanics(random, loop.sampling.period.to_double(), loop.device);
    require_stable_device(loop.device);
    draw_controller(random, p.b, loop);
  } catch (const Error&) {
    return std::nullopt;
  }
  StiffnessLimits limits(loop.device, loop.sampling, loop.controller, FreeOperator{});
  const StiffnessLimit limit = limits.find(Criterion::exact_disk, loop.virtual_damping);
  if (!limit.feasible || !std::isfinite(limit.stiffness)) return std::nullopt;
  loop.limit = limit.stiffness;
  loop.share_of_nyquist = 2 * limit.worst_frequency_hz * loop.sampling.period.to_double();
  return loop;
}

/// Loops of one kind from consecutive seeds; `rejected` counts what draw_loop() left out.
struct RandomLoops {
  std::vector<RandomLoop> loops;
  int rejected = 0;
};
inline RandomLoops draw_loops(const DampingKind& kind, int count, std::uint64_t first_seed) {
  RandomLoops drawn;
  for (std::uint64_t seed = first_seed; static_cast<int>(drawn.loops.size()) < count; ++seed) {
    if (auto loop = draw_loop(kind, seed)) {
      drawn.loops.push_back(*loop);
    } else if (++drawn.rejected > 50 * count) {
      break;
    }
  }
  return drawn;
}

/// Passive operators over the orders of magnitude around the loop's own: every kind of mass–spring–
/// damper with up to eight resonators, and those about the counterexample, where one is known:
/// shifted by some per cent, damped.
inline std::vector<MassSpringDamper> draw_passive_operators(
    Random& random, const RandomLoop& loop, int count,
    const std::optional<MassSpringDamper>& about) {
  const double period = loop.sampling.period.to_double();
  const double inertia = loop.device.mechanics.inertia;
  const double stiffness = std::max(loop.limit, 1e-9);
  std::vector<MassSpringDamper> operators{{}};
  const auto near = [&](double value) { return value * random.log_uniform(0.9, 1.1); };
  while (static_cast<int>(operators.size()) < count) {
    MassSpringDamper held_by;
    if (about && random.chance(0.4)) {
      held_by = {near(about->inertia), 0, near(about->stiffness), {}};
      for (const auto& r : about->resonators)
        held_by.resonators.push_back({near(r.inertia), near(r.stiffness)});
    } else {
      // The wall's spring with the operator's inertia: anywhere from 1e-4 of Nyquist to it.
      const double omega = random.log_uniform(1e-4, 1) * std::numbers::pi / period;
      if (random.chance(0.8)) held_by.inertia = stiffness / (omega * omega);
      if (random.chance(0.3)) held_by.inertia = inertia * random.log_uniform(1e-2, 1e3);
      if (random.chance(0.5)) held_by.stiffness = stiffness * random.log_uniform(1e-3, 1e2);
      while (held_by.resonators.size() < 8 && random.chance(0.4)) {
        const double hung = inertia * random.log_uniform(1e-3, 1e3);
        const double tuned = random.log_uniform(1e-3, 8) * std::numbers::pi / period;
        held_by.resonators.push_back({hung, hung * tuned * tuned});
      }
    }
    if (random.chance(0.4))
      held_by.damping = loop.device.mechanics.damping * random.log_uniform(1e-3, 1e2);
    operators.push_back(held_by);
  }
  return operators;
}

}  // namespace gyrator::reference
