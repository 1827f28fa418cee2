#include "gyrator/circuits/descriptor_response.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include <Eigen/Sparse>

namespace gyrator {
namespace {

using Complex = std::complex<double>;
using Eigen::Index;
using Eigen::MatrixXcd;
using Eigen::VectorXcd;
using SparsePencil = Eigen::SparseMatrix<Complex>;
using SparseFactors = Eigen::SparseLU<SparsePencil, Eigen::COLAMDOrdering<int>>;

// The scaled pencil's entries are about one; an inverse beyond this leaves the answer hardly a
// digit. Genuine networks stay far below (1e-12 S beside 1 S makes 1e12); rounding that stands in
// for a zero pivot makes 1e15 and more.
constexpr double singular_growth = 1e14;

// Numbers in ±[0.5, 1.5] without pattern: whatever the pencil amplifies, they contain.
VectorXcd make_probe(Index size) {
  VectorXcd probe(size);
  for (Index i = 0; i < size; ++i) {
    const double part = std::fmod(0.6180339887498949 * static_cast<double>(i + 1), 1.0);
    probe(i) = (i % 2 == 0 ? 1.0 : -1.0) * (0.5 + part);
  }
  return probe;
}

// Index of the unknown that a singular matrix leaves free: one inverse iteration on the matrix
// moved off its zero eigenvalue by less than what rounding could tell.
Index find_free_unknown(const SparsePencil& singular) {
  SparsePencil identity(singular.rows(), singular.cols());
  identity.setIdentity();
  SparsePencil shifted = singular + Complex(1e-13, 0.7e-13) * identity;
  shifted.makeCompressed();
  SparseFactors factors;
  factors.compute(shifted);
  Index unknown = 0;
  if (factors.info() != Eigen::Success) return unknown;
  const VectorXcd direction = factors.solve(make_probe(singular.rows()));
  if (direction.allFinite()) direction.cwiseAbs().maxCoeff(&unknown);
  return unknown;
}

}  // namespace

class DescriptorResponse::Solver {
 public:
  Solver(const Descriptor& descriptor, Index sparse_at)
      : sparse_(descriptor.size() >= sparse_at),
        places_(descriptor.equation_elements),
        inputs_(descriptor.B.cast<Complex>()) {
    const Index n = descriptor.size();
    for (std::size_t i = 0; i < places_.size(); ++i) {
      if (places_[i].empty()) places_[i] = {descriptor.unknown_names[i]};  // a bare node
    }
    pencil_.resize(n, n);
    const Eigen::MatrixXd used = descriptor.E.cwiseAbs() + descriptor.A.cwiseAbs();
    pencil_.reserve(Eigen::VectorXi((used.array() != 0).cast<int>().colwise().sum().transpose()));
    std::vector<bool> row_used(static_cast<std::size_t>(n), false);
    for (Index j = 0; j < n; ++j) {
      bool column_used = false;
      for (Index i = 0; i < n; ++i) {
        if (used(i, j) == 0) continue;
        pencil_.insert(i, j) = 1;
        derivative_.push_back(descriptor.E(i, j));
        constant_.push_back(descriptor.A(i, j));
        row_used[static_cast<std::size_t>(i)] = column_used = true;
      }
      complete_ = complete_ && column_used;
    }
    complete_ = complete_ && std::find(row_used.begin(), row_used.end(), false) == row_used.end();
    pencil_.makeCompressed();
    exponents_.resize(derivative_.size());
    right_.resize(n, inputs_.cols() + 1);
    right_.col(inputs_.cols()) = make_probe(n);
    if (sparse_ && complete_) factors_.analyzePattern(pencil_);
  }

  const MatrixXcd& solve(Complex s) {
    const Index n = pencil_.rows();
    if (n == 0) return solution_ = inputs_;
    if (const Index row = assemble(s); row >= 0) throw_singular(row, s);
    if (!complete_) throw_singular(find_free_unknown(pencil_), s);
    right_.leftCols(inputs_.cols()) = row_scale_.asDiagonal() * inputs_;
    if (sparse_) {
      factors_.factorize(pencil_);
      if (factors_.info() != Eigen::Success) throw_singular(find_free_unknown(pencil_), s);
      scaled_ = factors_.solve(right_);
    } else {
      scaled_ = MatrixXcd(pencil_).partialPivLu().solve(right_);
    }
    if (!scaled_.allFinite()) throw_singular(find_free_unknown(pencil_), s);
    Index unknown = 0;
    if (scaled_.col(inputs_.cols()).cwiseAbs().maxCoeff(&unknown) > singular_growth)
      throw_singular(unknown, s);
    solution_ = column_scale_.asDiagonal() * scaled_.leftCols(inputs_.cols());
    return solution_;
  }

