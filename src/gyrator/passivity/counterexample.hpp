#pragma once

#include "gyrator/controllers/discrete_state_space.hpp"
#include "gyrator/passivity/aliased_disk.hpp"

#include <optional>
#include <vector>

namespace gyrator {

/// A lossless operator with which the exact loop diverges: proof that it is not passive.
struct Counterexample {
  MassSpringDamper held_by;    ///< inertia and spring; resonators only where these two do not do
  double spectral_radius = 0;  ///< of the exact loop, above 1
  double frequency_hz = 0;     ///< of the growing oscillation
};

/// Searches a lossless operator for the law at the frequencies where the disk is exceeded.
///
/// At such a frequency w the point -1/H lies inside the disk; the alias n contributes its utmost in
/// that direction, angle phi, with the reactance X_n for which
///   1/(Z_n + jX_n) = (1 + e^(j theta_n))/(2 Re Z_n),   k_n S_n A_n e^(j theta_n) towards phi
///   (ce-1)
/// An inertia M and spring k present M w - k/w: they meet X_0 and X_-1 exactly where the solution
/// is not negative, X_0 alone otherwise, along a family. The candidates are ranked by the spectral
/// radius of the exact loop and the best ones improved; resonators are added only if that fails.
/// A disk that is exceeded at low frequency alone takes a large inertia, M w^2 ~ K, and the loop
/// grows slowly, by about |D| w^2 T/(4 K) per sample: counted where it is more than rounding can
/// have made of one (rounding-1).
/// None if nothing was found (near Nyquist X_0 and X_-1 are wanted at almost conjugate
/// frequencies).
std::optional<Counterexample> find_counterexample(const Device& device, const Sampling& sampling,
                                                  const DiscreteStateSpace& law, AliasedDisk& disk,
                                                  const std::vector<double>& failing_omega);

/// Spectral radius and frequency of the exact loop with this operator.
Counterexample judge_operator(const Device& device, const Sampling& sampling,
                              const DiscreteStateSpace& law, const MassSpringDamper& held_by);

}  // namespace gyrator
