#pragma once

#include <cmath>
#include <complex>

namespace gyrator {

// Complex arithmetic for inner loops whose operands are finite and far from overflow: without the
// C99 rules for infinities and the scaling of hypot, which cost several times the operation.

inline std::complex<double> plain_product(std::complex<double> a, std::complex<double> b) {
  return {a.real() * b.real() - a.imag() * b.imag(), a.real() * b.imag() + a.imag() * b.real()};
}

inline std::complex<double> plain_reciprocal(std::complex<double> a) {
  const double scale = 1 / (a.real() * a.real() + a.imag() * a.imag());
  return {a.real() * scale, -a.imag() * scale};
}

inline double plain_abs(std::complex<double> a) {
  return std::sqrt(a.real() * a.real() + a.imag() * a.imag());
}

}  // namespace gyrator
