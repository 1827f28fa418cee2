#include "gyrator/tuning/tone_measurement.hpp"

#include "gyrator/core/error.hpp"
#include "gyrator/core/interrupt.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <Eigen/Dense>
#include <fmt/core.h>

namespace gyrator {
namespace {

using std::numbers::pi;

constexpr int parts = 8;

// What a capture of a sine consists of: the sine, its second and third harmonics (friction), a mean
// and a drift.
constexpr int columns = 8;

Phasor fit_phasor(const std::vector<double>& signal, double omega, double start, double period) {
  const auto part_length = static_cast<Eigen::Index>(signal.size()) / parts;
  std::array<std::complex<double>, parts> found;
  std::complex<double> mean = 0;
  for (int part = 0; part < parts; ++part) {
    Eigen::MatrixXd basis(part_length, columns);
    Eigen::VectorXd values(part_length);
    for (Eigen::Index k = 0; k < part_length; ++k) {
      const Eigen::Index sample = part * part_length + k;
      const double t = start + static_cast<double>(sample) * period;
      for (int harmonic = 1; harmonic <= 3; ++harmonic) {
        basis(k, 2 * harmonic - 2) = std::cos(harmonic * omega * t);
        basis(k, 2 * harmonic - 1) = std::sin(harmonic * omega * t);
      }
      basis(k, 6) = 1;
      basis(k, 7) = static_cast<double>(k) / static_cast<double>(part_length) - 0.5;
      values(k) = signal[static_cast<std::size_t>(sample)];
    }
    // Near half the capture's rate a harmonic is an alias of another: least norm then.
    const Eigen::VectorXd x = basis.completeOrthogonalDecomposition().solve(values);
    found[static_cast<std::size_t>(part)] = {x(0), -x(1)};
    mean += found[static_cast<std::size_t>(part)] / static_cast<double>(parts);
  }
  double squares = 0;
  for (const auto& value : found) squares += std::norm(value - mean);
  // Of either part, of the mean of so many.
  return {mean, std::sqrt(squares / 2 / (parts * (parts - 1)))};
}

}  // namespace

Tone measure_tone(Bench& bench, DriveMode mode, double amplitude, double frequency_hz) {
  throw_if_interrupted("measurement");
  const BenchLimits limits = bench.limits();
  const double tick = limits.shortest_period;
  // Whole periods in each part, and a settling time of at least two periods.
  const double settling = std::max(2 / frequency_hz, 0.05);
  const double periods = std::max(1.0, std::ceil(0.04 * frequency_hz));
  const double length = parts * periods / frequency_hz;
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
  const double omega = 2 * pi * frequency_hz;
  const auto fit = [&](const std::vector<double>& signal, const char* name) {
    if (signal.size() < parts * columns)
      throw Error(ErrorCode::device, "capture",
                  fmt::format("{} has {} samples: {} at least, of command, current, voltage and "
                              "velocity",
                              name, signal.size(), parts * columns));
    return fit_phasor(signal, omega, capture.start, capture.period);
  };
  tone.command = fit(capture.command, "command");
  tone.current = fit(capture.current, "current");
  tone.voltage = fit(capture.voltage, "voltage");
  tone.velocity = fit(capture.velocity, "velocity");
  return tone;
}

std::vector<Tone> measure_tones(Bench& bench, DriveMode mode, const AmplitudeAt& amplitude_at,
                                const std::vector<double>& frequency_hz) {
  std::vector<Tone> tones;
  for (const double f : frequency_hz)
    tones.push_back(measure_tone(bench, mode, amplitude_at(f), f));
  return tones;
}

std::vector<double> choose_frequencies(const BenchLimits& limits, double lowest_hz,
                                       double highest_hz, int count) {
  const double low = std::max(lowest_hz, limits.lowest_frequency_hz);
  const double high =
      std::min({highest_hz, limits.highest_frequency_hz, 0.17 / limits.shortest_period});
  std::vector<double> frequencies;
  for (int i = 0; i < count; ++i)
    frequencies.push_back(low * std::pow(high / low, i / std::max(1.0, count - 1.0)));
  return frequencies;
}

}  // namespace gyrator
