#pragma once

#include "gyrator/controllers/controller.hpp"
#include "gyrator/core/random_stream.hpp"
#include "gyrator/passivity/aliased_disk.hpp"
#include "gyrator/robustness/box_proof.hpp"
#include "gyrator/passivity/disk_proof.hpp"
#include "gyrator/passivity/frequency_grid.hpp"

#include <cmath>
#include <string>
#include <vector>

#include "support/wave_display.hpp"

namespace gyrator::testing {

/// A device whose parts have tolerances, and the sampled side that it has at `share` of the
/// stiffness that just so keeps it passive somewhere near the worst corner.
struct BoxExample {
  std::string name;
  DeviceMaker maker;
  PartBox parts;
  Sampling sampling;
  Controller controller;

  DiscreteStateSpace law() const {
    return make_contact_law(controller, sampling.period.to_double());
  }
  /// At d_i in -1 … 1 of each part.
  std::vector<double> values_at(const std::vector<double>& places) const {
    std::vector<double> values = parts.center;
    for (std::size_t i = 0; i < values.size(); ++i) values[i] += places[i] * parts.half[i];
    return values;
  }
  /// Any point of the box.
  std::vector<double> draw_places(RandomStream& random) const {
    std::vector<double> places;
    for (std::size_t i = 0; i < parts.center.size(); ++i)
      places.push_back(2 * random.uniform() - 1);
    return places;
  }
};

/// By the point proof; where that cannot tell, at every frequency that the verdict looks at.
inline bool is_passive_at(const BoxExample& example, const std::vector<double>& values) {
  const Device device = example.maker(values);
  const DiscreteStateSpace law = example.law();
  PortModel model(device);
  const DiskProof proof = prove_disk(model, example.sampling, law);
  if (proof.outcome != ProofOutcome::undecided) return proof.outcome == ProofOutcome::proved;
  AliasedDisk disk(device, example.sampling);
  for (const double omega : make_judging_grid(disk.model().poles(), disk.period())) {
    const auto H = law.response(std::polar(1.0, omega * disk.period()));
    if (!(disk.at(omega).damping_margin(H) > 0)) return false;
  }
  return true;
}

/// What one of a device's quantities is, and by which share of its nominal value it varies.
struct VariedPart {
  double share = 0;
  std::function<double&(Device&)> of;
};

inline BoxExample make_box_example(std::string name, Device nominal,
                                   const std::vector<VariedPart>& parts, Sampling sampling,
                                   Controller controller) {
  nominal.gain = find_amplifier_gain(nominal);
  BoxExample example{std::move(name), {}, {}, sampling, std::move(controller)};
  for (const VariedPart& part : parts) {
    Device device = nominal;
    const double value = part.of(device);
    example.parts.center.push_back(value);
    example.parts.half.push_back(value == 0 ? part.share : part.share * value);
  }
  example.maker = [nominal, parts](std::span<const double> values) {
    Device device = nominal;
    for (std::size_t i = 0; i < parts.size(); ++i) parts[i].of(device) = values[i];
    return device;
  };
  return example;
}

inline std::vector<VariedPart> vary_motor(double share) {
  return {{share, [](Device& d) -> double& { return d.drive.motor->torque_constant; }},
          {share, [](Device& d) -> double& { return d.drive.motor->resistance; }},
          {share, [](Device& d) -> double& { return d.drive.motor->inductance; }},
          {30, [](Device& d) -> double& { return d.drive.motor->temperature_rise; }},
          {share, [](Device& d) -> double& { return d.mechanics.inertia; }},
          {2 * share, [](Device& d) -> double& { return d.mechanics.damping; }}};
}

inline Device make_box_motor() {
  Device device;
  device.drive.motor = Motor{0.05, 1.5, 5e-4};
  device.mechanics.inertia = 2e-5;
  device.mechanics.damping = 1e-4;
  return device;
}

/// One of each kind of drive and sensor.
inline std::vector<BoxExample> list_box_examples() {
  const Sampling prompt{Rational(1, 1000)};
  const Sampling late{Rational(1, 1000), Rational(13, 10000)};
  const Sampling whole{Rational(1, 2000), Rational(1, 2000)};
  std::vector<BoxExample> examples;

  Device ideal;
  ideal.mechanics = {2e-5, 1e-4, 0, {}, {}, 0, {}};
  examples.push_back(
      make_box_example("ideal drive", ideal,
                       {{0.1, [](Device& d) -> double& { return d.mechanics.inertia; }},
                        {0.2, [](Device& d) -> double& { return d.mechanics.damping; }}},
                       prompt, VirtualWall{0.14, 0}));

  Device rc = make_box_motor();
  rc.drive.amplifier = CurrentAmplifier{};
  rc.drive.damping = {RcDamping{5, 2200e-6}};
  std::vector<VariedPart> parts = vary_motor(0.08);
  parts.push_back({0.02, [](Device& d) -> double& {
                     return std::get<RcDamping>(d.drive.damping[0]).resistance;
                   }});
  parts.push_back({0.2, [](Device& d) -> double& {
                     return std::get<RcDamping>(d.drive.damping[0]).capacitance;
                   }});
  examples.push_back(make_box_example("rc circuit", rc, parts, prompt, VirtualWall{0.033, 1.5e-4}));
  examples.push_back(
      make_box_example("rc circuit, 1.3 periods late", rc, parts, late, VirtualWall{0.01, 5e-5}));

  Device voltage = make_box_motor();
  voltage.drive.amplifier = VoltageAmplifier{2000, 0.5, {}, {}};
  parts = vary_motor(0.05);
  parts.push_back({0.1, [](Device& d) -> double& {
                     return std::get<VoltageAmplifier>(d.drive.amplifier).output_resistance;
                   }});
  examples.push_back(
      make_box_example("voltage drive", voltage, parts, prompt, VirtualWall{0.5, 2e-4}));

  Device compliant = make_box_motor();
  compliant.drive.amplifier = CurrentAmplifier{3000};
  compliant.drive.damping = {ResistorDamping{10}};
  compliant.mechanics.transmission = Transmission{2, 1e-4, 5e-6};
  parts = vary_motor(0.05);
  parts.push_back({0.1, [](Device& d) -> double& { return d.mechanics.transmission->stiffness; }});
  parts.push_back({0.2, [](Device& d) -> double& { return d.mechanics.transmission->damping; }});
  examples.push_back(
      make_box_example("compliant, sensor at port", compliant, parts, whole, VirtualWall{0.01, 0}));
  compliant.sensor = SensorLocation::motor;
  examples.push_back(make_box_example("compliant, sensor at motor", compliant, parts, whole,
                                      VirtualWall{0.08, 1e-5}));

  Device wave = make_wave_display();
  const WaveController waves = make_wave_controller(wave, WaveWall{0.05, 1e-4});
  examples.push_back(
      make_box_example("wave drive", wave,
                       {{0.05, [](Device& d) -> double& { return d.drive.motor->resistance; }},
                        {0.05, [](Device& d) -> double& { return d.drive.motor->torque_constant; }},
                        {0.2, [](Device& d) -> double& { return d.mechanics.damping; }}},
                       prompt, waves));
  return examples;
}

}  // namespace gyrator::testing
