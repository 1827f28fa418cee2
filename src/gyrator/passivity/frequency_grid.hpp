#pragma once

#include <functional>
#include <vector>

#include <Eigen/Dense>

namespace gyrator {

/// Base frequencies [rad/s] in (0, pi/T] at which a sampled loop is judged: logarithmic from far
/// below the slowest pole, linear towards Nyquist, dense around every resonance and around the
/// frequencies that resonances beyond Nyquist alias to. `poles` of the plant [rad/s].
std::vector<double> make_judging_grid(const Eigen::VectorXcd& poles, double period);

struct Minimum {
  double omega = 0;  ///< [rad/s]
  double value = 0;
};

/// Smallest value over the grid, refined between neighbours at every local minimum (Brent).
/// `values` are the function's on the grid.
Minimum find_minimum(const std::vector<double>& grid, const std::vector<double>& values,
                     const std::function<double(double)>& function);

}  // namespace gyrator
