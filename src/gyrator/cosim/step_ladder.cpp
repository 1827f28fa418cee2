#include "gyrator/cosim/step_ladder.hpp"

#include "gyrator/circuits/state_space.hpp"

#include <algorithm>
#include <cmath>

#include <boost/math/quadrature/gauss.hpp>

namespace gyrator {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;

constexpr double finest = 0.25;  // of the fastest time constant
constexpr int most_steps = 100;
// x^j/j! at x = 1/4 is below rounding; energies, whose rates are twice as fast, need a few more.
constexpr int terms = 14;
constexpr int energy_terms = 18;

// Upper triangle row by row, off-diagonal entries doubled, so that z'Wz = sum of w_ij z_i z_j.
void pack(const MatrixXd& form, Index row, Eigen::Matrix<double, 3, Eigen::Dynamic>& packed) {
  Index at = 0;
  for (Index i = 0; i < form.rows(); ++i) {
    for (Index j = i; j < form.cols(); ++j)
      packed(row, at++) = i == j ? form(i, i) : form(i, j) + form(j, i);
  }
}

void add_work(const Eigen::Matrix<double, 3, Eigen::Dynamic>& packed, const double* z, Index size,
              double by, StepLadder::Work& work) {
  const double* w = packed.data();
  double sum0 = 0;  // three of their own: an array is kept in memory
  double sum1 = 0;
  double sum2 = 0;
  for (Index i = 0; i < size; ++i) {
    for (Index j = i; j < size; ++j, w += 3) {
      const double product = z[i] * z[j];
      sum0 += w[0] * product;
      sum1 += w[1] * product;
      sum2 += w[2] * product;
    }
  }
  work[0] += by * sum0;
  work[1] += by * sum1;
  work[2] += by * sum2;
}

}  // namespace

StepLadder::StepLadder(const MatrixXd& rate, const std::vector<MatrixXd>& forms, double longest)
    : rate_(rate), forms_(forms), n_(rate.rows()), size_(rate.cols()), at_(rate.cols()) {
  MatrixXd balanced = rate.leftCols(n_);
  balance(balanced);
  if (n_ > 0) rate_bound_ = balanced.cwiseAbs().rowwise().sum().maxCoeff();
  int count = 1;
  for (double h = longest; rate_bound_ * h > finest && count < most_steps; h /= 2) ++count;
  series_ = MatrixXd::Zero(size_, terms + 1);
  if (!forms_.empty()) {
    packed_forms_.resize(3, size_ * (size_ + 1) / 2);
    for (Index f = 0; f < 3; ++f) pack(forms_[static_cast<std::size_t>(f)], f, packed_forms_);
  }
  build(longest, count);
}

void StepLadder::build(double longest, int count) {
  const double h = std::ldexp(longest, 1 - count);
  const auto A = rate_.leftCols(n_);
  MatrixXd term = h * rate_;
  MatrixXd change = term;
  MatrixXd next(n_, size_);
  for (int j = 2; j <= terms; ++j) {
    next.noalias() = (h / j) * A.lazyProduct(term);
    term.swap(next);
    change += term;
  }
  // dE/dt of z'Ez along the motion is A_z'E + E A_z; the series of its integral from E = Q t.
  std::vector<MatrixXd> energies;
  for (const MatrixXd& form : forms_) {
    MatrixXd part = h * form;
    MatrixXd sum = part;
    for (int j = 2; j <= energy_terms; ++j) {
      const MatrixXd half = (h / j) * part.leftCols(n_).lazyProduct(rate_);
      part = half + half.transpose();
      sum += part;
    }
    energies.push_back(std::move(sum));
  }
  steps_.resize(static_cast<std::size_t>(count));
  for (int k = count - 1;; --k) {
    Step& step = steps_[static_cast<std::size_t>(k)];
    step.length = std::ldexp(longest, -k);
    step.change = change;
    step.energies.resize(3, forms_.empty() ? 0 : size_ * (size_ + 1) / 2);
    for (std::size_t f = 0; f < energies.size(); ++f)
      pack(energies[f], static_cast<Index>(f), step.energies);
    if (k == 0) break;
    for (MatrixXd& E : energies) {
      // (I + M)'E(I + M), M = [change; 0]
      const MatrixXd left = E.leftCols(n_).lazyProduct(change);
      const MatrixXd both = change.transpose().lazyProduct(left.topRows(n_));
      E = 2 * E + (left + left.transpose()) + both;
    }
    next.noalias() = change.leftCols(n_).lazyProduct(change);
    change = 2 * change + next;
  }
}

void StepLadder::move(int step, const double* z, double* xi) const {
  const double* column = steps_[static_cast<std::size_t>(step)].change.data();
  for (Index i = 0; i < n_; ++i) xi[i] = column[i] * z[0];
  for (Index j = 1; j < size_; ++j) {
    column += n_;
    const double zj = z[j];
    for (Index i = 0; i < n_; ++i) xi[i] += column[i] * zj;
  }
  for (Index i = 0; i < n_; ++i) xi[i] += z[i];
}

void StepLadder::book(int step, const double* z, Work& work) const {
  if (!forms_.empty()) add_work(steps_[static_cast<std::size_t>(step)].energies, z, size_, 1, work);
}

void StepLadder::expand(const double* z, double length) {
  expanded_ = length;
  double* column = series_.data();
  for (Index i = 0; i < size_; ++i) column[i] = z[i];
  // Constants are among the first term's sources only.
  for (int j = 1; j <= terms; ++j) {
    const double* from = column;
    column += size_;
    const Index sources = j == 1 ? size_ : n_;
    const double factor = length / j;
    const double* a = rate_.data();
    for (Index i = 0; i < n_; ++i) column[i] = 0;
    for (Index s = 0; s < sources; ++s, a += n_) {
      const double by = from[s] * factor;
      for (Index i = 0; i < n_; ++i) column[i] += a[i] * by;
    }
  }
}

void StepLadder::move_to(double part, double* xi) const {
  const double* column = series_.data() + terms * size_;
  for (Index i = 0; i < n_; ++i) xi[i] = column[i];
  for (int j = terms - 1; j >= 0; --j) {
    column -= size_;
    for (Index i = 0; i < n_; ++i) xi[i] = xi[i] * part + column[i];
  }
}

void StepLadder::book_to(double part, Work& work) const {
  if (forms_.empty()) return;
  using Rule = boost::math::quadrature::gauss<double, 10>;
  for (Index i = n_; i < size_; ++i) at_(i) = series_(i, 0);
  for (std::size_t i = 0; i < Rule::abscissa().size(); ++i) {
    for (const double node : {-Rule::abscissa()[i], Rule::abscissa()[i]}) {
      move_to(part * (1 + node) / 2, at_.data());
      add_work(packed_forms_, at_.data(), size_, Rule::weights()[i] * part * expanded_ / 2, work);
    }
  }
}

void StepLadder::travel(double length, Eigen::VectorXd& z, Work& work) {
  int step = 0;
  while (step < steps()) {
    if (this->length(step) > length) {
      ++step;
      continue;
    }
    book(step, z.data(), work);
    move(step, z.data(), at_.data());
    z.head(n_) = at_.head(n_);
    length -= this->length(step);
  }
  if (!(length > 0)) return;
  expand(z.data(), length);
  book_to(1, work);
  move_to(1, z.data());
}

}  // namespace gyrator
