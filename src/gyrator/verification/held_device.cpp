#include "gyrator/verification/held_device.hpp"

#include <cmath>
#include <limits>

namespace gyrator {
namespace {

using Complex = std::complex<double>;
using Long = long double;
using LongComplex = std::complex<long double>;
using LongMatrix = Eigen::Matrix<LongComplex, Eigen::Dynamic, Eigen::Dynamic>;

constexpr double infinity = std::numeric_limits<double>::infinity();
constexpr double vanishing = 1e-9;  // of a coefficient against what it is made of
constexpr double singular = 1e-13;  // of singular values against the largest
constexpr int most_orders = 8;      // taken out of a response at high frequency

// C (sI - A)^-1 B + D
LongMatrix solve_long(const Eigen::MatrixXd& A, const Eigen::MatrixXd& B, const Eigen::MatrixXd& C,
                      const Eigen::MatrixXd& D, LongComplex s) {
  LongMatrix pencil = -A.cast<LongComplex>();
  pencil.diagonal().array() += s;
  LongMatrix result = D.cast<LongComplex>();
  if (A.rows() > 0)
    result += C.cast<LongComplex>() * pencil.partialPivLu().solve(B.cast<LongComplex>().eval());
  return result;
}

// (I - Q)^-1 v for Q >= 0, where that is Neumann's series: it maps 1 to something not below 1.
class Neumann {
 public:
  explicit Neumann(const Eigen::MatrixXd& Q)
      : solver_(Eigen::MatrixXd::Identity(Q.rows(), Q.rows()) - Q) {
    const Eigen::VectorXd ones = Eigen::VectorXd::Ones(Q.rows());
    const Eigen::VectorXd image = solver_.solve(ones);
    valid_ = image.allFinite() && (image.array() >= 1 - 1e-9).all();
  }
  bool valid() const { return valid_; }
  Eigen::MatrixXd solve(const Eigen::MatrixXd& v) const { return solver_.solve(v); }

