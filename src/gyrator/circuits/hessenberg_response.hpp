#pragma once

#include "gyrator/circuits/state_space.hpp"

#include <complex>
#include <vector>

#include <Eigen/Dense>

namespace gyrator {

/// Fast frequency response of a state space at many frequencies,
///   G(s) = C (sI - A)^-1 B + D,                                                (resp-1)
/// for the sums over aliases that a passivity verdict needs (tens of thousands of points).
///
/// A is brought to Hessenberg form once (after diagonal balancing by powers of two); each
/// evaluation then costs O(n^2). Agrees with solve_descriptor to rounding, as a test.
class HessenbergResponse {
 public:
  explicit HessenbergResponse(const StateSpace& system);

  /// G(s), outputs by inputs, written into `response` (resized on first use). s in rad/s.
  void evaluate(std::complex<double> s, Eigen::MatrixXcd& response);

 private:
  Eigen::MatrixXd hessenberg_, input_, output_, feedthrough_;
  Eigen::MatrixXcd work_, solution_;
};

}  // namespace gyrator
