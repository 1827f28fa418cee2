#include "gyrator/two_port/virtual_impedance.hpp"

#include <algorithm>
#include <cmath>

namespace gyrator {
namespace {

using Complex = std::complex<double>;

// Largest root of a z^2 + b z + c.
double largest_root(double a, double b, double c) {
  if (a == 0) return b == 0 ? 0 : std::abs(c / b);
  const Complex root = std::sqrt(Complex(b * b - 4 * a * c));
  return std::max(std::abs((-b + root) / (2 * a)), std::abs((-b - root) / (2 * a)));
}

}  // namespace

VirtualElements::VirtualElements(double omega, double step, Integration integration) {
  if (step == 0) {
    rate_ = Complex(0, omega);
    integral_ = 1.0 / rate_;
    return;
  }
  const double half = omega * step / 2;
  // (z - 1)/h = 2j sin(wh/2) e^(+-jwh/2)/h, and h/(z - 1), h z/(z - 1) = h (-+1 - j cot(wh/2))/2
  const double sign = integration == Integration::explicit_euler ? 1 : -1;
  rate_ = Complex(0, 2 * std::sin(half) / step) * std::polar(1.0, sign * half);
  integral_ = Complex(-sign, -std::cos(half) / std::sin(half)) * (step / 2);
}

double compute_virtual_radius(double inertia, const SpringDamper& to_ground, double step,
                              Integration integration) {
  const double m = inertia;
  const double c = to_ground.damping * step;
  const double k = to_ground.stiffness * step * step;
  // Spring and damper alone: c (z - 1) + k h or c (z - 1) + k h z.
  if (m == 0) {
    return integration == Integration::explicit_euler ? largest_root(0, c, k - c)
                                                      : largest_root(0, c + k, -c);
  }
  switch (integration) {
    case Integration::explicit_euler:
      return largest_root(m, c - 2 * m, m - c + k);
    case Integration::semi_implicit:
      return largest_root(m, c + k - 2 * m, m - c);
    case Integration::implicit:
      break;
  }
  return largest_root(m + c + k, -c - 2 * m, m);
}

}  // namespace gyrator
