#pragma once

#include "gyrator/identification/estimate.hpp"

#include <span>
#include <vector>

#include <Eigen/Dense>

namespace gyrator {

/// One equation of a linear least-squares problem, y = sum of x_j p_j + error.
struct Equation {
  Eigen::VectorXd x;
  double y = 0;
  double deviation = 1;  ///< of the error, as far as it is known: 1/weight
  int family = 0;        ///< equations whose deviations are known up to one common factor
  int group = 0;         ///< equations whose errors may have to do with each other
};

/// What is added to the jackknife's deviations, for errors that all groups have in common and that
/// leaving one out cannot show.
inline constexpr double jackknife_allowance = 1.2;

struct GroupedFit {
  Eigen::VectorXd values;
  Eigen::MatrixXd covariance;
  std::vector<double> degrees;  ///< of freedom, of each value's variance
  std::vector<double> scale;    ///< of each family: residual per stated deviation, rms
  int groups = 0;

  Estimate at(int unknown) const;
};

/// Weighted least squares, with the covariance of the delete-one-group jackknife,
///   C = a^2 (G - 1)/(G - n_p) sum over groups g of (p_g - mean p)(p_g - mean p)^T (jackknife-1)
/// p_g the n_p values without group g, a the allowance. It needs no law of the errors within a
/// group and counts them as what they do to the values. The families' deviations are scaled to
/// their residuals first. A value that hangs on few groups has few degrees of freedom: with u_g its
/// squared deviations,
///   n = 3 (sum u)^2/sum u^2 - 1, between 1 and G - 1                                (jackknife-2)
/// (which is G - 1 for many normal ones). Throws numerical for fewer than three groups or fewer
/// equations than unknowns. Source: Efron 1982, chapter 3.
GroupedFit fit_grouped(std::span<const Equation> equations);

/// The jackknife of any estimator: `values` holds what it finds without each of the groups.
GroupedFit build_jackknife(const Eigen::VectorXd& all, const std::vector<Eigen::VectorXd>& without);

}  // namespace gyrator
