#include "gyrator/verification/slope_form.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace gyrator {
namespace {

using Complex = std::complex<double>;

constexpr double infinity = std::numeric_limits<double>::infinity();

Disc times(Complex a, const Disc& x) {
  return {a * x.middle, std::abs(a) * x.radius};
}
Disc conjugate(const Disc& x) {
  return {std::conj(x.middle), x.radius};
}
// The real part of every element, as a disc around a real number.
Disc real_part(const Disc& x) {
  return {x.middle.real(), x.radius};
}

}  // namespace

Disc operator+(const Disc& a, const Disc& b) {
  return {a.middle + b.middle, a.radius + b.radius};
}

Disc operator*(const Disc& a, const Disc& b) {
  return {a.middle * b.middle,
          std::abs(a.middle) * b.radius + a.radius * (std::abs(b.middle) + b.radius)};
}

Disc invert(const Disc& x) {
  const double gap = std::norm(x.middle) - x.radius * x.radius;
  if (!(gap > 0)) return {0, infinity};
  return {std::conj(x.middle) / gap, x.radius / gap};
}

SlopeForm operator+(const SlopeForm& a, const SlopeForm& b) {
  return {a.value + b.value, a.slope + b.slope, std::max(a.reach, b.reach)};
}

SlopeForm operator-(const SlopeForm& a, const SlopeForm& b) {
  return a + (-1.0) * b;
}

// a b = a0 b0 + t (sigma_a b0 + a sigma_b)
SlopeForm operator*(const SlopeForm& a, const SlopeForm& b) {
  return {a.value * b.value, times(b.value, a.slope) + a.range() * b.slope,
          std::max(a.reach, b.reach)};
}

SlopeForm operator*(Complex a, const SlopeForm& x) {
  return {a * x.value, times(a, x.slope), x.reach};
}

// 1/x = 1/x0 - t sigma/(x0 x)
SlopeForm invert(const SlopeForm& x) {
  return {1.0 / x.value, times(-1.0 / x.value, x.slope) * invert(x.range()), x.reach};
}

SlopeForm conjugate(const SlopeForm& x) {
  return {std::conj(x.value), conjugate(x.slope), x.reach};
}

SlopeForm real_part(const SlopeForm& x) {
  return {x.value.real(), real_part(x.slope), x.reach};
}

SlopeForm imaginary_part(const SlopeForm& x) {
  return real_part(Complex(0, -1) * x);
}

SlopeForm magnitude(const SlopeForm& x) {
  const double size = std::abs(x.value);
  const Disc all = x.range();
  const Disc sum{x.value + all.middle, all.radius};
  // |x| + |x0| lies in [size + all.least(), size + all.largest()].
  const double low = size + all.least();
  const double high = size + all.largest();
  const Disc total{(low + high) / 2, (high - low) / 2};
  const Disc sharp = real_part(x.slope * conjugate(sum)) * invert(total);
  // A function never grows faster in size than it moves.
  const Disc blunt{0, x.slope.largest()};
  const bool usable = std::isfinite(sharp.radius) && sharp.largest() <= 3 * blunt.radius;
  return {size, usable ? sharp : blunt, x.reach};
}

SlopeForm squared_magnitude(const SlopeForm& x) {
  return real_part(x * conjugate(x));
}

// (e^(-jt delay) - 1)/t lies within delay^2 |t|/2 of -j delay.
SlopeForm delay_form(double omega, double delay, double reach) {
  const Complex value = std::polar(1.0, -omega * delay);
  return {value, {Complex(0, -delay) * value, delay * delay * reach / 2}, reach};
}

// The second derivative of sin(x)/x is nowhere larger than 1/3.
SlopeForm sinc_form(double omega, double a, double reach) {
  const double x = omega * a;
  const bool small = std::abs(x) < 1e-3;
  const double value = small ? 1 - x * x / 6 : std::sin(x) / x;
  const double derivative = small ? -x / 3 + x * x * x / 30 : (std::cos(x) - value) / x;
  return {value, {a * derivative, a * a * reach / 6}, reach};
}

SlopeForm frequency_form(double omega, double reach) {
  return {omega, {1.0, 0}, reach};
}

double lowest(const SlopeForm& x) {
  const double bound = x.value.real() - x.reach * x.slope.largest();
  return std::isnan(bound) ? -infinity : bound;
}

double highest(const SlopeForm& x) {
  const double bound = x.value.real() + x.reach * x.slope.largest();
  return std::isnan(bound) ? infinity : bound;
}

}  // namespace gyrator
