#include "gyrator/identification/amplifier_fit.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <complex>
#include <limits>
#include <numbers>
#include <set>
#include <vector>

#include <Eigen/Dense>

namespace gyrator {
namespace {

constexpr double least_time_constant = 2e-6, most_time_constant = 0.1;
constexpr int most_ticks = 15;  // of delay that is looked for
constexpr int rounds = 30;

struct Ratio {
  double frequency_hz, deviation;
  std::complex<double> value;  // current per command
  int group;
};

std::vector<Ratio> find_ratios(std::span<const SineMeasurement> sines) {
  std::vector<Ratio> ratios;
  for (const SineMeasurement& sine : sines) {
    if (!sine.command || !(std::abs(sine.command->value) > 0)) continue;
    const double size = std::abs(sine.command->value);
    const std::complex<double> value = sine.current.value / sine.command->value;
    const double deviation =
        std::hypot(sine.current.deviation, sine.command->deviation * std::abs(value)) / size;
    ratios.push_back({sine.frequency_hz, std::max(deviation, 1e-9), value, sine.group});
  }
  return ratios;
}

// Gain, time constant and delay, with the weighted squares that they leave.
struct Solution {
  Eigen::Vector3d p = Eigen::Vector3d::Zero();
  double left = std::numeric_limits<double>::infinity();
};

struct Sensitivity {
  std::complex<double> response;
  std::array<std::complex<double>, 3> slopes;
};

// (lag-2) with its derivatives, `whole` ticks of the delay held fast.
Sensitivity differentiate(const Eigen::Vector3d& p, int whole, double T, double frequency_hz) {
  const double w = 2 * std::numbers::pi * frequency_hz, tau = p[1], rest = p[2] - whole * T;
  const double decay = std::exp(-T / tau), late = std::exp(-(T - rest) / tau);
  const double decay_slope = decay * T / (tau * tau), late_slope = late * (T - rest) / (tau * tau);
  const std::complex<double> z = std::polar(1.0, w * T), shift = std::polar(1.0, -w * T * whole);
  const std::complex<double> y = ((late - decay) / z + (1 - late)) * shift / (z - decay);
  const std::complex<double> top = ((late_slope - decay_slope) / z - late_slope) * shift;
  return {p[0] * y,
          {y, p[0] * (top + y * decay_slope) / (z - decay),
           p[0] * late / tau * (1.0 / z - 1.0) * shift / (z - decay)}};
}

double find_left(std::span<const Ratio> ratios, const Eigen::Vector3d& p, int whole, double T) {
  double left = 0;
  for (const Ratio& ratio : ratios)
    left += std::norm((ratio.value - differentiate(p, whole, T, ratio.frequency_hz).response) /
                      ratio.deviation);
  return left;
}

struct Normal {
  Eigen::Matrix3d matrix = Eigen::Matrix3d::Zero();
  Eigen::Vector3d right = Eigen::Vector3d::Zero();
};

Normal build_normal(std::span<const Ratio> ratios, const Eigen::Vector3d& p, int whole, double T) {
  Normal normal;
  for (const Ratio& ratio : ratios) {
    const Sensitivity at = differentiate(p, whole, T, ratio.frequency_hz);
    const std::complex<double> rest = ratio.value - at.response;
    const double weight = 1 / (ratio.deviation * ratio.deviation);
    for (int i = 0; i < 3; ++i) {
      normal.right[i] += weight * (std::conj(at.slopes[i]) * rest).real();
      for (int j = 0; j < 3; ++j)
        normal.matrix(i, j) += weight * (std::conj(at.slopes[i]) * at.slopes[j]).real();
    }
  }
  return normal;
}

// To a diagonal of one; what nothing depends on keeps a zero.
Eigen::Vector3d find_scale(const Eigen::Matrix3d& matrix) {
  return matrix.diagonal().cwiseMax(1e-300).cwiseSqrt().cwiseInverse();
}

Solution refine(std::span<const Ratio> ratios, Eigen::Vector3d p, int whole, double T) {
  Solution best{p, find_left(ratios, p, whole, T)};
  double damping = 1e-3;
  for (int round = 0; round < rounds && damping < 1e9; ++round) {
    const Normal normal = build_normal(ratios, best.p, whole, T);
    const Eigen::Vector3d scale = find_scale(normal.matrix);
    Eigen::Matrix3d even = scale.asDiagonal() * normal.matrix * scale.asDiagonal();
    even.diagonal().array() += damping;
    Eigen::Vector3d next =
        best.p +
        Eigen::Vector3d(scale.asDiagonal() * even.ldlt().solve(scale.asDiagonal() * normal.right));
    next[1] = std::clamp(next[1], least_time_constant, most_time_constant);
    next[2] = std::clamp(next[2], whole * T, (whole + 1) * T);
    const double left = find_left(ratios, next, whole, T);
    if (left < best.left) {
      const bool settled = left > (1 - 1e-9) * best.left;
      best = {next, left};
      if (settled) break;
      damping /= 10;
    } else {
      damping *= 10;
    }
  }
  return best;
}

// Of the noise that the sines have, or of what is left if that is more: where the sines hardly
// depend on a value, leaving one out does not show it.
Eigen::Vector3d find_curvature_variance(std::span<const Ratio> ratios, const Solution& solution,
                                        int whole, double T) {
  constexpr double flattest = 1e-12;  // of the scaled matrix's eigenvalues
  const Eigen::Matrix3d matrix = build_normal(ratios, solution.p, whole, T).matrix;
  const Eigen::Vector3d scale = find_scale(matrix);
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(
      Eigen::Matrix3d(scale.asDiagonal() * matrix * scale.asDiagonal()));
  const Eigen::Vector3d inverse = solver.eigenvalues().cwiseMax(flattest).cwiseInverse();
  const Eigen::Matrix3d even =
      solver.eigenvectors() * inverse.asDiagonal() * solver.eigenvectors().transpose();
  const double per_equation =
      solution.left / std::max(1.0, 2.0 * static_cast<double>(ratios.size()) - 3);
  return std::max(1.0, per_equation) * even.diagonal().cwiseProduct(scale.cwiseAbs2());
}

// From the best time constant of a grid, with the delay in the middle of its tick.
Solution search(std::span<const Ratio> ratios, int whole, double T) {
  Solution best;
  for (double tau = least_time_constant; tau < most_time_constant; tau *= 1.3) {
    const Eigen::Vector3d p(1, tau, (whole + 0.5) * T);
    const double left = find_left(ratios, p, whole, T);
    if (left < best.left) best = {p, left};
  }
  return refine(ratios, best.p, whole, T);
}

}  // namespace

std::optional<AmplifierFit> fit_amplifier(std::span<const SineMeasurement> sines, double tick) {
  const std::vector<Ratio> ratios = find_ratios(sines);
  std::set<int> groups;
  for (const Ratio& ratio : ratios) groups.insert(ratio.group);
  if (groups.size() < 3) return std::nullopt;
  Solution best;
  int whole = 0;
  for (int ticks = 0; ticks < most_ticks; ++ticks) {
    const Solution solution = search(ratios, ticks, tick);
    if (solution.left < best.left) {
      best = solution;
      whole = ticks;
    }
  }
  std::vector<Eigen::VectorXd> without;
  for (const int group : groups) {
    std::vector<Ratio> rest;
    for (const Ratio& ratio : ratios)
      if (ratio.group != group) rest.push_back(ratio);
    Solution nearby;
    for (int ticks = std::max(0, whole - 1); ticks <= whole + 1; ++ticks) {
      Eigen::Vector3d from = best.p;
      from[2] = std::clamp(from[2], ticks * tick, (ticks + 1) * tick);
      const Solution solution = refine(rest, from, ticks, tick);
      if (solution.left < nearby.left) nearby = solution;
    }
    without.emplace_back(nearby.p);
  }
  AmplifierFit found{build_jackknife(best.p, without)};
  const Eigen::Vector3d variance = find_curvature_variance(ratios, best, whole, tick);
  for (int i = 0; i < 3; ++i)
    found.fit.covariance(i, i) = std::max(found.fit.covariance(i, i), variance[i]);
  return found;
}

std::optional<AmplifierFit> fit_apparent_amplifier(std::span<const SineMeasurement> sines,
                                                   double tick) {
  std::vector<SineMeasurement> asked(sines.begin(), sines.end());
  for (SineMeasurement& sine : asked) sine.command = Phasor{sine.played, 0};
  return fit_amplifier(asked, tick);
}

}  // namespace gyrator
