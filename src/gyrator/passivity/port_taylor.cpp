#include "gyrator/passivity/port_taylor.hpp"

#include <array>

namespace gyrator {
namespace {

using Complex = std::complex<double>;
constexpr double infinity = std::numeric_limits<double>::infinity();

// Sum over modes of an entry whose residues are real or come in conjugate pairs.
std::array<TaylorModel, 4> expand_modes(const ModalResponse& modes, std::size_t entries,
                                        double omega, double reach) {
  std::array<TaylorModel, 4> sums;
  for (std::size_t k = 0; k < entries; ++k) sums[k] = constant_model(modes.feedthrough(k), reach);
  for (std::size_t i = 0; i < modes.poles().size(); ++i) {
    const Complex u = plain_reciprocal(Complex(0, omega) - modes.poles()[i]);
    const double size = plain_abs(u);
    const double near = 1 - size * reach;
    const double curvature = near > 0 ? size * size * size / near : infinity;
    const Complex slope = Complex(0, -1) * plain_product(u, u);
    for (std::size_t k = 0; k < entries; ++k) {
      const Complex r = modes.residue(i, k);
      if (r == 0.0) continue;
      sums[k].value += plain_product(r, u);
      sums[k].slope += plain_product(r, slope);
      sums[k].curvature += plain_abs(r) * curvature;
    }
  }
  return sums;
}

}  // namespace

std::vector<TaylorModel> expand_response(const StateSpace& system, Complex s, Complex turn,
                                         double bend, double speed, double reach) {
  const Eigen::Index n = system.A.rows();
  std::vector<TaylorModel> entries;
  Eigen::MatrixXcd value = system.D.cast<Complex>();
  Eigen::MatrixXcd first = Eigen::MatrixXcd::Zero(value.rows(), value.cols());
  Eigen::MatrixXd second = Eigen::MatrixXd::Zero(value.rows(), value.cols());
  if (n > 0) {
    const Eigen::MatrixXcd R =
        (s * Eigen::MatrixXcd::Identity(n, n) - system.A.cast<Complex>()).partialPivLu().inverse();
    const Eigen::MatrixXcd by_input = R * system.B;
    const Eigen::MatrixXcd to_output = system.C * R;
    value += to_output * system.B;
    first = -to_output * by_input;
    // (I - |d| |R|)^-1 exists with entries >= 0 where some w >= 1 has w - |d| |R| w = 1.
    const Eigen::MatrixXd left = Eigen::MatrixXd::Identity(n, n) - speed * reach * R.cwiseAbs();
    const Eigen::PartialPivLU<Eigen::MatrixXd> inverse(left);
    const Eigen::VectorXd w = inverse.solve(Eigen::VectorXd::Ones(n));
    if (w.allFinite() && w.minCoeff() >= 1 - 1e-9) {
      second = (to_output * R).cwiseAbs() * inverse.solve(by_input.cwiseAbs());
    } else {
      second.setConstant(infinity);
    }
  }
  for (Eigen::Index r = 0; r < value.rows(); ++r) {
    for (Eigen::Index c = 0; c < value.cols(); ++c) {
      entries.push_back({value(r, c), turn * first(r, c),
                         bend * std::abs(first(r, c)) + speed * speed * second(r, c), reach});
    }
  }
  return entries;
}

PortTaylor expand_port(PortModel& model, double omega, double reach) {
  const bool collocated = model.collocated();
  std::array<TaylorModel, 4> y;
  if (const auto& modes = model.modes()) {
    y = expand_modes(*modes, collocated ? 2 : 4, omega, reach);
    if (omega > modes->highest()) {  // where the modes' own sum has lost digits
      const PortResponse direct = model.at(omega);
      y[0].value = -direct.actuation;
      y[1].value = direct.impedance.real();
      y[2].value = direct.blocked_motion;
      y[3].value = direct.sensor_path;
    }
  } else {
    const auto entries =
        expand_response(model.blocked().system, Complex(0, omega), Complex(0, 1), 0, 1, reach);
    std::copy(entries.begin(), entries.end(), y.begin());
  }
  const TaylorModel actuation = Complex(-1) * y[0];
  // The port's inertia adds to Im Z alone.
  if (collocated) return {real_part(y[1]), actuation, constant_model(0, reach)};
  return {real_part(y[1]), y[3] * actuation,
          model.sees_no_command() ? constant_model(0, reach) : y[2]};
}

TaylorModel expand_law(const DiscreteStateSpace& law, double period, double omega, double reach) {
  const Complex z = std::polar(1.0, omega * period);
  const StateSpace system{law.A, law.B, law.C, Eigen::MatrixXd::Constant(1, 1, law.D)};
  // z e^(jTt) = z + jTz t + …, the rest at most T^2 t^2/2; a chord is no longer than its arc.
  return expand_response(system, z, Complex(0, period) * z, period * period / 2, period, reach)
      .front();
}

}  // namespace gyrator