 private:
  // The scaled pencil at s. Returns a row that is not finite, or -1.
  Index assemble(Complex s) {
    const int* columns = pencil_.outerIndexPtr();
    const int* rows = pencil_.innerIndexPtr();
    Complex* values = pencil_.valuePtr();
    for (std::size_t k = 0; k < exponents_.size(); ++k) {
      values[k] = {s.real() * derivative_[k] - constant_[k], s.imag() * derivative_[k]};
      const double size = std::max(std::abs(values[k].real()), std::abs(values[k].imag()));
      if (!std::isfinite(size)) return rows[k];
      exponents_[k] = size > 0 ? std::ilogb(size) : no_entry;
    }
    find_scales();
    for (Index j = 0; j < pencil_.cols(); ++j) {
      for (int k = columns[j]; k < columns[j + 1]; ++k)
        values[k] *= row_scale_(rows[k]) * column_scale_(j);
    }
    return -1;
  }

  // Exponents of row and column scales: each sweep takes half of every largest entry out of its
  // row and half out of its column; the last brings each row to about one.
  void find_scales() {
    constexpr int sweeps = 3;
    const Index n = pencil_.rows();
    const int* columns = pencil_.outerIndexPtr();
    const int* rows = pencil_.innerIndexPtr();
    row_exponent_.setZero(n);
    column_exponent_.setZero(n);
    for (int sweep = 0; sweep <= sweeps; ++sweep) {
      row_largest_.setConstant(n, no_entry);
      column_largest_.setConstant(n, no_entry);
      for (Index j = 0; j < n; ++j) {
        for (int k = columns[j]; k < columns[j + 1]; ++k) {
          if (exponents_[static_cast<std::size_t>(k)] == no_entry) continue;
          const int size = exponents_[static_cast<std::size_t>(k)] - row_exponent_(rows[k]) -
                           column_exponent_(j);
          row_largest_(rows[k]) = std::max(row_largest_(rows[k]), size);
          column_largest_(j) = std::max(column_largest_(j), size);
        }
      }
      for (Index i = 0; i < n; ++i) {
        const bool last = sweep == sweeps;
        if (row_largest_(i) != no_entry)
          row_exponent_(i) += last ? row_largest_(i) : row_largest_(i) / 2;
        if (column_largest_(i) != no_entry && !last) column_exponent_(i) += column_largest_(i) / 2;
      }
    }
    row_scale_.resize(n);
    column_scale_.resize(n);
    for (Index i = 0; i < n; ++i) {
      row_scale_(i) = std::ldexp(1.0, -row_exponent_(i));
      column_scale_(i) = std::ldexp(1.0, -column_exponent_(i));
    }
  }

  [[noreturn]] void throw_singular(Index unknown, Complex s) const {
    throw_singular_pencil(places_[static_cast<std::size_t>(unknown)], s);
  }

  static constexpr int no_entry = std::numeric_limits<int>::min();

  bool sparse_;
  bool complete_ = true;                          // no row or column is empty
  std::vector<std::vector<std::string>> places_;  // elements around each unknown
  MatrixXcd inputs_;
  SparsePencil pencil_;
  std::vector<double> derivative_, constant_;  // of E and A, in the order of the pencil's values
  std::vector<int> exponents_;
  Eigen::VectorXi row_exponent_, column_exponent_, row_largest_, column_largest_;
  Eigen::VectorXd row_scale_, column_scale_;
  SparseFactors factors_;
  MatrixXcd right_, scaled_, solution_;
};

DescriptorResponse::DescriptorResponse(const Descriptor& descriptor, Eigen::Index sparse_at)
    : solver_(std::make_unique<Solver>(descriptor, sparse_at)) {}
DescriptorResponse::~DescriptorResponse() = default;
DescriptorResponse::DescriptorResponse(DescriptorResponse&&) noexcept = default;
DescriptorResponse& DescriptorResponse::operator=(DescriptorResponse&&) noexcept = default;

const Eigen::MatrixXcd& DescriptorResponse::solve(std::complex<double> s) {
  return solver_->solve(s);
}

}  // namespace gyrator
