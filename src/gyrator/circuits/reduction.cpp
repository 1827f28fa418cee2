#include "gyrator/circuits/reduction.hpp"

#include "gyrator/core/error.hpp"

#include <algorithm>
#include <cmath>
#include <set>
#include <vector>

#include <Eigen/Sparse>
#include <fmt/core.h>
#include <fmt/ranges.h>

namespace gyrator {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::RowVectorXd;

// Pivots below this part of the largest entry in their equilibrated row count as zero. Component
// values span 1e-12 to 1e6, so rows and columns are scaled first; what cancels then leaves 1e-15.
constexpr double rank_tolerance = 1e-11;

// The network while it shrinks: E x' = A x + B u + R u', and how the original x is recovered.
struct Shrinking {
  MatrixXd E, A, B, R;
  MatrixXd state, input, rate;  // x_original = state x + input u + rate u'
  MatrixXd rows;                // present rows of E as combinations of the original equations
};

double power_of_two_near(double value) {
  return std::exp2(std::round(std::log2(value)));
}

// Row scales that bring the largest entry of each row to about one; powers of two, so exact.
Eigen::VectorXd row_scales(const MatrixXd& matrix) {
  Eigen::VectorXd scales = Eigen::VectorXd::Ones(matrix.rows());
  for (Index i = 0; i < matrix.rows(); ++i) {
    const double largest = matrix.cols() > 0 ? matrix.row(i).cwiseAbs().maxCoeff() : 0;
    if (largest > 0) scales(i) = 1 / power_of_two_near(largest);
  }
  return scales;
}

// Elimination of `matrix` by rows with full pivoting inside one set of columns at a time.
// On return the pivot rows form an identity in the pivot columns.
struct Elimination {
  MatrixXd reduced;      // row-reduced matrix
  MatrixXd combination;  // reduced = combination * matrix
  std::vector<Index> pivot_rows, pivot_columns;
  std::vector<Index> free_rows;
};

using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

// The rows while they are eliminated. Most of a network's entries are zero, so an operation costs
// what the pivot row holds, and the largest candidate of each row is kept until the row changes.
class Rows {
 public:
  explicit Rows(const MatrixXd& matrix)
      : reduced_(matrix),
        combination_(RowMajor::Identity(matrix.rows(), matrix.rows())),
        column_size_(Eigen::VectorXd::Ones(matrix.cols())),
        used_(static_cast<std::size_t>(matrix.rows()), false),
        best_(static_cast<std::size_t>(matrix.rows())) {
    const Eigen::VectorXd scales = row_scales(matrix);
    reduced_ = scales.asDiagonal() * reduced_;
    combination_.diagonal() = scales;
    for (Index j = 0; j < matrix.cols(); ++j) {
      const double largest = matrix.rows() > 0 ? reduced_.col(j).cwiseAbs().maxCoeff() : 0;
      if (largest > 0) column_size_(j) = largest;
    }
  }

  // Columns among which the next pivots are sought.
  void open(const std::vector<Index>& columns) {
    open_ = columns;
    for (Index i = 0; i < reduced_.rows(); ++i) find_best(i);
  }

  struct Pivot {
    Index row = -1, column = -1;
    double size = rank_tolerance;
  };
  // The largest candidate in any free row, the first column and row among equals.
  Pivot find_pivot() const {
    Pivot pivot;
    for (Index i = 0; i < reduced_.rows(); ++i) {
      if (used_[static_cast<std::size_t>(i)]) continue;
      const Pivot& candidate = best_[static_cast<std::size_t>(i)];
      if (candidate.row < 0) continue;
      if (candidate.size > pivot.size ||
          (candidate.size == pivot.size && candidate.column < pivot.column))
        pivot = candidate;
    }
    return pivot;
  }

  // Divides the pivot row by its pivot and takes it out of all others.
  void apply(const Pivot& pivot) {
    used_[static_cast<std::size_t>(pivot.row)] = true;
    open_.erase(std::find(open_.begin(), open_.end(), pivot.column));
    const double value = reduced_(pivot.row, pivot.column);
    reduced_.row(pivot.row) /= value;
    combination_.row(pivot.row) /= value;
    const std::vector<Index> in_reduced = find_entries(reduced_, pivot.row);
    const std::vector<Index> in_combination = find_entries(combination_, pivot.row);
    for (Index i = 0; i < reduced_.rows(); ++i) {
      const double factor = reduced_(i, pivot.column);
      if (i == pivot.row || factor == 0) continue;
      subtract(reduced_, i, factor, pivot.row, in_reduced);
      subtract(combination_, i, factor, pivot.row, in_combination);
      reduced_(i, pivot.column) = 0;
      find_best(i);
    }
  }

  bool is_free(Index row) const { return !used_[static_cast<std::size_t>(row)]; }
  const RowMajor& reduced() const { return reduced_; }
  const RowMajor& combination() const { return combination_; }

