#pragma once

#include <complex>
#include <vector>

#include <Eigen/Dense>

namespace gyrator {

/// Continuous state space, dx/dt = A x + B u, y = C x + D u.
struct StateSpace {
  Eigen::MatrixXd A, B, C, D;
};

/// Evens out the row and column norms of A by a diagonal similarity with powers of two (exact in
/// floating point; Osborne 1960): A becomes S^-1 A S, and the diagonal of S is returned. States in
/// units as different as amperes and radians otherwise cost eigenvalues and exponentials digits.
Eigen::VectorXd balance(Eigen::MatrixXd& A);

/// Propagation over one interval h with constant input, x(t + h) = phi x(t) + gamma u.
///   phi = e^(A h),  gamma = integral_0^h e^(A s) ds B                        (zoh-1)
struct HeldStep {
  Eigen::MatrixXd phi, gamma;
};

/// Exact discretization under a zero-order hold of `interval` seconds (matrix exponential of
/// the augmented system, so that a singular A needs no care).
HeldStep discretize_held(const Eigen::MatrixXd& A, const Eigen::MatrixXd& B, double interval);

/// Integrals of quadratic forms along a held segment,
///   W = integral_0^h z(s)' Q z(s) ds,  z = [x; u],  returned as W with z(0)' W z(0).   (zoh-2)
/// Built by Gauss quadrature on a step short against the fastest pole, then doubled,
/// W(2h) = W(h) + Z(h)' W(h) Z(h), which stays accurate for stiff A.
std::vector<Eigen::MatrixXd> integrate_quadratic_forms(const Eigen::MatrixXd& A,
                                                       const Eigen::MatrixXd& B,
                                                       const std::vector<Eigen::MatrixXd>& forms,
                                                       double interval);

/// Eigenvalues of A, balanced first: poles [rad/s] of a continuous system, or of a sampled loop.
Eigen::VectorXcd compute_poles(const Eigen::MatrixXd& A);

}  // namespace gyrator
