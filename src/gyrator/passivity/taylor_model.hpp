#pragma once

#include "gyrator/core/plain_complex.hpp"

#include <algorithm>
#include <complex>
#include <limits>

namespace gyrator {

/// A complex function of one real variable about a point, known to first order with a bound on all
/// the rest:
///   |q(t) - value - slope t| <= curvature t^2     for |t| <= reach                 (taylor-1)
/// Sums, products and quotients of such models are such models again, so that whatever is built
/// from them is bounded over a whole interval by what is known at its middle. An infinite
/// curvature says that nothing is known: the interval is too wide. Both operands of an operation
/// have the same reach. (Rounding is not part of the bound.)
struct TaylorModel {
  std::complex<double> value, slope;
  double curvature = 0;
  double reach = 0;

  /// A bound on |slope t| + curvature t^2 over the reach.
  double deviation() const { return (plain_abs(slope) + curvature * reach) * reach; }
  /// Re q is nowhere in the reach below this.
  double lowest_real() const {
    return value.real() - (std::abs(slope.real()) + curvature * reach) * reach;
  }
};

inline TaylorModel constant_model(std::complex<double> value, double reach) {
  return {value, 0, 0, reach};
}

inline TaylorModel operator+(const TaylorModel& a, const TaylorModel& b) {
  return {a.value + b.value, a.slope + b.slope, a.curvature + b.curvature, a.reach};
}
inline TaylorModel operator-(const TaylorModel& a, const TaylorModel& b) {
  return {a.value - b.value, a.slope - b.slope, a.curvature + b.curvature, a.reach};
}
inline TaylorModel operator+(const TaylorModel& a, std::complex<double> constant) {
  return {a.value + constant, a.slope, a.curvature, a.reach};
}
inline TaylorModel operator*(std::complex<double> factor, const TaylorModel& a) {
  return {plain_product(factor, a.value), plain_product(factor, a.slope),
          plain_abs(factor) * a.curvature, a.reach};
}

inline TaylorModel operator*(const TaylorModel& a, const TaylorModel& b) {
  const double h = a.reach;
  const double slope_a = plain_abs(a.slope);
  const double slope_b = plain_abs(b.slope);
  return {plain_product(a.value, b.value),
          plain_product(a.value, b.slope) + plain_product(a.slope, b.value),
          plain_abs(a.value) * b.curvature + plain_abs(b.value) * a.curvature + slope_a * slope_b +
              h * (slope_a * b.curvature + slope_b * a.curvature) +
              h * h * a.curvature * b.curvature,
          h};
}

inline TaylorModel conj(const TaylorModel& a) {
  return {std::conj(a.value), std::conj(a.slope), a.curvature, a.reach};
}
/// Re q and Im q, as models with real parts only.
inline TaylorModel real_part(const TaylorModel& a) {
  return {a.value.real(), a.slope.real(), a.curvature, a.reach};
}
inline TaylorModel imaginary_part(const TaylorModel& a) {
  return {a.value.imag(), a.slope.imag(), a.curvature, a.reach};
}

/// 1/q; knows nothing where q could be zero.
inline TaylorModel reciprocal(const TaylorModel& a) {
  const std::complex<double> inverse = plain_reciprocal(a.value);
  const double size = plain_abs(inverse);
  const double relative_slope = plain_abs(a.slope) * size;
  const double d = a.deviation() * size;
  if (!(d < 1)) {
    return {inverse, 0, std::numeric_limits<double>::infinity(), a.reach};
  }
  // 1/(1 + x) = 1 - x + x^2/(1 + x) with |x| <= (relative_slope + relative curvature t) t <= d
  const double relative = relative_slope + a.curvature * size * a.reach;
  return {inverse, -plain_product(plain_product(inverse, inverse), a.slope),
          size * (a.curvature * size + relative * relative / (1 - d)), a.reach};
}

/// q/(j w) at w = omega + t, for a q that is itself small there: without the loss of multiplying
/// by 1/(jw), q - (first order) (jw) is all that is left over.
inline TaylorModel over_j_omega(const TaylorModel& a, double omega) {
  const std::complex<double> s(0, omega);
  const std::complex<double> value = a.value / s;
  const std::complex<double> slope = (a.slope - std::complex<double>(0, 1) * value) / s;
  const double least = omega - a.reach;
  if (!(least > 0)) return {value, slope, std::numeric_limits<double>::infinity(), a.reach};
  return {value, slope, (a.curvature + plain_abs(slope)) / least, a.reach};
}

/// A real function that is nowhere below |q|:
///   |q| <= (a + |q|^2/a)/2 for every a > 0, a near |q|.                               (taylor-2)
inline TaylorModel majorant(const TaylorModel& q) {
  const double size = plain_abs(q.value);
  const double slope = plain_abs(q.slope);
  const double a = std::max(size, slope * q.reach);
  if (a == 0) return {0, 0, q.curvature, q.reach};
  const double along = q.value.real() * q.slope.real() + q.value.imag() * q.slope.imag();
  return {(a + size * size / a) / 2, along / a, slope * slope / (2 * a) + q.curvature, q.reach};
}

}  // namespace gyrator