 private:
  static std::vector<Index> find_entries(const RowMajor& matrix, Index row) {
    std::vector<Index> entries;
    for (Index j = 0; j < matrix.cols(); ++j) {
      if (matrix(row, j) != 0) entries.push_back(j);
    }
    return entries;
  }

  static void subtract(RowMajor& matrix, Index row, double factor, Index from,
                       const std::vector<Index>& entries) {
    if (static_cast<Index>(entries.size()) > matrix.cols() / 4) {
      matrix.row(row) -= factor * matrix.row(from);
      return;
    }
    for (const Index j : entries) matrix(row, j) -= factor * matrix(from, j);
  }

  void find_best(Index row) {
    Pivot& best = best_[static_cast<std::size_t>(row)];
    best = {};
    if (used_[static_cast<std::size_t>(row)]) return;
    for (const Index column : open_) {
      const double size = std::abs(reduced_(row, column)) / column_size_(column);
      if (size > best.size) best = {row, column, size};
    }
  }

  RowMajor reduced_, combination_;
  Eigen::VectorXd column_size_;
  std::vector<bool> used_;
  std::vector<Index> open_;
  std::vector<Pivot> best_;  // of each free row
};

Elimination eliminate(const MatrixXd& matrix, const std::vector<std::vector<Index>>& column_sets) {
  Rows rows(matrix);
  Elimination e;
  for (const auto& columns : column_sets) {
    rows.open(columns);
    for (auto pivot = rows.find_pivot(); pivot.row >= 0; pivot = rows.find_pivot()) {
      rows.apply(pivot);
      e.pivot_rows.push_back(pivot.row);
      e.pivot_columns.push_back(pivot.column);
    }
  }
  for (Index i = 0; i < matrix.rows(); ++i) {
    if (rows.is_free(i)) e.free_rows.push_back(i);
  }
  e.reduced = rows.reduced();
  e.combination = rows.combination();
  return e;
}

// a b, at a cost that follows the entries where most of them are zero.
MatrixXd multiply(const MatrixXd& a, const MatrixXd& b) {
  constexpr double dense_advantage = 4;  // of a blocked product, per multiplication
  const auto count = [](const MatrixXd& m) {
    return static_cast<double>((m.array() != 0).count());
  };
  const auto size = [](Index n) { return static_cast<double>(n); };
  const double left = count(a) * size(b.cols());
  const double right = size(a.rows()) * count(b);
  if (std::min(left, right) > size(a.rows()) * size(a.cols()) * size(b.cols()) / dense_advantage)
    return a * b;
  using Sparse = Eigen::SparseMatrix<double>;
  if (left <= right) return Sparse(a.sparseView()) * b;
  return a * Sparse(b.sparseView());
}

std::vector<Index> range(Index n) {
  std::vector<Index> all(static_cast<std::size_t>(n));
  for (Index i = 0; i < n; ++i) all[static_cast<std::size_t>(i)] = i;
  return all;
}

[[noreturn]] void throw_singular(const Descriptor& descriptor, const RowVectorXd& equation) {
  std::set<std::string> elements;
  const double largest = equation.cwiseAbs().maxCoeff();
  for (Index i = 0; i < equation.size(); ++i) {
    if (std::abs(equation(i)) < 1e-6 * largest) continue;
    const auto& names = descriptor.equation_elements[static_cast<std::size_t>(i)];
    elements.insert(names.begin(), names.end());
    if (names.empty())
      elements.insert(descriptor.unknown_names[static_cast<std::size_t>(i)]);  // a bare node
  }
  throw Error(ErrorCode::numerical, fmt::format("{}", fmt::join(elements, ", ")),
              "singular network: these elements leave an unknown undetermined (a node that floats "
              "or is fed "
              "only by current sources) or contradict each other (a loop of voltage sources)");
}

}  // namespace

ReducedForm Reduction::reduce(const LinearForm& form) const {
  ReducedForm reduced{RowVectorXd::Zero(recover_state.cols()), form.u,
                      RowVectorXd::Zero(recover_rate.cols())};
  for (Index i = 0; i < form.x.size(); ++i) {  // a form names a few unknowns
    if (form.x(i) == 0) continue;
    reduced.state += form.x(i) * recover_state.row(i);
    reduced.input += form.x(i) * recover_input.row(i);
    reduced.input_rate += form.x(i) * recover_rate.row(i);
  }
  return reduced;
}

