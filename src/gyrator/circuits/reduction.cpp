#include "gyrator/circuits/reduction.hpp"

#include "gyrator/core/error.hpp"

#include <cmath>
#include <set>
#include <vector>

#include <fmt/core.h>
#include <fmt/ranges.h>

namespace gyrator {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;

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

Elimination eliminate(const MatrixXd& matrix, const std::vector<std::vector<Index>>& column_sets) {
  Elimination e{matrix, MatrixXd::Identity(matrix.rows(), matrix.rows()), {}, {}, {}};
  const Eigen::VectorXd scales = row_scales(matrix);
  e.reduced = scales.asDiagonal() * e.reduced;
  e.combination = scales.asDiagonal() * e.combination;
  Eigen::VectorXd column_size = Eigen::VectorXd::Ones(matrix.cols());
  for (Index j = 0; j < matrix.cols(); ++j) {
    const double largest = matrix.rows() > 0 ? e.reduced.col(j).cwiseAbs().maxCoeff() : 0;
    if (largest > 0) column_size(j) = largest;
  }
  std::vector<bool> used(static_cast<std::size_t>(matrix.rows()), false);
  for (const auto& columns : column_sets) {
    std::vector<Index> open = columns;
    while (!open.empty()) {
      Index best_row = -1;
      std::size_t best = 0;
      double best_size = rank_tolerance;
      for (std::size_t k = 0; k < open.size(); ++k) {
        for (Index i = 0; i < matrix.rows(); ++i) {
          if (used[static_cast<std::size_t>(i)]) continue;
          const double size = std::abs(e.reduced(i, open[k])) / column_size(open[k]);
          if (size > best_size) {
            best_size = size;
            best_row = i;
            best = k;
          }
        }
      }
      if (best_row < 0) break;
      const Index column = open[best];
      const double pivot = e.reduced(best_row, column);
      e.reduced.row(best_row) /= pivot;
      e.combination.row(best_row) /= pivot;
      for (Index i = 0; i < matrix.rows(); ++i) {
        const double factor = e.reduced(i, column);
        if (i == best_row || factor == 0) continue;
        e.reduced.row(i) -= factor * e.reduced.row(best_row);
        e.combination.row(i) -= factor * e.combination.row(best_row);
        e.reduced(i, column) = 0;
      }
      used[static_cast<std::size_t>(best_row)] = true;
      e.pivot_rows.push_back(best_row);
      e.pivot_columns.push_back(column);
      open.erase(open.begin() + static_cast<std::ptrdiff_t>(best));
    }
  }
  for (Index i = 0; i < matrix.rows(); ++i) {
    if (!used[static_cast<std::size_t>(i)]) e.free_rows.push_back(i);
  }
  return e;
}

std::vector<Index> range(Index n) {
  std::vector<Index> all(static_cast<std::size_t>(n));
  for (Index i = 0; i < n; ++i) all[static_cast<std::size_t>(i)] = i;
  return all;
}

[[noreturn]] void throw_singular(const Descriptor& descriptor, const Eigen::RowVectorXd& equation) {
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
  return {form.x * recover_state, form.x * recover_input + form.u, form.x * recover_rate};
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

  while (s.E.rows() > 0) {
    // Split the equations into differential ones and those that E leaves algebraic.
    const Elimination split = eliminate(s.E, {range(s.E.cols())});
    if (split.free_rows.empty()) break;
    const MatrixXd rows_d = split.combination(split.pivot_rows, Eigen::all);
    const MatrixXd rows_a = split.combination(split.free_rows, Eigen::all);
    const MatrixXd E_d = split.reduced(split.pivot_rows, Eigen::all);
    const MatrixXd A_a = rows_a * s.A;

    // Solve the algebraic ones, for unknowns without a derivative first: what is left as state
    // is then a node's velocity, a voltage or an inductor's current wherever possible.
    std::vector<Index> algebraic;
    std::vector<Index> differential;
    for (Index j = 0; j < E_d.cols(); ++j)
      (E_d.col(j).isZero(0) ? algebraic : differential).push_back(j);
    const Elimination solved = eliminate(A_a, {algebraic, differential});
    if (!solved.free_rows.empty()) {
      const Eigen::RowVectorXd equation =
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
    next.E = E_d * N;
    next.A = rows_d * s.A * N;
    next.B = rows_d * (s.B + s.A * N_u);
    next.R = rows_d * (s.R + s.A * N_r) - E_d * N_u;
    next.state = s.state * N;
    next.input = s.input + s.state * N_u;
    next.rate = s.rate + s.state * N_r;
    // A differential equation may hold an unknown that the algebraic ones determine and that has an
    // impulse where the initial values contradict them (the force that joins two masses). With the
    // algebraic equations added so that it drops out, charge and momentum are kept.
    const MatrixXd held = (rows_d * s.A)(Eigen::all, solved.pivot_columns);
    next.rows =
        (rows_d - held * solved.combination(solved.pivot_rows, Eigen::all) * rows_a) * s.rows;
    s = std::move(next);
  }

  // dw/dt = E^-1 (A w + B u + R u'), then w -> w - F u with F = E^-1 R.
  const Eigen::PartialPivLU<MatrixXd> lu(s.E);
  const auto solve = [&](const MatrixXd& rhs) -> MatrixXd {
    return s.E.rows() > 0 ? MatrixXd(lu.solve(rhs)) : MatrixXd(0, rhs.cols());
  };
  Reduction r;
  r.A = solve(s.A);
  const MatrixXd F = solve(s.R);
  r.B = solve(s.B) + r.A * F;
  r.recover_state = s.state;
  r.recover_input = s.input + s.state * F;
  r.recover_rate = s.rate;
  r.initialize = solve(s.rows * descriptor.E);
  return r;
}

}  // namespace gyrator
