#pragma once

#include <complex>
#include <vector>

#include <Eigen/Dense>

namespace gyrator {

/// A point of the integral of g(w)/w^2 dw: sum of weight g(omega).
struct TailNode {
  double omega = 0;   ///< [rad/s]
  double weight = 0;  ///< [s]
};

/// Gauss nodes for smooth g from `from` to `to` [rad/s]: panels even in ln w, and close ones about
/// every resonance among the poles [rad/s].
std::vector<TailNode> make_tail_nodes(double from, double to, const Eigen::VectorXcd& poles);

/// Where the tails of alias sums end and a power law takes over [rad/s].
double find_tail_end(double from, const Eigen::VectorXcd& poles);

/// Whether a pole rings at all: its response has a peak.
bool is_resonance(std::complex<double> pole);

}  // namespace gyrator
