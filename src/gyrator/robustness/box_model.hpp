#pragma once

#include "gyrator/core/plain_complex.hpp"
#include "gyrator/passivity/taylor_model.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <complex>
#include <limits>

namespace gyrator {

/// A complex function of several real variables d_0 … d_(n-1), |d_i| <= 1, known to first order
/// with a bound on all the rest:
///   |q(d) - value - sum_i slopes_i d_i| <= remainder                                    (box-1)
/// d_0 is the place in an interval of frequencies, the others those in the ranges of parts. Sums,
/// products and quotients of such models are such models again. An infinite remainder says that
/// nothing is known. (Rounding is not part of the bound.)
struct BoxModel {
  static constexpr std::size_t most_variables = 16;
  std::complex<double> value;
  std::array<std::complex<double>, most_variables> slopes{};  ///< zero from `variables` on
  std::size_t variables = 1;
  double remainder = 0;

  /// A bound on the sum of |slopes_i d_i|.
  double spread() const {
    double sum = 0;
    for (std::size_t i = 0; i < variables; ++i) sum += plain_abs(slopes[i]);
    return sum;
  }
  /// Re q is nowhere in the box below this.
  double lowest_real() const {
    double sum = value.real() - remainder;
    for (std::size_t i = 0; i < variables; ++i) sum -= std::abs(slopes[i].real());
    return sum;
  }
  /// |q| is nowhere in the box above this.
  double highest_size() const { return plain_abs(value) + spread() + remainder; }
};

/// A bound that was computed: not below zero by rounding, and infinite where it is not a number.
inline double as_remainder(double bound) {
  return std::isnan(bound) ? std::numeric_limits<double>::infinity() : std::max(bound, 0.0);
}

inline BoxModel constant_box(std::complex<double> value) {
  BoxModel model;
  model.value = value;
  return model;
}
/// A function of frequency alone.
inline BoxModel box_of(const TaylorModel& q) {
  BoxModel model;
  model.value = q.value;
  model.slopes[0] = q.slope * q.reach;
  model.remainder = q.curvature * q.reach * q.reach;
  return model;
}

/// Every coefficient's image under a linear map that makes nothing larger by more than `factor`.
template <class Map>
BoxModel map_linearly(const BoxModel& a, const Map& map, double factor = 1) {
  BoxModel result;
  result.variables = a.variables;
  result.value = map(a.value);
  for (std::size_t i = 0; i < a.variables; ++i) result.slopes[i] = map(a.slopes[i]);
  result.remainder = factor * a.remainder;
  return result;
}

inline BoxModel operator+(BoxModel a, const BoxModel& b) {
  a.variables = std::max(a.variables, b.variables);
  a.value += b.value;
  for (std::size_t i = 0; i < b.variables; ++i) a.slopes[i] += b.slopes[i];
  a.remainder += b.remainder;
  return a;
}
inline BoxModel operator*(std::complex<double> factor, const BoxModel& a) {
  return map_linearly(
      a, [&](std::complex<double> q) { return plain_product(factor, q); }, plain_abs(factor));
}
inline BoxModel operator-(const BoxModel& a, const BoxModel& b) {
  return a + std::complex<double>(-1) * b;
}
inline BoxModel operator*(const BoxModel& a, const BoxModel& b) {
  BoxModel result;
  result.variables = std::max(a.variables, b.variables);
  result.value = plain_product(a.value, b.value);
  for (std::size_t i = 0; i < result.variables; ++i) {
    result.slopes[i] = plain_product(a.value, b.slopes[i]) + plain_product(a.slopes[i], b.value);
  }
  const double spread_a = a.spread();
  const double spread_b = b.spread();
  result.remainder = plain_abs(a.value) * b.remainder + plain_abs(b.value) * a.remainder +
                     (spread_a + a.remainder) * (spread_b + b.remainder);
  return result;
}

inline BoxModel conj(const BoxModel& a) {
  return map_linearly(a, [](std::complex<double> q) { return std::conj(q); });
}
inline BoxModel real_part(const BoxModel& a) {
  return map_linearly(a, [](std::complex<double> q) { return std::complex<double>(q.real()); });
}
inline BoxModel imaginary_part(const BoxModel& a) {
  return map_linearly(a, [](std::complex<double> q) { return std::complex<double>(q.imag()); });
}

/// |q|^2, as a model with real parts only.
inline BoxModel square_size(const BoxModel& a) {
  BoxModel result;
  result.variables = a.variables;
  result.value = std::norm(a.value);
  for (std::size_t i = 0; i < a.variables; ++i)
    result.slopes[i] = 2 * (std::conj(a.value) * a.slopes[i]).real();
  const double change = a.spread() + a.remainder;
  result.remainder = 2 * plain_abs(a.value) * a.remainder + change * change;
  return result;
}

/// 1/q; knows nothing where q could be zero.
inline BoxModel reciprocal(const BoxModel& a) {
  const std::complex<double> inverse = plain_reciprocal(a.value);
  const double size = plain_abs(inverse);
  const double d = (a.spread() + a.remainder) * size;
  if (!(d < 1)) {
    BoxModel unknown = constant_box(inverse);
    unknown.remainder = std::numeric_limits<double>::infinity();
    return unknown;
  }
  // 1/(1 + x) = 1 - x + x^2/(1 + x)
  BoxModel result = -plain_product(inverse, inverse) * a;
  result.value = inverse;
  result.remainder = size * (a.remainder * size + d * d / (1 - d));
  return result;
}

/// A real function that is nowhere below |q|: |l| <= (a + |l|^2/a)/2 for every a > 0, l the part of
/// q without its remainder.                                                             (box-2)
inline BoxModel majorant(const BoxModel& q) {
  const double size = plain_abs(q.value);
  const double spread = q.spread();
  const double a = std::max(size, spread);
  BoxModel result;
  result.variables = q.variables;
  result.remainder = q.remainder;
  if (a == 0) return result;
  result.value = (a + size * size / a) / 2;
  for (std::size_t i = 0; i < q.variables; ++i)
    result.slopes[i] = (std::conj(q.value) * q.slopes[i]).real() / a;
  result.remainder += spread * spread / (2 * a);
  return result;
}

}  // namespace gyrator
