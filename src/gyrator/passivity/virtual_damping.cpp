#include "gyrator/passivity/virtual_damping.hpp"

#include <cmath>

namespace gyrator {

double compute_virtual_damping(double omega, double period, std::complex<double> law) {
  const double half = omega * period / 2;
  return period / (2 * std::sin(half)) * std::imag(std::polar(1.0, -half) * law);
}

}  // namespace gyrator
