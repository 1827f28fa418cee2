#include "gyrator/robustness/rank_one_terms.hpp"

#include <optional>

namespace gyrator {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;

constexpr double rounding = 1e-11;

// The entries that hang together with (row, column), taken out of `left`.
MatrixXd take_block(MatrixXd& left, Index row, Index column) {
  MatrixXd block = MatrixXd::Zero(left.rows(), left.cols());
  std::vector<std::pair<Index, Index>> open{{row, column}};
  while (!open.empty()) {
    const auto [r, c] = open.back();
    open.pop_back();
    if (left(r, c) == 0) continue;
    block(r, c) = left(r, c);
    left(r, c) = 0;
    for (Index i = 0; i < left.rows(); ++i) {
      if (left(i, c) != 0) open.emplace_back(i, c);
    }
    for (Index j = 0; j < left.cols(); ++j) {
      if (left(r, j) != 0) open.emplace_back(r, j);
    }
  }
  return block;
}

// Where `block` has entries, all matrices as multiples of u v^T.
std::optional<RankOne> find_common(const std::vector<MatrixXd>& matrices, const MatrixXd& block) {
  std::size_t largest = 0;
  double most = 0;
  Index row = 0;
  Index column = 0;
  for (std::size_t k = 0; k < matrices.size(); ++k) {
    Index r = 0;
    Index c = 0;
    const double size =
        (block.array() != 0).select(matrices[k].array().abs(), 0.0).maxCoeff(&r, &c);
    if (size <= most) continue;
    most = size;
    largest = k;
    row = r;
    column = c;
  }
  const MatrixXd shape = (block.array() != 0).select(matrices[largest], 0.0);
  RankOne term{shape.col(column), shape.row(row).transpose() / shape(row, column), {}};
  const MatrixXd unit = term.row * term.column.transpose();
  for (const MatrixXd& matrix : matrices) {
    const double factor = matrix(row, column) / shape(row, column);
    const MatrixXd part = (block.array() != 0).select(matrix, 0.0);
    if ((part - factor * unit).cwiseAbs().maxCoeff() > rounding * most) return std::nullopt;
    term.factors.push_back(factor);
  }
  return term;
}

}  // namespace

std::vector<RankOne> split_rank_one(const std::vector<MatrixXd>& matrices) {
  MatrixXd left = matrices[0].cwiseAbs();
  for (const MatrixXd& matrix : matrices) left = left.cwiseMax(matrix.cwiseAbs());
  std::vector<RankOne> terms;
  for (Index r = 0; r < left.rows(); ++r) {
    for (Index c = 0; c < left.cols(); ++c) {
      if (left(r, c) == 0) continue;
      const MatrixXd block = take_block(left, r, c);
      if (auto common = find_common(matrices, block)) {
        terms.push_back(std::move(*common));
        continue;
      }
      for (Index i = 0; i < block.rows(); ++i) {
        for (Index j = 0; j < block.cols(); ++j) {
          if (block(i, j) == 0) continue;
          RankOne entry{
              Eigen::VectorXd::Unit(block.rows(), i), Eigen::VectorXd::Unit(block.cols(), j), {}};
          for (const MatrixXd& matrix : matrices) entry.factors.push_back(matrix(i, j));
          terms.push_back(std::move(entry));
        }
      }
    }
  }
  return terms;
}

}  // namespace gyrator
