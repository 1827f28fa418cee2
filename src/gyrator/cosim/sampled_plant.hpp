#pragma once

#include "gyrator/controllers/discrete_state_space.hpp"
#include "gyrator/controllers/sampling.hpp"
#include "gyrator/mechanics/plant.hpp"

#include <Eigen/Dense>

namespace gyrator {

/// A delay in whole periods and the rest, delay = whole T + rest, 0 <= rest < T.
struct SplitDelay {
  std::int64_t whole = 0;
  double rest = 0;    ///< [s]
  double period = 0;  ///< [s]
};
SplitDelay split_delay(const Sampling& sampling);

/// Every command under way is a state of the loop: longer delays than this are refused where
/// eigenvalues are needed (bad_input).
inline constexpr std::int64_t most_sampled_delay_periods = 500;

/// The plant as the controller sees it, exact between samples:
///   ξ[k+1] = phi ξ[k] + late u[k-m-1] + recent u[k-m],   y[k] = sense ξ[k]         (smp-1)
/// where u[k-m-1] still holds for the first `rest` of period k.
struct SampledPlant {
  Eigen::MatrixXd phi;
  Eigen::VectorXd late, recent;
  Eigen::RowVectorXd sense;
  SplitDelay delay;
};
SampledPlant sample_plant(const Plant& plant, const Sampling& sampling);

/// The closed loop u = -H y as one matrix over [ξ; controller; commands under way]. Its eigenvalues
/// are the loop's exact poles: no approximation of hold, delay or sampling is left.
Eigen::MatrixXd build_loop_matrix(const SampledPlant& plant, const DiscreteStateSpace& law);

/// Largest eigenvalue magnitude; above one the loop diverges.
double compute_spectral_radius(const Eigen::MatrixXd& loop);

/// The same of a device held by `held_by`, from the start; throws as sample_plant does.
Eigen::MatrixXd build_device_loop(const Device& device, const Operator& held_by,
                                  const Sampling& sampling, const DiscreteStateSpace& law);
double compute_loop_radius(const Device& device, const Operator& held_by, const Sampling& sampling,
                           const DiscreteStateSpace& law);

struct DominantPole {
  double magnitude = 0;
  double frequency_hz = 0;
};
DominantPole find_dominant_pole(const Eigen::MatrixXd& loop, double period);

/// Eigenvalues are known to rounding only; a loop counts as stable up to 1 + this. (A free
/// device without stiffness has an eigenvalue of exactly one.)
inline constexpr double stability_tolerance = 1e-9;

}  // namespace gyrator
