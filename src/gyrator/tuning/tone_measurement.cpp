#include "gyrator/tuning/tone_measurement.hpp"

#include "gyrator/core/error.hpp"
#include "gyrator/core/interrupt.hpp"
#include "gyrator/identification/sine_fit.hpp"

#include <algorithm>
#include <cmath>

#include <fmt/core.h>

namespace gyrator {
namespace {

// Periods of a sine that are kept at least, and the shortest capture [s].
constexpr double fewest_periods = 8;
constexpr double shortest_capture = 0.32;
// Friction makes odd harmonics.
constexpr SineModel model{3, 1};

}  // namespace

Tone measure_tone(Bench& bench, DriveMode mode, double amplitude, double frequency_hz) {
  throw_if_interrupted("measurement");
  const BenchLimits limits = bench.limits();
  const double tick = limits.shortest_period;
  const double settling = std::max(2 / frequency_hz, 0.05);
  const double periods = std::max(fewest_periods, std::ceil(shortest_capture * frequency_hz));
  const double length = periods / frequency_hz;
  const double decimation = std::ceil(length / (tick * limits.most_samples));
  CaptureRequest request;
  request.period = tick * decimation;
  request.start = tick * std::ceil(settling / tick);
  request.samples = std::min(limits.most_samples, static_cast<int>(length / request.period));
  Excitation sine;
  sine.kind = ExcitationKind::sine;
  sine.mode = mode;
  sine.amplitude = amplitude;
  sine.frequency_hz = frequency_hz;
  sine.duration = request.start + request.period * (request.samples + 1);
  const Capture capture = bench.run(sine, request);

  Tone tone;
  tone.frequency_hz = frequency_hz;
  tone.duration = sine.duration;
  const auto fit = [&](const std::vector<double>& signal, const char* name) -> Phasor {
    if (signal.empty())
      throw Error(ErrorCode::device, "capture",
                  fmt::format("no {}: command, current, voltage and velocity are needed", name));
    const SineFit found = fit_sine(signal, capture.start, capture.period, frequency_hz, model);
    return {found.coefficient, found.deviation};
  };
  tone.command = fit(capture.command, "command");
  tone.current = fit(capture.current, "current");
  tone.voltage = fit(capture.voltage, "voltage");
  tone.velocity = fit(capture.velocity, "velocity");
  return tone;
}

double find_highest_frequency(const BenchLimits& limits) {
  return std::min(limits.highest_frequency_hz, 0.17 / limits.shortest_period);
}

std::vector<double> spread_frequencies(const BenchLimits& limits, double lowest_hz,
                                       double highest_hz, int count) {
  const double low = std::max(lowest_hz, limits.lowest_frequency_hz);
  const double high = std::min(highest_hz, find_highest_frequency(limits));
  std::vector<double> frequencies;
  for (int i = 0; i < count; ++i)
    frequencies.push_back(low * std::pow(high / low, i / std::max(1.0, count - 1.0)));
  return frequencies;
}

}  // namespace gyrator
