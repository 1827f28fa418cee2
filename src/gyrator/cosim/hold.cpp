#include "gyrator/cosim/hold.hpp"

#include <cmath>

namespace gyrator {

std::complex<double> compute_normalized_hold(double omega, double period) {
  const double half = omega * period / 2;
  if (half == 0) return 1;
  return std::polar(std::sin(half) / half, -half);
}

}  // namespace gyrator
