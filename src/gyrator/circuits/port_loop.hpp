#pragma once

#include "gyrator/circuits/nonlinear_law.hpp"

#include <vector>

#include <Eigen/Dense>

namespace gyrator {

/// The algebraic loop of a network's nonlinear ports,
///   y = q + F w(y),   w_k = law_k(y_k) + leak_k y_k - companion_k y_k            (port-2)
/// y arguments, q what state and inputs give with w = 0, F the network's answer to w.
///
/// Newton from the last solution, a diode's steps shortened; piecewise linear laws take a few
/// steps. Where that runs in circles, the solution is followed from the last one in parts. Every
/// law rises, so in a network of passive elements the solution is unique (a drive that feeds back
/// is none).
class PortLoop {
 public:
  PortLoop() = default;
  PortLoop(std::vector<NonlinearPort> ports, Eigen::MatrixXd F);

  const std::vector<NonlinearPort>& ports() const { return ports_; }
  Eigen::Index size() const { return F_.rows(); }

  /// Temperature rise of each port [K]; only those of thermal resistors are used.
  void set_rises(const Eigen::VectorXd& rises) { rises_ = rises; }

  /// Solves the loop; returns the port that is farthest from a solution, or -1 for done.
  int solve(const Eigen::VectorXd& q);

  const Eigen::VectorXd& arguments() const { return y_; }
  const Eigen::VectorXd& inputs() const { return w_; }      ///< w(y)
  const Eigen::VectorXd& slopes() const { return slope_; }  ///< dw/dy, one per port

  /// Where the next solution is looked for first.
  void start_from(const Eigen::VectorXd& y) { y_ = y; }

 private:
  void evaluate(const Eigen::VectorXd& y);
  bool step_to(const Eigen::VectorXd& q);
  double measure(const Eigen::VectorXd& step, const Eigen::VectorXd& y) const;
  bool is_rounding(const Eigen::VectorXd& q) const;

  std::vector<NonlinearPort> ports_;
  Eigen::MatrixXd F_, jacobian_;
  Eigen::VectorXd y_, w_, slope_, rises_, residual_, step_, start_;
  Eigen::PartialPivLU<Eigen::MatrixXd> lu_;
};

}  // namespace gyrator
