#pragma once

#include "gyrator/core/random_stream.hpp"
#include "gyrator/identification/identification.hpp"
#include "gyrator/twin/twin_bench.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <string>
#include <vector>

#include <fmt/core.h>

#include "support/motor_bench.hpp"

namespace gyrator {

/// A motor within ± 50 % of RE25, RE35 or RE40, behind an amplifier that nobody knows.
inline BenchMotor make_hidden_motor(std::uint64_t seed, int device) {
  struct Nominal {
    double resistance, inductance, constant, inertia, damping, friction, current;
  };
  // Catalogue values (cases.md); friction from the no-load currents.
  static constexpr Nominal nominals[] = {{2.06, 0.238e-3, 23.5e-3, 1.07e-6, 1.2e-6, 3e-4, 5},
                                         {1.2, 0.34e-3, 38.9e-3, 6.81e-6, 6.33e-6, 1.5e-3, 8},
                                         {0.316, 0.08e-3, 30.2e-3, 1.34e-5, 5e-6, 2.5e-3, 12}};
  RandomStream random(seed, static_cast<std::uint64_t>(device));
  const Nominal& nominal = nominals[device % 3];
  const auto vary = [&](double value) { return value * (0.5 + random.uniform()); };
  BenchMotor motor;
  motor.resistance = vary(nominal.resistance);
  motor.inductance = vary(nominal.inductance);
  motor.torque_constant = vary(nominal.constant);
  motor.inertia = vary(nominal.inertia);
  motor.damping = vary(nominal.damping);
  motor.coulomb_friction = vary(nominal.friction);
  motor.bandwidth_hz = 500 * std::pow(6, random.uniform());
  motor.delay = 300e-6 * random.uniform();
  motor.temperature = 318.15;
  motor.thermal_resistance = 10;
  motor.thermal_capacity = 5;
  motor.current_limit = nominal.current;
  motor.voltage_limit = 24;
  motor.velocity_limit = 0;
  motor.current_noise = 0.002 * motor.current_limit;
  motor.voltage_noise = 0.002 * motor.voltage_limit;
  motor.velocity_noise = 0.002 * 1000;
  motor.current_quantum = motor.current_limit / 2048;
  motor.voltage_quantum = motor.voltage_limit / 2048;
  const double counts = 2000 * std::pow(2, std::floor(4 * random.uniform()));
  motor.position_quantum = 2 * std::numbers::pi / counts;
  motor.seed = seed * 1000 + static_cast<std::uint64_t>(device);
  return motor;
}

/// The same motor and amplifier as a twin.
inline TwinDevice make_hidden_twin(const BenchMotor& motor) {
  TwinDevice twin;
  CurrentAmplifier amplifier;
  amplifier.bandwidth_hz = motor.bandwidth_hz;
  amplifier.current_limit = motor.current_limit;
  amplifier.voltage_limit = motor.voltage_limit;
  Motor inside;
  inside.torque_constant = motor.torque_constant;
  inside.resistance = motor.resistance;
  inside.inductance = motor.inductance;
  twin.device.drive.amplifier = amplifier;
  twin.device.drive.motor = inside;
  twin.device.mechanics.inertia = motor.inertia;
  twin.device.mechanics.damping = motor.damping;
  twin.device.mechanics.coulomb_friction = motor.coulomb_friction;
  twin.delay = motor.delay;
  twin.noise = {0, motor.current_noise, motor.voltage_noise, motor.velocity_noise, 0};
  twin.position_quantum = motor.position_quantum;
  twin.current_step = motor.current_quantum;
  twin.voltage_step = motor.voltage_quantum;
  twin.thermal = {motor.thermal_resistance, motor.thermal_capacity};
  twin.winding_rise = motor.temperature - twin.ambient;
  if (motor.velocity_limit > 0) twin.velocity_limit = motor.velocity_limit;
  twin.seed = motor.seed;
  return twin;
}

inline std::map<std::string, double> find_truth(const BenchMotor& motor) {
  return {{"resistance", motor.resistance},
          {"inductance", motor.inductance},
          {"torque_constant", motor.torque_constant},
          {"inertia", motor.inertia},
          {"damping", motor.damping},
          {"coulomb_friction", motor.coulomb_friction},
          {"bandwidth", motor.bandwidth_hz},
          {"delay", motor.delay}};
}

struct ParameterScore {
  int cases = 0, covered = 0, identifiable = 0;
  std::vector<double> errors, widths, pulls;  // relative; error per deviation-like half width
};

enum class StudyBench { own, twin };

struct IdentificationStudy {
  std::map<std::string, ParameterScore> scores;
  double longest = 0;                           // device time [s]
  double worst_current = 0, worst_voltage = 0;  // of their limits
};

inline double find_median(std::vector<double> values) {
  if (values.empty()) return std::numeric_limits<double>::quiet_NaN();
  std::nth_element(values.begin(), values.begin() + static_cast<long>(values.size() / 2),
                   values.end());
  return values[values.size() / 2];
}

inline void score(IdentificationStudy& study, const std::map<std::string, double>& truth,
                  const Identification& found) {
  for (const auto& [name, value] : truth) {
    ParameterScore& s = study.scores[name];
    const IdentifiedParameter& p = found.find(name);
    ++s.cases;
    s.identifiable += p.identifiable;
    const double low = p.low.value_or(-INFINITY), high = p.high.value_or(INFINITY);
    s.covered += low <= value && value <= high;
    if (!p.value) continue;
    const double error = *p.value - value;
    s.errors.push_back(std::abs(error) / std::abs(value));
    s.widths.push_back((high - low) / std::abs(value));
    s.pulls.push_back(error / ((high - low) / 2));
  }
}

inline void print_case(int device, const BenchMotor& motor, const Identification& found) {
  fmt::print("{:3} {:5.1f} s", device, found.duration);
  for (const auto& [name, value] : find_truth(motor)) {
    const IdentifiedParameter& p = found.find(name);
    const double half = (p.high.value_or(INFINITY) - p.low.value_or(-INFINITY)) / 2;
    fmt::print("  {:.4s} {:+.2f}%{}/{:.2f}%", name, 100 * (*p.value / value - 1),
               std::abs(*p.value - value) > half ? "!" : "", 100 * half / value);
  }
  fmt::print("\n");
}

/// Identifies `devices` hidden motors, each by itself.
inline IdentificationStudy run_identification_study(StudyBench kind, int devices,
                                                    std::uint64_t seed, bool verbose = false) {
  IdentificationStudy study;
  for (int device = 0; device < devices; ++device) {
    const BenchMotor motor = make_hidden_motor(seed, device);
    Identification found;
    if (kind == StudyBench::own) {
      MotorBench bench(motor);
      found = identify(bench);
      study.worst_current = std::max(study.worst_current, bench.peak_current / motor.current_limit);
      study.worst_voltage = std::max(study.worst_voltage, bench.peak_voltage / motor.voltage_limit);
    } else {
      SimulatedAmplifier amplifier(make_hidden_twin(motor));
      TwinBench bench(amplifier);
      found = identify(bench);
    }
    score(study, find_truth(motor), found);
    study.longest = std::max(study.longest, found.duration);
    if (verbose) print_case(device, motor, found);
  }
  return study;
}

inline std::string describe(const IdentificationStudy& study) {
  std::string text = fmt::format("{:<18}{:>9}{:>13}{:>14}{:>16}{:>12}\n", "parameter", "covered",
                                 "identifiable", "median error", "median width", "worst pull");
  for (const auto& [name, s] : study.scores) {
    double worst = 0;
    for (const double pull : s.pulls) worst = std::max(worst, std::abs(pull));
    text += fmt::format("{:<18}{:>6}/{:<3}{:>12}{:>13.3f} %{:>14.3f} %{:>12.2f}\n", name, s.covered,
                        s.cases, s.identifiable, 100 * find_median(s.errors),
                        100 * find_median(s.widths), worst);
  }
  text += fmt::format(
      "longest {:.1f} s of device time, current to {:.2f}, voltage to {:.2f} of its limit\n",
      study.longest, study.worst_current, study.worst_voltage);
  return text;
}

}  // namespace gyrator
