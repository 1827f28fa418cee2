#include "gyrator/passivity/frequency_grid.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <boost/math/tools/minima.hpp>

namespace gyrator {
namespace {

// Below the slowest pole every term of the criteria has reached its limit for zero frequency up
// to the square of this.
constexpr double below_slowest = 1e-4;
struct Density {
  int per_decade;
  int per_flat_decade;  // a tenth of the slowest pole and below
  int to_nyquist;
};
constexpr Density fine{30, 8, 64};
constexpr Density coarse{10, 2, 20};

double fold(double omega, double period) {
  const double sampling = 2 * std::numbers::pi / period;
  return std::abs(std::remainder(omega, sampling));
}

}  // namespace

std::vector<double> make_judging_grid(const Eigen::VectorXcd& poles, double period,
                                      GridDensity density) {
  const Density& points = density == GridDensity::fine ? fine : coarse;
  const double nyquist = std::numbers::pi / period;
  const double fastest = poles.size() > 0 ? poles.cwiseAbs().maxCoeff() : 0;
  double slowest = nyquist;
  for (const auto& pole : poles) {
    if (std::abs(pole) > 1e-12 * fastest) slowest = std::min(slowest, std::abs(pole));
  }
  std::vector<double> grid;
  const double low = below_slowest * slowest;
  const auto add_decades = [&](double from, double to, int per_decade) {
    const double decades = std::log10(to / from);
    const int count = static_cast<int>(std::ceil(decades * per_decade));
    for (int i = 0; i <= count; ++i) grid.push_back(from * std::pow(10.0, decades * i / count));
  };
  add_decades(low, slowest / 10, points.per_flat_decade);
  add_decades(slowest / 10, nyquist, points.per_decade);
  for (int i = 1; i <= points.to_nyquist; ++i) grid.push_back(nyquist * i / points.to_nyquist);
  for (const auto& pole : poles) {
    const double width = std::max(std::abs(pole.real()), 1e-9 * std::abs(pole));
    if (std::abs(pole.imag()) < 0.5 * std::abs(pole)) continue;
    for (int i = -8; i <= 8; ++i)
      grid.push_back(fold(std::abs(pole.imag()) + i * width / 2, period));
  }
  std::erase_if(grid, [&](double omega) { return !(omega >= low && omega <= nyquist); });
  std::sort(grid.begin(), grid.end());
  // Points closer than rounding would only cost time.
  grid.erase(
      std::unique(grid.begin(), grid.end(), [](double a, double b) { return b - a < 1e-12 * b; }),
      grid.end());
  return grid;
}

Minimum find_minimum(const std::vector<double>& grid, const std::vector<double>& values,
                     const std::function<double(double)>& function) {
  const auto lowest = std::min_element(values.begin(), values.end());
  Minimum best{grid[static_cast<std::size_t>(lowest - values.begin())], *lowest};
  if (!std::isfinite(best.value)) return best;
  for (std::size_t i = 1; i + 1 < grid.size(); ++i) {
    if (!(values[i] <= values[i - 1] && values[i] <= values[i + 1])) continue;
    // Only dips that could undercut the best found: a smooth dip between neighbours cannot be
    // deeper than its own drop over the bracket.
    const double drop = std::max(values[i - 1], values[i + 1]) - values[i];
    if (values[i] - drop > best.value) continue;
    std::uintmax_t iterations = 60;
    const auto [omega, value] = boost::math::tools::brent_find_minima(
        function, grid[i - 1], grid[i + 1], std::numeric_limits<double>::digits / 2, iterations);
    if (value < best.value) best = {omega, value};
  }
  return best;
}

Minimum find_minimum_near(double omega, const std::function<double(double)>& function) {
  constexpr double first_step = 1e-9;  // of the frequency
  Minimum best{omega, function(omega)};
  const auto walk = [&](double direction) {
    double end = omega;
    for (double step = first_step; step < 0.5; step *= 2) {
      end = omega * (1 + direction * step);
      const double value = function(end);
      if (!(value < best.value)) break;
      best = {end, value};
    }
    return end;
  };
  const double high = walk(1);
  const double low = walk(-1);
  std::uintmax_t iterations = 60;
  const auto [at, value] = boost::math::tools::brent_find_minima(
      function, low, high, std::numeric_limits<double>::digits / 2, iterations);
  if (value < best.value) best = {at, value};
  return best;
}

}  // namespace gyrator
