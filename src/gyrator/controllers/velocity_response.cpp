#include "gyrator/controllers/velocity_response.hpp"

#include <cmath>
#include <numbers>

namespace gyrator {

std::vector<VelocityResponse> compute_velocity_response(const VelocityEstimator& estimator,
                                                        double period,
                                                        const std::vector<double>& frequency_hz) {
  const DiscreteStateSpace law = make_velocity_law(estimator, period);
  std::vector<VelocityResponse> responses;
  for (const double f : frequency_hz) {
    const double omega = 2 * std::numbers::pi * f;
    VelocityResponse r;
    r.frequency_hz = f;
    r.value = law.response(std::polar(1.0, omega * period));
    r.ratio = r.value / std::complex<double>(0, omega);
    r.delay_s = -std::arg(r.ratio) / omega;
    responses.push_back(r);
  }
  return responses;
}

double compute_velocity_delay(const VelocityEstimator& estimator, double period) {
  // V = sum h[k] z^-k with sum h = 0 and sum k h = -1/T: of a parabola y = (k T)^2/2 the estimate
  // is k T - delay, so that delay = -T^2/2 sum k^2 h, the law's second derivative at z = 1.
  const DiscreteStateSpace law = make_velocity_law(estimator, period);
  const Eigen::MatrixXd pencil = Eigen::MatrixXd::Identity(law.states(), law.states()) - law.A;
  const auto lu = pencil.partialPivLu();
  // sum k h = C R^2 B and sum k^2 h = C (2 R^3 - R^2) B with R = (I - A)^-1, h[k] = C A^(k-1) B.
  const Eigen::VectorXd twice = lu.solve(lu.solve(law.B).eval());
  const Eigen::VectorXd thrice = lu.solve(twice);
  return -period * period / 2 * law.C.dot(2 * thrice - twice);
}

double compute_velocity_noise_gain(const VelocityEstimator& estimator, double period) {
  const DiscreteStateSpace law = make_velocity_law(estimator, period);
  // sum h^2 = D^2 + C P C', P = sum A^k B B' A'^k, whose number of terms doubles every round.
  Eigen::MatrixXd power = law.A;
  Eigen::MatrixXd sum = law.B * law.B.transpose();
  for (int round = 0; round < 60; ++round) {
    const Eigen::MatrixXd added = power * sum * power.transpose();
    sum += added;
    if (added.norm() <= 1e-16 * sum.norm()) break;
    power = (power * power).eval();
  }
  return std::sqrt(law.D * law.D + law.C * sum * law.C.transpose());
}

}  // namespace gyrator
