#pragma once

#include <vector>

#include <Eigen/Dense>

namespace gyrator {

/// u v^T, and how much of it is in each of several matrices.
struct RankOne {
  Eigen::VectorXd row, column;  ///< u, v
  std::vector<double> factors;
};

/// Writes several matrices as sums of the same matrices of rank one, matrix_k = sum_t factors_k u_t
/// v_t^T: one for each block of rows and columns that hang together, as an element's stamp does,
/// where all of them are multiples of one such there; elsewhere one for each entry.
std::vector<RankOne> split_rank_one(const std::vector<Eigen::MatrixXd>& matrices);

}  // namespace gyrator
