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

/// Aliases on either side that reach to twice the fastest resonance, so that what is left changes
/// little over a sampling frequency w_s [rad/s]; at least 1, at most a million. Real poles, and
/// resonances as wide as a few w_s (an operational amplifier's), are smooth anyway.
int count_resonant_aliases(const Eigen::VectorXcd& poles, double sampling_frequency);

}  // namespace gyrator
