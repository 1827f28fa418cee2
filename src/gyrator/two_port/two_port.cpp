#include "gyrator/two_port/two_port.hpp"

#include "gyrator/passivity/frequency_grid.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace gyrator {
namespace {

using Complex = std::complex<double>;

constexpr double rounding = 1e-7;  // of the larger side of a condition
constexpr double lowest_angle = 1e-5;
constexpr double band_accuracy = 1e-6;

double to_hertz(double omega) {
  return omega / (2 * std::numbers::pi);
}

// The three conditions as numbers that are negative where they are violated beyond rounding.
std::array<double, 3> slack(const HybridMatrix& h) {
  const LlewellynMargins m = compute_llewellyn_margins(h);
  return {m.first + rounding * std::abs(h.h11), m.second + rounding * std::abs(h.h22),
          m.ratio - (1 - rounding)};
}

std::vector<FrequencyBand> find_violations(const std::function<double(double)>& slack,
                                           const std::vector<double>& grid) {
  // Where the sign changes between a point where it holds and one where it does not.
  const auto edge = [&](double holds, double fails) {
    while (std::abs(fails - holds) > band_accuracy * fails) {
      const double middle = (holds + fails) / 2;
      (slack(middle) < 0 ? fails : holds) = middle;
    }
    return to_hertz(fails);
  };
  std::vector<FrequencyBand> bands;
  bool inside = false;
  for (std::size_t i = 0; i < grid.size(); ++i) {
    const bool fails = slack(grid[i]) < 0;
    if (fails && !inside) {
      const double from = i > 0 ? edge(grid[i - 1], grid[i]) : 0;
      bands.push_back({from, from});
    }
    if (fails) bands.back().to_hz = to_hertz(grid[i]);
    if (!fails && inside) bands.back().to_hz = edge(grid[i], grid[i - 1]);
    inside = fails;
  }
  return bands;
}

}  // namespace

Complex HybridMatrix::transmitted(Complex environment) const {
  return h11 - h12 * h21 * environment / (1.0 + h22 * environment);
}

Complex HybridMatrix::transmitted_when_clamped() const {
  return h11 - h12 * h21 / h22;
}

HybridMatrix ImpedanceMatrix::to_hybrid() const {
  return {z11 - z12 * z21 / z22, -z12 / z22, z21 / z22, 1.0 / z22};
}

LlewellynMargins compute_llewellyn_margins(const HybridMatrix& h) {
  const Complex p = h.h12 * h.h21;
  const double size = std::abs(p);
  double asked = size + p.real();
  if (p.real() < 0) asked = p.imag() * p.imag() / (size - p.real());
  const double given = 2 * h.h11.real() * h.h22.real();
  LlewellynMargins m{h.h11.real(), h.h22.real(), given - asked, given / asked,
                     h.h11.real() - asked / (2 * h.h22.real())};
  if (asked == 0) m.felt = m.first;
  if (h.h22.real() < 0) m.felt = -std::numeric_limits<double>::infinity();
  if (asked == 0) {
    m.ratio = given >= 0 ? std::numeric_limits<double>::infinity()
                         : -std::numeric_limits<double>::infinity();
  }
  return m;
}

TwoPortVerdict judge_two_port(const std::function<HybridMatrix(double)>& port,
                              const std::vector<double>& grid, double computed_spectral_radius) {
  using Margin = double LlewellynMargins::*;
  const auto lowest = [&](Margin margin) {
    const auto value = [&](double omega) { return compute_llewellyn_margins(port(omega)).*margin; };
    std::vector<double> values;
    values.reserve(grid.size());
    for (const double omega : grid) values.push_back(value(omega));
    return find_minimum(grid, values, value);
  };
  constexpr std::array<Margin, 3> margins{&LlewellynMargins::first, &LlewellynMargins::second,
                                          &LlewellynMargins::third};
  TwoPortVerdict verdict;
  const Minimum felt = lowest(&LlewellynMargins::felt);
  verdict.felt = felt.value;
  verdict.felt_frequency_hz = felt.omega > grid.front() ? to_hertz(felt.omega) : 0;
  for (std::size_t i = 0; i < margins.size(); ++i) {
    const Minimum least = lowest(margins[i]);
    // Whether it holds is asked on the grid and at the lowest point found between.
    std::vector<double> points = grid;
    points.insert(std::upper_bound(points.begin(), points.end(), least.omega), least.omega);
    if (i == 2) {
      const Minimum ratio = lowest(&LlewellynMargins::ratio);
      verdict.ratio = ratio.value;
      verdict.ratio_frequency_hz = ratio.omega > grid.front() ? to_hertz(ratio.omega) : 0;
      points.insert(std::upper_bound(points.begin(), points.end(), ratio.omega), ratio.omega);
    }
    ConditionResult& condition = verdict.conditions[i];
    condition.margin = least.value;
    condition.worst_frequency_hz = least.omega > grid.front() ? to_hertz(least.omega) : 0;
    condition.violated =
        find_violations([&](double omega) { return slack(port(omega))[i]; }, points);
    condition.holds = condition.violated.empty();
  }
  verdict.computed_spectral_radius = computed_spectral_radius;
  verdict.absolutely_stable =
      computed_spectral_radius <= 1 + rounding &&
      std::all_of(verdict.conditions.begin(), verdict.conditions.end(),
                  [](const ConditionResult& condition) { return condition.holds; });
  return verdict;
}

std::vector<double> make_two_port_grid(const Eigen::VectorXcd& poles, double period) {
  std::vector<double> grid = make_judging_grid(poles, period);
  std::erase_if(grid, [&](double omega) { return omega * period < lowest_angle; });
  return grid;
}

}  // namespace gyrator