Reduction reduce(const Descriptor& descriptor) {
  const Index size = descriptor.size();
  const Index inputs = descriptor.B.cols();
  Shrinking s{descriptor.E,
              descriptor.A,
              descriptor.B,
              MatrixXd::Zero(size, inputs),
              MatrixXd::Identity(size, size),
              MatrixXd::Zero(size, inputs),
              MatrixXd::Zero(size, inputs),
              MatrixXd::Identity(size, size)};

  MatrixXd inverse;  // of E, once it is regular
  for (;;) {
    // Split the equations into differential ones and those that E leaves algebraic.
    const Elimination split = eliminate(s.E, {range(s.E.cols())});
    if (split.free_rows.empty()) {
      inverse = MatrixXd(s.E.cols(), s.E.rows());
      for (std::size_t k = 0; k < split.pivot_rows.size(); ++k)
        inverse.row(split.pivot_columns[k]) = split.combination.row(split.pivot_rows[k]);
      break;
    }
    const MatrixXd rows_d = split.combination(split.pivot_rows, Eigen::all);
    const MatrixXd rows_a = split.combination(split.free_rows, Eigen::all);
    const MatrixXd E_d = split.reduced(split.pivot_rows, Eigen::all);
    const MatrixXd A_a = multiply(rows_a, s.A);

    // Solve the algebraic ones, for unknowns without a derivative first: what is left as state
    // is then a node's velocity, a voltage or an inductor's current wherever possible.
    std::vector<Index> algebraic;
    std::vector<Index> differential;
    for (Index j = 0; j < E_d.cols(); ++j)
      (E_d.col(j).isZero(0) ? algebraic : differential).push_back(j);
    const Elimination solved = eliminate(A_a, {algebraic, differential});
    if (!solved.free_rows.empty()) {
      const RowVectorXd equation =
          solved.combination.row(solved.free_rows.front()) * rows_a * s.rows;
      throw_singular(descriptor, equation);
    }
    std::vector<bool> is_pivot(static_cast<std::size_t>(s.A.cols()), false);
    for (const Index j : solved.pivot_columns) is_pivot[static_cast<std::size_t>(j)] = true;
    std::vector<Index> kept;
    for (Index j = 0; j < s.A.cols(); ++j) {
      if (!is_pivot[static_cast<std::size_t>(j)]) kept.push_back(j);
    }

    // x = N x_kept + N_u u + N_r u'
    const Index n = s.A.cols();
    MatrixXd N = MatrixXd::Zero(n, static_cast<Index>(kept.size()));
    MatrixXd N_u = MatrixXd::Zero(n, inputs);
    MatrixXd N_r = MatrixXd::Zero(n, inputs);
    for (std::size_t k = 0; k < kept.size(); ++k) N(kept[k], static_cast<Index>(k)) = 1;
    const MatrixXd B_a = solved.combination * (rows_a * s.B);
    MatrixXd R_a = solved.combination * (rows_a * s.R);
    // Sums that cancel to rounding are zero: no derivative of u where there is none.
    const MatrixXd R_size = solved.combination.cwiseAbs() * (rows_a.cwiseAbs() * s.R.cwiseAbs());
    R_a = (R_a.array().abs() > 1e-12 * R_size.array()).select(R_a, 0.0);
    for (std::size_t k = 0; k < solved.pivot_columns.size(); ++k) {
      const Index column = solved.pivot_columns[k];
      const Index row = solved.pivot_rows[k];
      for (std::size_t f = 0; f < kept.size(); ++f)
        N(column, static_cast<Index>(f)) = -solved.reduced(row, kept[f]);
      N_u.row(column) = -B_a.row(row);
      N_r.row(column) = -R_a.row(row);
    }
    const MatrixXd second_rate = E_d * N_r;
    const MatrixXd second_size = E_d.cwiseAbs() * N_r.cwiseAbs();
    if ((second_rate.array().abs() > 1e-9 * second_size.array()).any()) {
      throw Error(
          ErrorCode::numerical, "network",
          "index 3: the motion would need the second derivative of an input; add the inductance, "
          "resistance or compliance that the real circuit has");
    }

    Shrinking next;
    const MatrixXd A_d = multiply(rows_d, s.A);
    next.E = multiply(E_d, N);
    next.A = multiply(A_d, N);
    next.B = rows_d * (s.B + s.A * N_u);
    next.R = rows_d * (s.R + s.A * N_r) - E_d * N_u;
    next.state = multiply(s.state, N);
    next.input = s.input + s.state * N_u;
    next.rate = s.rate + s.state * N_r;
    // A differential equation may hold an unknown that the algebraic ones determine and that has an
    // impulse where the initial values contradict them (the force that joins two masses). With the
    // algebraic equations added so that it drops out, charge and momentum are kept.
    const MatrixXd held = A_d(Eigen::all, solved.pivot_columns);
    const MatrixXd solved_rows = solved.combination(solved.pivot_rows, Eigen::all);
    next.rows = multiply(rows_d - multiply(multiply(held, solved_rows), rows_a), s.rows);
    s = std::move(next);
  }

  // dw/dt = E^-1 (A w + B u + R u'), then w -> w - F u with F = E^-1 R.
  Reduction r;
  r.A = multiply(inverse, s.A);
  const MatrixXd F = multiply(inverse, s.R);
  r.B = multiply(inverse, s.B) + multiply(r.A, F);
  r.recover_state = s.state;
  r.recover_input = s.input + s.state * F;
  r.recover_rate = s.rate;
  r.initialize = multiply(inverse, multiply(s.rows, descriptor.E));
  return r;
}

}  // namespace gyrator
