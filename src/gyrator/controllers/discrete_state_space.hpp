#pragma once

#include <complex>

#include <Eigen/Dense>

namespace gyrator {

/// A linear discrete law with one input and one output,
///   q[k+1] = A q[k] + B y[k],   out[k] = C q[k] + D y[k],                        (dss-1)
/// from which both the running law (`step`) and its frequency response (`response`) come.
struct DiscreteStateSpace {
  Eigen::MatrixXd A;
  Eigen::VectorXd B;
  Eigen::RowVectorXd C;
  double D = 0;

  Eigen::Index states() const { return A.rows(); }

  /// H(z) = C (zI - A)^-1 B + D.
  std::complex<double> response(std::complex<double> z) const;

  /// The state in which a constant input y has settled, (I - A)^-1 B y. The law must have one.
  Eigen::VectorXd settled_state(double y) const;
};

/// gain * law
DiscreteStateSpace scaled(DiscreteStateSpace law, double gain);
/// a + b, side by side on the same input
DiscreteStateSpace in_parallel(const DiscreteStateSpace& a, const DiscreteStateSpace& b);
/// The second on the output of the first
DiscreteStateSpace in_series(const DiscreteStateSpace& first, const DiscreteStateSpace& second);
/// A constant gain, without states
DiscreteStateSpace make_gain(double gain);

/// Running state of a DiscreteStateSpace; allocates only when constructed.
class DiscreteLawState {
 public:
  explicit DiscreteLawState(const DiscreteStateSpace& law)
      : q_(Eigen::VectorXd::Zero(law.states())), next_(Eigen::VectorXd::Zero(law.states())) {}

  /// As if the input had been y for ever.
  void settle(const DiscreteStateSpace& law, double y) { q_ = law.settled_state(y); }
  /// The same with the law's settled_state(1), found beforehand: allocates nothing.
  void settle(const Eigen::VectorXd& settled_at_one, double y) { q_ = y * settled_at_one; }

  /// Output for the input y, and advance by one sample.
  double step(const DiscreteStateSpace& law, double y) {
    const Eigen::Index n = q_.size();
    double out = law.D * y;
    for (Eigen::Index i = 0; i < n; ++i) {
      out += law.C(i) * q_(i);
      double sum = law.B(i) * y;
      for (Eigen::Index j = 0; j < n; ++j) sum += law.A(i, j) * q_(j);
      next_(i) = sum;
    }
    q_.swap(next_);
    return out;
  }

 private:
  Eigen::VectorXd q_, next_;
};

}  // namespace gyrator
