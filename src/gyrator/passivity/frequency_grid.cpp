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
constexpr int points_per_decade = 30;
constexpr int points_per_flat_decade = 8;  // a tenth of the slowest pole and below
constexpr int points_to_nyquist = 64;

double fold(double omega, double period) {
  const double sampling = 2 * std::numbers::pi / period;
  return std::abs(std::remainder(omega, sampling));
}

}  // namespace

std::vector<double> make_judging_grid(const Eigen::VectorXcd& poles, double period) {
  const double nyquist = std::numbers::pi / period;
  const double fastest = poles.size() > 0 ? poles.cwiseAbs().maxCoeff() : 0;
  double slowest = nyquist;
  for (const auto& pole : poles) {
    if (std::abs(pole) > 1e-12 * fastest) slowest = std::min(slowest, std::abs(pole));
  }
  std::vector<double> grid;
  const double low = below_slowest * slowest;
  const auto add_decades = [&](double from, double to, int density) {
    const double decades = std::log10(to / from);
    const int points = static_cast<int>(std::ceil(decades * density));
    for (int i = 0; i <= points; ++i) grid.push_back(from * std::pow(10.0, decades * i / points));
  };
  add_decades(low, slowest / 10, points_per_flat_decade);
  add_decades(slowest / 10, nyquist, points_per_decade);
  for (int i = 1; i <= points_to_nyquist; ++i) grid.push_back(nyquist * i / points_to_nyquist);
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

}  // namespace gyrator
