#include "gyrator/passivity/pole_rounding.hpp"

#include "gyrator/circuits/state_space.hpp"

#include <algorithm>
#include <limits>

namespace gyrator {

using Eigen::MatrixXcd;
using Eigen::VectorXcd;

double bound_pole_rounding(const Eigen::MatrixXd& loop, std::complex<double> pole) {
  constexpr double safety = 3;
  constexpr double epsilon = std::numeric_limits<double>::epsilon();
  Eigen::MatrixXd balanced = loop;
  balance(balanced);
  const double size = std::max(1.0, balanced.norm());
  // Inverse iteration from a start that is orthogonal to no eigenvector but by accident.
  MatrixXcd shifted = balanced.cast<std::complex<double>>();
  shifted.diagonal().array() -= pole + epsilon * size;
  const Eigen::PartialPivLU<MatrixXcd> right(shifted);
  const Eigen::PartialPivLU<MatrixXcd> left(shifted.adjoint());
  VectorXcd x(loop.rows());
  for (Eigen::Index i = 0; i < x.size(); ++i) x(i) = std::polar(1.0, static_cast<double>(i));
  VectorXcd y = x;
  for (int turn = 0; turn < 3; ++turn) {
    x = right.solve(x).normalized();
    y = left.solve(y).normalized();
  }
  const double overlap = std::abs(y.dot(x));
  if (!(overlap > 0)) return std::numeric_limits<double>::infinity();
  return safety * static_cast<double>(loop.rows()) * epsilon * size / overlap;
}

}  // namespace gyrator
