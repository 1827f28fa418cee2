#include "gyrator/robustness/divided_model.hpp"

#include "gyrator/passivity/port_taylor.hpp"

#include <cmath>

namespace gyrator {
namespace {

using Complex = std::complex<double>;

double factorial(int k) {
  return std::tgamma(k + 1.0);
}

// phi_0 = e^z, phi_k = (phi_(k-1) - 1/(k-1)!)/z: integral of e^((1-t)z) t^(k-1)/(k-1)! over t from
// 0 to 1.
Complex phi(int k, Complex z) {
  if (std::abs(z) < 1) {
    Complex term = 1 / factorial(k);
    Complex sum = term;
    for (int n = 1; n < 24; ++n) {
      term *= z / static_cast<double>(n + k);
      sum += term;
    }
    return sum;
  }
  Complex value = std::exp(z);
  for (int n = 1; n <= k; ++n) value = (value - 1 / factorial(n - 1)) / z;
  return value;
}

// phi_k(-s time); d/dz phi_k = phi_k - k phi_(k+1), and half the second derivative is at most
// 1/(k + 2)! on the imaginary axis.
BoxModel expand_phi(int k, const Band& band, double time) {
  const Complex z(0, -band.omega * time);
  const double change = band.reach * time;
  BoxModel model;
  model.value = phi(k, z);
  model.slopes[0] = Complex(0, -change) * (model.value - static_cast<double>(k) * phi(k + 1, z));
  model.remainder = change * change / factorial(k + 2);
  return model;
}

}  // namespace

BoxModel Band::s() const {
  BoxModel model = constant_box(Complex(0, omega));
  model.slopes[0] = Complex(0, reach);
  return model;
}

DividedModel expand_turn(const Band& band, double time) {
  return {expand_phi(0, band, time), constant_box(1), constant_box(-time),
          Complex(-time) * expand_phi(1, band, time),
          Complex(time * time) * expand_phi(2, band, time)};
}

DividedModel expand_hold(const Band& band, double period) {
  return {expand_phi(1, band, period), constant_box(1), constant_box(-period / 2),
          Complex(-period) * expand_phi(2, band, period),
          Complex(period * period) * expand_phi(3, band, period)};
}

// H(z) - H(1) = -(z - 1) C (zI - A)^-1 (I - A)^-1 B, and (z - 1)/s = T z hold(s).
DividedModel expand_law_divided(const DiscreteStateSpace& law, double period, const Band& band) {
  const auto expand = [&](const DiscreteStateSpace& part) {
    return box_of(expand_law(part, period, band.omega, band.reach));
  };
  DividedModel h{expand(law), constant_box(law.D), constant_box(0), constant_box(0),
                 constant_box(0)};
  if (law.states() == 0) return h;
  const Eigen::Index n = law.states();
  const Eigen::PartialPivLU<Eigen::MatrixXd> steady(Eigen::MatrixXd::Identity(n, n) - law.A);
  DiscreteStateSpace once{law.A, steady.solve(law.B), law.C, 0};
  DiscreteStateSpace twice{law.A, steady.solve(once.B), law.C, 0};
  const double at_one = law.C.dot(once.B);
  const double once_at_one = law.C.dot(twice.B);
  h.c0 = constant_box(law.D + at_one);
  // q1 = -step once(z),  step = T z hold = (z - 1)/s
  const DividedModel ahead = expand_turn(band, -period);
  const DividedModel step = ahead * expand_hold(band, period);
  const BoxModel difference = Complex(-period) * (step.f * expand(twice));  // of once, over s
  h.q1 = Complex(-period) * (step.f * expand(once));
  h.c1 = constant_box(-period * once_at_one);
  // step - 1 over s, then once - once(1) over s
  h.q2 = Complex(-period) * (step.q1 * expand(once) + difference);
  return h;
}

}  // namespace gyrator
