#include "gyrator/circuits/hessenberg_response.hpp"

#include "gyrator/core/plain_complex.hpp"

#include <Eigen/Eigenvalues>

namespace gyrator {
HessenbergResponse::HessenbergResponse(const StateSpace& system) : feedthrough_(system.D) {
  Eigen::MatrixXd A = system.A;
  const Eigen::Index n = A.rows();
  const Eigen::VectorXd scale = balance(A);
  Eigen::MatrixXd Q = Eigen::MatrixXd::Identity(n, n);
  hessenberg_ = A;
  if (n > 2) {
    const Eigen::HessenbergDecomposition<Eigen::MatrixXd> decomposition(A);
    hessenberg_ = decomposition.matrixH();
    Q = decomposition.matrixQ();
  }
  input_ = Q.transpose() * scale.cwiseInverse().asDiagonal() * system.B;
  output_ = system.C * scale.asDiagonal() * Q;
  work_.resize(n, n);
  solution_.resize(n, system.B.cols());
}

void HessenbergResponse::evaluate(std::complex<double> s, Eigen::MatrixXcd& response) {
  using Complex = std::complex<double>;
  const Eigen::Index n = hessenberg_.rows();
  const Eigen::Index m = input_.cols();
  for (Eigen::Index j = 0; j < n; ++j) {
    for (Eigen::Index i = 0; i < n; ++i) work_(i, j) = -hessenberg_(i, j);
    work_(j, j) += s;
    for (Eigen::Index k = 0; k < m; ++k) solution_(j, k) = input_(j, k);
  }
  // Gaussian elimination with partial pivoting between neighbouring rows.
  for (Eigen::Index j = 0; j + 1 < n; ++j) {
    if (std::norm(work_(j + 1, j)) > std::norm(work_(j, j))) {
      work_.row(j).swap(work_.row(j + 1));
      solution_.row(j).swap(solution_.row(j + 1));
    }
    if (work_(j + 1, j) == Complex(0)) continue;
    const Complex factor = plain_product(work_(j + 1, j), plain_reciprocal(work_(j, j)));
    for (Eigen::Index k = j + 1; k < n; ++k) work_(j + 1, k) -= plain_product(factor, work_(j, k));
    for (Eigen::Index k = 0; k < m; ++k)
      solution_(j + 1, k) -= plain_product(factor, solution_(j, k));
  }
  for (Eigen::Index j = n; j-- > 0;) {
    const Complex inverse = plain_reciprocal(work_(j, j));
    for (Eigen::Index k = 0; k < m; ++k) {
      Complex sum = solution_(j, k);
      for (Eigen::Index i = j + 1; i < n; ++i) sum -= plain_product(work_(j, i), solution_(i, k));
      solution_(j, k) = plain_product(sum, inverse);
    }
  }
  response.resize(output_.rows(), m);
  for (Eigen::Index r = 0; r < output_.rows(); ++r) {
    for (Eigen::Index k = 0; k < m; ++k) {
      Complex sum = feedthrough_(r, k);
      for (Eigen::Index i = 0; i < n; ++i) sum += output_(r, i) * solution_(i, k);
      response(r, k) = sum;
    }
  }
}

}  // namespace gyrator
