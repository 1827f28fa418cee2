#include "gyrator/identification/sine_fit.hpp"

#include "gyrator/core/error.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <Eigen/Dense>
#include <fmt/core.h>

namespace gyrator {
namespace {

constexpr int blocks = 10;

Eigen::MatrixXd build_columns(int samples, double start, double period, double w,
                              const SineModel& model) {
  const int drifts = model.drift_degree + 1;
  Eigen::MatrixXd columns(samples, 2 * model.harmonics + drifts);
  for (int k = 0; k < samples; ++k) {
    const double t = start + k * period;
    for (int h = 1; h <= model.harmonics; ++h) {
      columns(k, 2 * h - 2) = std::cos(h * w * t);
      columns(k, 2 * h - 1) = std::sin(h * w * t);
    }
    // Powers of a time from -1 to 1, which stay well apart.
    const double middle = 2.0 * k / (samples - 1) - 1;
    for (int d = 0; d < drifts; ++d)
      columns(k, 2 * model.harmonics + d) = d == 0 ? 1 : std::pow(middle, d);
  }
  return columns;
}

}  // namespace

SineFit fit_sine(std::span<const double> signal, double start, double period, double frequency_hz,
                 const SineModel& model) {
  const int samples = static_cast<int>(signal.size());
  const int unknowns = 2 * model.harmonics + model.drift_degree + 1;
  if (samples < 2 * unknowns)
    throw Error(
        ErrorCode::numerical, "sine fit",
        fmt::format("{} samples: {} unknowns need at least {}", samples, unknowns, 2 * unknowns));
  const double w = 2 * std::numbers::pi * frequency_hz;
  const Eigen::MatrixXd columns = build_columns(samples, start, period, w, model);
  const Eigen::Map<const Eigen::VectorXd> x(signal.data(), samples);
  const Eigen::VectorXd solution =
      (columns.transpose() * columns).ldlt().solve(columns.transpose() * x);
  const Eigen::VectorXd rest = x - columns * solution;
  SineFit fit;
  // a cos + b sin = Re((a - j b) e^{jwt})
  fit.coefficient = {solution[0], -solution[1]};
  fit.residual = std::sqrt(rest.squaredNorm() / (samples - unknowns));
  fit.peak_to_peak = x.maxCoeff() - x.minCoeff();
  double sum = 0;
  for (int b = 0; b < blocks; ++b) {
    const int first = samples * b / blocks, last = samples * (b + 1) / blocks;
    std::complex<double> share = 0;
    for (int k = first; k < last; ++k)
      share += rest[k] * std::complex<double>(columns(k, 0), -columns(k, 1));
    sum += std::norm(share) * 4 / (static_cast<double>(samples) * samples);
  }
  fit.deviation = std::sqrt(sum / 2 * blocks / (blocks - 1));
  return fit;
}

}  // namespace gyrator
