#include "gyrator/circuits/state_space.hpp"

#include <cmath>
#include <unsupported/Eigen/MatrixFunctions>

#include <Eigen/Eigenvalues>
#include <boost/math/quadrature/gauss.hpp>

namespace gyrator {
namespace {

// d/dt [x; u] = [A B; 0 0] [x; u] while u is held.
Eigen::MatrixXd augment_held(const Eigen::MatrixXd& A, const Eigen::MatrixXd& B) {
  const Eigen::Index n = A.rows();
  const Eigen::Index m = B.cols();
  Eigen::MatrixXd held = Eigen::MatrixXd::Zero(n + m, n + m);
  held.topLeftCorner(n, n) = A;
  held.topRightCorner(n, m) = B;
  return held;
}

// e^(matrix), balanced first; a held input's column (whose row is zero) is brought to the size of
// the rest, so that no norm is governed by units.
Eigen::MatrixXd exponential(const Eigen::MatrixXd& matrix) {
  if (matrix.isZero(0)) return Eigen::MatrixXd::Identity(matrix.rows(), matrix.cols());
  Eigen::MatrixXd balanced = matrix;
  Eigen::VectorXd scale = balance(balanced);
  const double size = balanced.cwiseAbs().colwise().sum().mean();
  for (Eigen::Index j = 0; j < balanced.cols(); ++j) {
    const double column = balanced.col(j).cwiseAbs().sum();
    if (!balanced.row(j).isZero(0) || column == 0) continue;
    const double factor = std::exp2(std::round(std::log2(size / column)));
    balanced.col(j) *= factor;
    scale(j) *= factor;
  }
  const Eigen::MatrixXd result = balanced.exp();
  return scale.asDiagonal() * result * scale.cwiseInverse().asDiagonal();
}

}  // namespace

Eigen::VectorXd balance(Eigen::MatrixXd& A) {
  const Eigen::Index n = A.rows();
  Eigen::VectorXd scale = Eigen::VectorXd::Ones(n);
  for (int sweep = 0; sweep < 20; ++sweep) {
    bool changed = false;
    for (Eigen::Index i = 0; i < n; ++i) {
      const double row = A.row(i).cwiseAbs().sum() - std::abs(A(i, i));
      const double column = A.col(i).cwiseAbs().sum() - std::abs(A(i, i));
      if (row == 0 || column == 0 || !std::isfinite(row + column)) continue;
      const double factor = std::exp2(std::round(0.5 * std::log2(row / column)));
      if (factor == 1) continue;
      A.row(i) /= factor;
      A.col(i) *= factor;
      scale(i) *= factor;
      changed = true;
    }
    if (!changed) break;
  }
  return scale;
}

HeldStep discretize_held(const Eigen::MatrixXd& A, const Eigen::MatrixXd& B, double interval) {
  const Eigen::Index n = A.rows();
  const Eigen::MatrixXd step = exponential(augment_held(A, B) * interval);
  return {step.topLeftCorner(n, n), step.topRightCorner(n, B.cols())};
}

std::vector<Eigen::MatrixXd> integrate_quadratic_forms(const Eigen::MatrixXd& A,
                                                       const Eigen::MatrixXd& B,
                                                       const std::vector<Eigen::MatrixXd>& forms,
                                                       double interval) {
  const Eigen::MatrixXd held = augment_held(A, B);
  std::vector<Eigen::MatrixXd> integrals(forms.size(),
                                         Eigen::MatrixXd::Zero(held.rows(), held.cols()));
  if (interval <= 0) return integrals;

  // Ten Gauss points integrate e^(2 A s) to rounding while |A| h <= 1/2. The held input's
  // columns do not count: the integrand is a polynomial in them.
  const double rate = A.size() > 0 ? A.cwiseAbs().rowwise().sum().maxCoeff() : 0.0;
  int doublings = 0;
  double h = interval;
  while (rate * h > 0.5 && doublings < 60) {
    h /= 2;
    ++doublings;
  }

  using Rule = boost::math::quadrature::gauss<double, 10>;
  for (std::size_t i = 0; i < Rule::abscissa().size(); ++i) {
    for (const double node : {-Rule::abscissa()[i], Rule::abscissa()[i]}) {
      const Eigen::MatrixXd z = exponential(held * (h * (1 + node) / 2));
      const double weight = Rule::weights()[i] * h / 2;
      for (std::size_t f = 0; f < forms.size(); ++f)
        integrals[f] += weight * (z.transpose() * forms[f] * z);
    }
  }
  Eigen::MatrixXd z = exponential(held * h);
  for (int i = 0; i < doublings; ++i) {
    for (auto& integral : integrals) integral += (z.transpose() * integral * z).eval();
    z = (z * z).eval();
  }
  return integrals;
}

Eigen::VectorXcd compute_poles(const Eigen::MatrixXd& A) {
  if (A.rows() == 0) return {};
  Eigen::MatrixXd balanced = A;
  balance(balanced);
  return balanced.eigenvalues();
}

}  // namespace gyrator