 private:
  Eigen::PartialPivLU<Eigen::MatrixXd> solver_;
  bool valid_ = false;
};

// row y(t), y = (I - t K)^-1 y0 = y0 + t K y0 + t^2 K (I - tK)^-1 K y0
template <class Matrix, class Vector, class Row>
SlopeForm enclose_moved(const Row& row, const Matrix& K, const Vector& start, double reach) {
  const Vector moved = K * start;
  const Row weight = row * K;
  const Neumann series(reach * K.cwiseAbs());
  const double bend =
      series.valid() ? weight.cwiseAbs().dot(series.solve(moved.cwiseAbs()).col(0)) : infinity;
  return {(row * start).value(), {(row * moved).value(), reach > 0 ? reach * bend : 0}, reach};
}

}  // namespace

HeldResponse compute_held_response(const HeldDevice& device, long double omega) {
  const StateSpace& s = device.system;
  const LongMatrix g = solve_long(s.A, s.B, s.C, s.D, LongComplex(0, omega));
  HeldResponse r{g(0, 1) + LongComplex(0, omega * static_cast<Long>(device.port_inertia)), -g(0, 0),
                 1, 0};
  if (!device.collocated()) {
    r.blocked = g(1, 0);
    r.sensor_path = g(1, 1);
  }
  return r;
}

std::complex<long double> compute_law(const DiscreteStateSpace& law, long double angle) {
  return solve_long(law.A, law.B, law.C, Eigen::MatrixXd::Constant(1, 1, law.D),
                    std::polar<Long>(1, angle))(0, 0);
}

HeldEnclosure::HeldEnclosure(const HeldDevice& device)
    : collocated_(device.collocated()), A_(device.system.A), D_(device.system.D) {
  if (A_.rows() == 0) {  // one state that nothing reaches, so that there always is one
    A_ = Eigen::MatrixXd::Constant(1, 1, -1);
    B_ = Eigen::MatrixXd::Zero(1, 2);
    C_ = Eigen::MatrixXd::Zero(D_.rows(), 1);
    shifted_A_ = A_;
    shifted_B_ = B_;
    return;
  }
  const Eigen::VectorXd scale = balance(A_);
  B_ = scale.cwiseInverse().asDiagonal() * device.system.B;
  C_ = device.system.C * scale.asDiagonal();
  shifted_A_ = A_;
  shifted_B_ = B_;
  // A pole at zero, moved to where its part of B, taken out, no longer reaches it.
  const Eigen::JacobiSVD<Eigen::MatrixXd> svd(A_, Eigen::ComputeFullU | Eigen::ComputeFullV);
  const Eigen::Index last = A_.rows() - 1;
  const double largest = svd.singularValues()(0);
  if (svd.singularValues()(last) > singular * largest) return;
  const Eigen::VectorXd right = svd.matrixV().col(last);
  const Eigen::VectorXd left = svd.matrixU().col(last);
  const double overlap = left.dot(right);
  if (std::abs(overlap) < 1e-9) return;  // defective: enclosed as it is, which may not succeed
  const Eigen::MatrixXd projector = right * left.transpose() / overlap;
  const Eigen::MatrixXd residue = C_ * projector * B_;
  const double size = residue.cwiseAbs().maxCoeff();
  Eigen::MatrixXd others = residue;
  others(0, 1) = 0;
  if (others.cwiseAbs().maxCoeff() > vanishing * size) return;  // not a spring at the port alone
  shifted_A_ -= largest * projector;
  shifted_B_ -= projector * B_;
}

double HeldEnclosure::fastest() const {
  return compute_poles(A_).cwiseAbs().maxCoeff();
}

HeldForms HeldEnclosure::at(double omega, double reach) const {
  const Eigen::Index n = A_.rows();
  const Eigen::MatrixXcd R =
      (Complex(0, omega) * Eigen::MatrixXcd::Identity(n, n) - shifted_A_.cast<Complex>()).inverse();
  const Eigen::MatrixXcd start = R * shifted_B_;
  const Eigen::MatrixXcd moved = R * start;
  const Eigen::MatrixXcd weight = C_ * R;
  const Neumann series(reach * R.cwiseAbs());
  const Eigen::MatrixXd bend =
      series.valid() ? Eigen::MatrixXd(weight.cwiseAbs() * series.solve(moved.cwiseAbs()))
                     : Eigen::MatrixXd::Constant(C_.rows(), 2, infinity);
  const Eigen::MatrixXcd middle = C_ * start + D_;
  const Eigen::MatrixXcd slope = Complex(0, -1) * (C_ * moved);
  const auto entry = [&](Eigen::Index row, Eigen::Index column) -> SlopeForm {
    return {middle(row, column),
            {slope(row, column), reach > 0 ? reach * bend(row, column) : 0},
            reach};
  };
  HeldForms forms{real_part(entry(0, 1)), -1.0 * entry(0, 0), SlopeForm::constant(0)};
  if (!collocated_) {
    forms.path = entry(1, 1) * forms.path;
    forms.blocked = entry(1, 0);
  }
  return forms;
}

// G/p^order of one entry, as a function of p; `middle` = (jI - p A)^-1.
SlopeForm HeldEnclosure::leading_form(const Entry& entry, const Eigen::MatrixXcd& middle, double p,
                                      double reach, int& order) const {
  const Eigen::MatrixXcd K = middle * A_.cast<Complex>();
  const Eigen::VectorXcd start = middle * entry.column.cast<Complex>();
  Eigen::RowVectorXd row = entry.row;
  order = 0;
  const double size = row.cwiseAbs().dot(entry.column.cwiseAbs());
  const double around = size / std::max(1e-300, A_.cwiseAbs().maxCoeff());
  if (std::abs(entry.direct) > vanishing * around) {
    const SlopeForm moving = enclose_moved<Eigen::MatrixXcd, Eigen::VectorXcd, Eigen::RowVectorXcd>(
        row.cast<Complex>(), K, start, reach);
    return SlopeForm::constant(entry.direct) + frequency_form(p, reach) * moving;
  }
  Complex turn = 1;
  for (order = 1; order < most_orders; ++order) {
    const double made_of = row.cwiseAbs().dot(entry.column.cwiseAbs());
    if (std::abs(row.dot(entry.column)) > vanishing * made_of) break;
    row = row * A_;
    turn *= Complex(0, -1);
  }
  return turn * enclose_moved<Eigen::MatrixXcd, Eigen::VectorXcd, Eigen::RowVectorXcd>(
                    row.cast<Complex>(), K, start, reach);
}

// Re Z / p^order, order even, over the band.
SlopeForm HeldEnclosure::damping_form(double low, double high, int& order) const {
  const Eigen::Index n = A_.rows();
  order = 0;
  const double direct = D_(0, 1);
  const double middle = (low * low + high * high) / 2;
  const double reach = (high * high - low * low) / 2;
  const Eigen::MatrixXd A2 = A_ * A_;
  const Eigen::MatrixXd N = (Eigen::MatrixXd::Identity(n, n) + middle * A2).inverse();
  const Eigen::VectorXd column = B_.col(1);
  const Eigen::MatrixXd K = -(N * A2);
  const Eigen::VectorXd start = N * column;
  Eigen::RowVectorXd row = C_.row(0);
  const double around =
      row.cwiseAbs().dot(column.cwiseAbs()) / std::max(1e-300, A_.cwiseAbs().maxCoeff());
  row = row * A_;
  if (std::abs(direct) > vanishing * around) {
    return SlopeForm::constant(direct) -
           frequency_form(middle, reach) *
               enclose_moved<Eigen::MatrixXd, Eigen::VectorXd, Eigen::RowVectorXd>(row, K, start,
                                                                                   reach);
  }
  double sign = -1;
  for (order = 2; order < 2 * most_orders; order += 2) {
    const double made_of = row.cwiseAbs().dot(column.cwiseAbs());
    if (std::abs(row.dot(column)) > vanishing * made_of) break;
    row = row * A2;
    sign = -sign;
  }
  return sign *
         enclose_moved<Eigen::MatrixXd, Eigen::VectorXd, Eigen::RowVectorXd>(row, K, start, reach);
}

HeldBand HeldEnclosure::at_inverse(double low, double high) const {
  const Eigen::Index n = A_.rows();
  const double p = (low + high) / 2;
  const double reach = (high - low) / 2;
  const Eigen::MatrixXcd middle =
      (Complex(0, 1) * Eigen::MatrixXcd::Identity(n, n) - p * A_.cast<Complex>()).inverse();
  const auto entry = [&](Eigen::Index row, Eigen::Index column) -> Entry {
    return {C_.row(row), B_.col(column), D_(row, column)};
  };
  int order_path = 0;
  int order_damping = 0;
  SlopeForm path = -1.0 * leading_form(entry(0, 0), middle, p, reach, order_path);
  Disc blocked;
  if (!collocated_) {
    int order_sensor = 0;
    path = path * leading_form(entry(1, 1), middle, p, reach, order_sensor);
    order_path += order_sensor;
    int order_blocked = 0;
    const SlopeForm form = leading_form(entry(1, 0), middle, p, reach, order_blocked);
    const double least = std::pow(low, order_blocked);
    const double most = std::pow(high, order_blocked);
    blocked = form.range() * Disc{(least + most) / 2, (most - least) / 2};
  }
  const SlopeForm damping = damping_form(low, high, order_damping);
  const int order = order_path - order_damping;
  const double floor = lowest(damping);
  if (!(floor > 0) || (order < 0 && low == 0)) return {{0, infinity}, 0, infinity};
  const double least = std::min(std::pow(low, order), std::pow(high, order));
  const double most = std::max(std::pow(low, order), std::pow(high, order));
  const double ceiling = highest(damping);
  const Disc inverse{(1 / floor + 1 / ceiling) / 4, (1 / floor - 1 / ceiling) / 4};
  const Disc weighted = path.range() * inverse * Disc{(least + most) / 2, (most - least) / 2};
  const Disc size = path.range();
  return {blocked + weighted, size.least() / (2 * ceiling) * least,
          size.largest() / (2 * floor) * most};
}

SlopeForm enclose_law(const DiscreteStateSpace& law, double period, double omega, double reach) {
  if (law.states() == 0) return SlopeForm::constant(law.D);
  const Complex z = std::polar(1.0, omega * period);
  const Eigen::Index n = law.states();
  const Eigen::MatrixXcd R =
      (z * Eigen::MatrixXcd::Identity(n, n) - law.A.cast<Complex>()).inverse();
  const Eigen::VectorXcd start = R * law.B;
  const Eigen::VectorXcd moved = R * start;
  const Eigen::RowVectorXcd weight = law.C * R;
  const double shift = period * reach;  // |z - z0| at most
  const Neumann series(shift * R.cwiseAbs());
  const double bend =
      series.valid() ? weight.cwiseAbs().dot(series.solve(moved.cwiseAbs()).col(0)) : infinity;
  const Disc turning{Complex(0, period) * z, period * period * reach / 2};  // (z - z0)/t
  const Disc per_z{-(law.C * moved).value(), reach > 0 ? shift * bend : 0};
  return {(law.C * start).value() + law.D, turning * per_z, reach};
}

}  // namespace gyrator
