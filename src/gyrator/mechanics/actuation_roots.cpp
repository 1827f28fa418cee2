#include "gyrator/mechanics/actuation_roots.hpp"

#include "gyrator/circuits/state_space.hpp"
#include "gyrator/mechanics/plant.hpp"

#include <algorithm>
#include <cmath>

#include <Eigen/Eigenvalues>

namespace gyrator {
namespace {

using Complex = std::complex<double>;
using Eigen::MatrixXd;

constexpr double cancels = 1e-7;       // of the larger of the two: eigenvalues are no better known
constexpr double farthest_zero = 1e3;  // times the fastest pole: beyond it a zero is at infinity

// Where the pencil [A - sI, b; c, d] loses rank: the transmission zeros (Rosenbrock 1970).
std::vector<Complex> find_zeros(const MatrixXd& A, const Eigen::VectorXd& b,
                                const Eigen::RowVectorXd& c, double d, double fastest) {
  const Eigen::Index n = A.rows();
  MatrixXd system(n + 1, n + 1);
  system << A, b, c, Eigen::MatrixXd::Constant(1, 1, d);
  MatrixXd unit = MatrixXd::Zero(n + 1, n + 1);
  unit.topLeftCorner(n, n).setIdentity();
  const Eigen::GeneralizedEigenSolver<MatrixXd> solver(system, unit, false);
  std::vector<Complex> zeros;
  for (Eigen::Index i = 0; i <= n; ++i) {
    const Complex alpha = solver.alphas()(i);
    const double beta = solver.betas()(i);
    if (std::abs(alpha) < farthest_zero * fastest * std::abs(beta)) zeros.push_back(alpha / beta);
  }
  return zeros;
}

void drop_cancelling(ActuationRoots& roots, double fastest) {
  auto& poles = roots.poles;
  std::erase_if(roots.zeros, [&](Complex zero) {
    const auto near = std::min_element(poles.begin(), poles.end(), [&](Complex a, Complex b) {
      return std::abs(a - zero) < std::abs(b - zero);
    });
    if (near == poles.end()) return false;
    const double size = std::max({std::abs(*near), std::abs(zero), 1e-9 * fastest});
    if (std::abs(*near - zero) > cancels * size) return false;
    poles.erase(near);
    return true;
  });
}

}  // namespace

ActuationRoots find_actuation_roots(const Device& device) {
  Device blocked = device;
  blocked.mechanics.transmission.reset();
  blocked.sensor = SensorLocation::port;
  blocked.sensor_filter.reset();
  const Plant plant =
      build_plant(build_device_network(blocked, ClampedOperator{}, find_amplifier_gain(device)));
  ActuationRoots roots;
  if (plant.states() == 0) return roots;
  // Balanced, so that the pencil's entries are of one size.
  MatrixXd A = plant.A;
  const Eigen::VectorXd scale = balance(A);
  const Eigen::VectorXd b = plant.B.col(0).cwiseQuotient(scale);
  const Eigen::RowVectorXd c = plant.port_effort.state.cwiseProduct(scale.transpose());
  const Eigen::VectorXcd poles = compute_poles(A);
  const double fastest = poles.cwiseAbs().maxCoeff();
  const double size_b = b.norm();
  const double size_c = c.norm();
  if (!(size_b > 0) || !(size_c > 0) || !(fastest > 0)) return roots;  // nothing between, A_0 = 1
  roots.poles.assign(poles.begin(), poles.end());
  // Time in units of the fastest pole, input and output in units of their rows.
  roots.zeros = find_zeros(A / fastest, b / size_b, c / size_c,
                           plant.port_effort.input(0) * fastest / (size_b * size_c), 1);
  for (auto& zero : roots.zeros) zero *= fastest;
  drop_cancelling(roots, fastest);
  return roots;
}

}  // namespace gyrator
