#pragma once

#include <functional>
#include <vector>

#include <Eigen/Dense>

namespace gyrator {

/// How close together frequencies lie: `fine` for pictures and criteria, `coarse` where only the
/// dips between neighbours are sought.
enum class GridDensity { fine, coarse };

/// Base frequencies [rad/s] in (0, pi/T] at which a sampled loop is judged: logarithmic from far
/// below the slowest pole, linear towards Nyquist, dense around every resonance and around the
/// frequencies that resonances beyond Nyquist alias to. `poles` of the plant [rad/s].
std::vector<double> make_judging_grid(const Eigen::VectorXcd& poles, double period,
                                      GridDensity density = GridDensity::fine);

struct Minimum {
  double omega = 0;  ///< [rad/s]
  double value = 0;
};

/// Smallest value over the grid, refined between neighbours at every local minimum (Brent).
/// `values` are the function's on the grid.
Minimum find_minimum(const std::vector<double>& grid, const std::vector<double>& values,
                     const std::function<double(double)>& function);

/// Bottom of the dip that holds `omega` [rad/s], however narrow: bracketed from there by doubling
/// steps, then refined (Brent).
Minimum find_minimum_near(double omega, const std::function<double(double)>& function);

}  // namespace gyrator
