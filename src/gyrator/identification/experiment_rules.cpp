#include "gyrator/identification/experiment_rules.hpp"

#include "gyrator/core/error.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

#include <fmt/core.h>

namespace gyrator {

namespace rules = experiment_rules;

namespace {

int count_sine_samples(const BenchLimits& limits) {
  const int wanted = static_cast<int>(std::lround(rules::sine_time / limits.shortest_period));
  return std::min(std::max(wanted, rules::least_sine_samples), limits.most_samples);
}

// Whole periods in the capture, coprime to its samples.
double snap_frequency(double frequency_hz, int samples, double period) {
  int periods = std::max(1, static_cast<int>(std::lround(frequency_hz * samples * period)));
  while (std::gcd(periods, samples) > 1) ++periods;
  return periods / (samples * period);
}

bool contains(const auto& list, auto value) {
  return std::find(list.begin(), list.end(), value) != list.end();
}

void check_bench(const BenchLimits& limits) {
  const auto refuse = [](const std::string& message) {
    throw Error(ErrorCode::bad_input, "bench", message);
  };
  if (!contains(limits.modes, DriveMode::current))
    refuse("no command of current: identification needs the mode \"current\"");
  if (!contains(limits.kinds, ExcitationKind::sine))
    refuse("no sines: identification needs the excitation \"sine\"");
  if (!(limits.largest_current > 0))
    refuse(fmt::format("a current limit of {:.6g} A: must be above 0 A", limits.largest_current));
  if (limits.most_samples < rules::least_sine_samples)
    refuse(fmt::format("captures of at most {} samples: at least {} are needed",
                       limits.most_samples, rules::least_sine_samples));
}

}  // namespace

std::vector<double> choose_frequencies(const BenchLimits& limits,
                                       const IdentificationOptions& options) {
  const double period = limits.shortest_period;
  const int samples = count_sine_samples(limits);
  const double highest =
      std::min({options.highest_frequency_hz, 0.15 / period, limits.highest_frequency_hz});
  const double lowest = std::max({std::min(rules::lowest_frequency, highest / 10),
                                  limits.lowest_frequency_hz, 5 / (samples * period)});
  std::vector<double> frequencies;
  for (int i = 0; i < rules::frequency_count; ++i) {
    const double wanted = lowest * std::pow(highest / lowest, i / (rules::frequency_count - 1.0));
    frequencies.push_back(snap_frequency(wanted, samples, period));
  }
  return frequencies;
}

double find_probe_frequency(const std::vector<double>& frequencies) {
  return *std::min_element(frequencies.begin(), frequencies.end(), [](double a, double b) {
    return std::abs(a - rules::probe_frequency) < std::abs(b - rules::probe_frequency);
  });
}

SineTiming find_sine_timing(const BenchLimits& limits, double frequency_hz) {
  SineTiming timing;
  const double tick = limits.shortest_period;
  timing.capture.samples = count_sine_samples(limits);
  timing.capture.start = std::ceil(rules::settle_time / tick - 1e-9) * tick;
  const double stretch =
      std::ceil(rules::least_periods / (frequency_hz * timing.capture.samples * tick) - 1e-9);
  timing.capture.period = tick * std::max(stretch, 1.0);
  timing.duration =
      round_duration(timing.capture.start + (timing.capture.samples + 2) * timing.capture.period);
  return timing;
}

double round_duration(double seconds) {
  return std::ceil(seconds * 100 - 1e-6) / 100;
}

double round_frequency(double frequency_hz) {
  return std::round(frequency_hz * 100) / 100;
}

double find_fastest_motion(const BenchLimits& limits) {
  return std::min(rules::fastest_motion, 0.004 / limits.shortest_period);
}

double find_slowest_inertia(const BenchLimits& limits) {
  return std::min(rules::slowest_inertia, find_fastest_motion(limits));
}

std::vector<PlannedStep> plan_identification(const BenchLimits& limits,
                                             const IdentificationOptions& options) {
  check_bench(limits);
  const std::vector<double> frequencies = choose_frequencies(limits, options);
  const double largest = options.current_share * limits.largest_current;
  const double smallest = std::min(rules::first_share * limits.largest_current, largest);
  std::vector<PlannedStep> plan;
  const auto add = [&](const char* purpose, double lowest, double highest, int runs,
                       double duration) {
    const bool moving = std::string(purpose) == "inertia" || std::string(purpose) == "friction";
    plan.push_back({purpose, DriveMode::current, lowest, highest, moving ? 0 : smallest, largest,
                    runs, duration});
  };
  const int growths =
      2 + static_cast<int>(std::ceil(std::log(largest / smallest) / std::log(rules::growth)));
  const double probe = find_probe_frequency(frequencies);
  add("amplitude", probe, probe, growths, growths * find_sine_timing(limits, probe).duration);
  double duration = 0;
  for (const double frequency : frequencies)
    duration += 2 * find_sine_timing(limits, frequency).duration;
  add("winding and amplifier", frequencies.front(), frequencies.back(),
      2 * static_cast<int>(frequencies.size()), duration);
  int runs = growths;
  duration = growths * find_sine_timing(limits, frequencies.front()).duration;
  double slowest = frequencies.front();
  while (slowest / 2 >= std::max(rules::slowest_frequency, limits.lowest_frequency_hz)) {
    slowest /= 2;
    duration += find_sine_timing(limits, slowest).duration;
    ++runs;
  }
  add("motion", slowest, frequencies.front(), runs, duration);
  runs = 2 * rules::inertia_rounds;
  add("inertia", find_slowest_inertia(limits), find_fastest_motion(limits), runs,
      runs *
          (round_duration(rules::inertia_periods / find_slowest_inertia(limits)) + rules::pause));
  runs = 2 * rules::friction_repeats;
  add("friction", options.slow_frequency_hz, options.slow_frequency_hz, runs,
      runs * (round_duration(rules::friction_periods / options.slow_frequency_hz) + rules::pause));
  return plan;
}

}  // namespace gyrator
