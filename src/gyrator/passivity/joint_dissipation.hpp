#pragma once

#include <optional>

#include <Eigen/Dense>

namespace gyrator {

/// What the damping of the joints is worth at the hand, at one pose.
struct PoseDissipation {
  /// Largest equal damping in every task direction that the joints give; infinite where no joint
  /// moves the hand.
  double largest_isotropic = 0;
  Eigen::VectorXd weakest_direction;  ///< task velocity, length 1, in which they give the least
  // Only with a task damping to be rendered:
  std::optional<double> least_eigenvalue;  ///< of delta_m - J^T delta J
  std::optional<double> allowed_factor;    ///< of delta: at 1 and above the joints suffice
};

/// The condition of nonlinear kinematics at one pose,
///   delta_m - J^T delta J positive semidefinite                                          [8.31]
/// delta_m damping of the joints (positive definite), J Jacobian from joint to task velocities
/// (task x joints), delta damping that the environment needs at the hand (positive semidefinite):
/// v_q^T delta_m v_q is then at least v_x^T delta v_x for v_x = J v_q. The largest factor of delta
/// that still holds is one over the largest eigenvalue of J^T delta J q = lambda delta_m q; so is
/// the largest isotropic delta, with J^T J. Independent of the units of the joints, which the least
/// eigenvalue is not.
/// Source: Miller, Colgate and Freeman 2004 by way of Weir and Colgate [8.31]. Sizes are asserted.
PoseDissipation compute_pose_dissipation(const Eigen::MatrixXd& joint_damping,
                                         const Eigen::MatrixXd& jacobian,
                                         const std::optional<Eigen::MatrixXd>& task_damping);

}  // namespace gyrator
