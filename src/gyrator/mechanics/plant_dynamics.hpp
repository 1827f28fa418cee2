#pragma once

#include "gyrator/mechanics/plant.hpp"

#include <Eigen/Dense>

namespace gyrator {

/// The right-hand side of a nonlinear plant (nl-1): at each ξ and u its ports' loop is solved.
/// Keeps the last solution as the next start, so that each user needs one of its own.
class PlantDynamics {
 public:
  /// `plant` must have a nonlinear part and outlive this.
  explicit PlantDynamics(const Plant& plant);

  /// U = [u; contacts; w; 1] at ξ, the contacts' efforts zero (no law feels them at once). Throws
  /// numerical, naming the element, where the loop has no solution that can be found.
  const Eigen::VectorXd& solve(const Eigen::VectorXd& xi, const Eigen::Vector2d& u);

  // After solve(), at the same ξ:
  /// y of each port.
  const Eigen::VectorXd& arguments() const { return loop_.arguments(); }
  /// dξ/dt
  const Eigen::VectorXd& rate(const Eigen::VectorXd& xi);
  /// d(dξ/dt)/dξ; also fills port_jacobian().
  const Eigen::MatrixXd& jacobian(const Eigen::VectorXd& xi);
  /// dw/dξ
  const Eigen::MatrixXd& port_jacobian() const { return dw_; }

  /// Change of each state that moves some port's argument by the size at which its law bends; laws
  /// at their slopes at rest. Infinite for a state that moves none.
  Eigen::VectorXd find_state_sizes() const;

  /// The fastest pole [rad/s] with each law at its slope at rest, each at its steepest, and all.
  double find_fastest_rate() const;

 private:
  Eigen::MatrixXd tangent(const Eigen::VectorXd& slopes) const;
  Eigen::VectorXd slopes_at_rest() const;

  const Plant& plant_;
  const NonlinearPart& nl_;
  PortLoop loop_;
  Eigen::VectorXd q_, inputs_, rate_, rises_;
  Eigen::MatrixXd jacobian_, dw_;
};

}  // namespace gyrator
