#pragma once

#include <algorithm>
#include <complex>

namespace gyrator {

/// All complex numbers within `radius` of `middle`.
struct Disc {
  std::complex<double> middle;
  double radius = 0;

  double largest() const { return std::abs(middle) + radius; }
  double least() const { return std::max(0.0, std::abs(middle) - radius); }
};

Disc operator+(const Disc& a, const Disc& b);
Disc operator*(const Disc& a, const Disc& b);
/// 1/x; an infinite radius where the disc holds zero.
Disc invert(const Disc& x);

/// A complex function of a real variable on |t| <= reach, enclosed by a line through its value at
/// the middle whose slope is a disc (Krawczyk and Neumaier 1985):
///   x(t) = value + t sigma(t),   sigma(t) in slope for every t                        (slope-1)
/// Sums, products and quotients of such functions are such functions again; the width of the slope
/// shrinks with the reach, so that what is enclosed is exact to second order. With reach 0 the
/// slope is the derivative.
struct SlopeForm {
  std::complex<double> value;
  Disc slope;
  double reach = 0;

  static SlopeForm constant(std::complex<double> value) { return {value, {}, 0}; }
  /// Every value that it takes.
  Disc range() const { return {value, reach * slope.largest()}; }
};

SlopeForm operator+(const SlopeForm& a, const SlopeForm& b);
SlopeForm operator-(const SlopeForm& a, const SlopeForm& b);
SlopeForm operator*(const SlopeForm& a, const SlopeForm& b);
SlopeForm operator*(std::complex<double> a, const SlopeForm& x);
/// 1/x; an infinite slope where x may be zero.
SlopeForm invert(const SlopeForm& x);
SlopeForm conjugate(const SlopeForm& x);
SlopeForm real_part(const SlopeForm& x);
SlopeForm imaginary_part(const SlopeForm& x);
/// |x|, from |x|^2 - |x_0|^2 = t Re{sigma conj(x + x_0)}.
SlopeForm magnitude(const SlopeForm& x);
/// |x|^2
SlopeForm squared_magnitude(const SlopeForm& x);

/// e^(-j (omega + t) delay)
SlopeForm delay_form(double omega, double delay, double reach);
/// sin(a (omega + t))/(a (omega + t))
SlopeForm sinc_form(double omega, double a, double reach);
/// omega + t
SlopeForm frequency_form(double omega, double reach);

/// Lowest and highest value of a real function.
double lowest(const SlopeForm& x);
double highest(const SlopeForm& x);

}  // namespace gyrator
