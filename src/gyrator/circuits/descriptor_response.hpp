#pragma once

#include "gyrator/circuits/descriptor.hpp"

#include <complex>
#include <memory>

#include <Eigen/Dense>

namespace gyrator {

/// Frequency response of a network's descriptor equations at many frequencies,
///   X(s) = (sE - A)^-1 B, one column per input,                               (resp-2)
/// in the units of the unknowns per unit of the input.
///
/// From sparse_from unknowns on the sparsity pattern is ordered once (COLAMD) and each frequency
/// costs one sparse factorization; below that the dense one is faster. Either way rows and columns
/// are first scaled by powers of two (Ruiz 2001), exact in floating point, so that values of all
/// magnitudes meet on equal terms. Agrees with solve_descriptor to rounding, as a test.
class DescriptorResponse {
 public:
  /// Number of unknowns where the sparse solve begins to pay (docs/netlist-size.md).
  static constexpr Eigen::Index sparse_from = 24;

  explicit DescriptorResponse(const Descriptor& descriptor, Eigen::Index sparse_at = sparse_from);
  ~DescriptorResponse();
  DescriptorResponse(DescriptorResponse&&) noexcept;
  DescriptorResponse& operator=(DescriptorResponse&&) noexcept;

  /// X(s), s in rad/s; valid until the next call. Throws numerical, naming the elements around the
  /// unknown that is left free, where the pencil is singular to rounding at s.
  const Eigen::MatrixXcd& solve(std::complex<double> s);

 private:
  class Solver;
  std::unique_ptr<Solver> solver_;
};

}  // namespace gyrator
