#include "gyrator/controllers/discrete_state_space.hpp"

namespace gyrator {

std::complex<double> DiscreteStateSpace::response(std::complex<double> z) const {
  if (states() == 0) return D;
  if (states() == 1) return C(0) * B(0) / (z - A(0, 0)) + D;
  const Eigen::MatrixXcd pencil =
      z * Eigen::MatrixXcd::Identity(states(), states()) - A.cast<std::complex<double>>();
  const Eigen::VectorXcd q = pencil.partialPivLu().solve(B.cast<std::complex<double>>());
  return (C.cast<std::complex<double>>() * q)(0) + D;
}

Eigen::VectorXd DiscreteStateSpace::settled_state(double y) const {
  if (states() == 0) return {};
  const Eigen::MatrixXd pencil = Eigen::MatrixXd::Identity(states(), states()) - A;
  return pencil.partialPivLu().solve(B * y);
}

DiscreteStateSpace scaled(DiscreteStateSpace law, double gain) {
  law.C *= gain;
  law.D *= gain;
  return law;
}

DiscreteStateSpace in_parallel(const DiscreteStateSpace& a, const DiscreteStateSpace& b) {
  DiscreteStateSpace sum;
  sum.A = Eigen::MatrixXd::Zero(a.states() + b.states(), a.states() + b.states());
  sum.A.topLeftCorner(a.states(), a.states()) = a.A;
  sum.A.bottomRightCorner(b.states(), b.states()) = b.A;
  sum.B.resize(sum.A.rows());
  sum.B << a.B, b.B;
  sum.C.resize(sum.A.rows());
  sum.C << a.C, b.C;
  sum.D = a.D + b.D;
  return sum;
}

DiscreteStateSpace in_series(const DiscreteStateSpace& first, const DiscreteStateSpace& second) {
  const Eigen::Index a = first.states();
  const Eigen::Index b = second.states();
  DiscreteStateSpace both;
  both.A = Eigen::MatrixXd::Zero(a + b, a + b);
  both.A.topLeftCorner(a, a) = first.A;
  both.A.bottomLeftCorner(b, a) = second.B * first.C;
  both.A.bottomRightCorner(b, b) = second.A;
  both.B.resize(a + b);
  both.B << first.B, second.B * first.D;
  both.C.resize(a + b);
  both.C << second.D * first.C, second.C;
  both.D = second.D * first.D;
  return both;
}

DiscreteStateSpace make_gain(double gain) {
  return {Eigen::MatrixXd(0, 0), Eigen::VectorXd(0), Eigen::RowVectorXd(0), gain};
}

}  // namespace gyrator
