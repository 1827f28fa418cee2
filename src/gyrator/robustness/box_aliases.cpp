#include "gyrator/robustness/box_aliases.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace gyrator {
namespace {

using Complex = std::complex<double>;
constexpr double infinity = std::numeric_limits<double>::infinity();

constexpr double group_width = 0.1;      // of the frequency, while it matters
constexpr double far_group_width = 0.3;  // beyond this many times the first
constexpr double far_from_first = 10;
constexpr int one_by_one = 1000;  // sums over more aliases at once are integrals
constexpr double rest_reserve = 2;

// e^(-jn theta)/n^p summed over a group; for p = 2 … 4 of n^-p, and 1 of 1/n.
struct Sums {
  Complex p1, p2, p3, p4;
};

// Without oscillation, over many: Euler–Maclaurin's first terms, exact to n^-2 of themselves.
Sums integrate_sums(int first, int last) {
  const double a = first - 0.5;
  const double b = last + 0.5;
  return {std::log(b / a), 1 / a - 1 / b, (1 / (a * a) - 1 / (b * b)) / 2,
          (1 / (a * a * a) - 1 / (b * b * b)) / 3};
}

Sums sum_powers(int first, int last, double theta) {
  if (theta == 0 && first > one_by_one) return integrate_sums(first, last);
  Sums sums;
  for (int n = first; n <= last; ++n) {
    const double inverse = 1.0 / n;
    Complex term =
        (theta == 0 ? Complex(1) : std::polar(1.0, -std::fmod(n * theta, 2 * std::numbers::pi))) *
        inverse;
    sums.p1 += term;
    sums.p2 += term *= inverse;
    sums.p3 += term *= inverse;
    sums.p4 += term *= inverse;
  }
  return sums;
}

// What of g stands beside the parts: without the slope over frequency.
BoxModel without_frequency(BoxModel g) {
  g.slopes[0] = 0;
  g.remainder = 0;
  return g;
}

BoxModel twice_real(const BoxModel& g) {
  return Complex(2) * real_part(g);
}
// g - g*, 2 j Im g
BoxModel twice_imaginary(const BoxModel& g) {
  return Complex(0, 2) * imaginary_part(g);
}

BoxModel inverse_square(const BoxModel& omega) {
  const BoxModel once = reciprocal(omega);
  return once * once;
}

struct Reach {
  BoxModel center, size;
};

Reach find_reach(const BoxPort& port) {
  const BoxModel swing = port.path * (Complex(0.5) * reciprocal(port.damping));
  return {port.blocked + swing, majorant(swing)};
}

bool is_damped(const BoxPort& port) {
  return port.damping.lowest_real() > 0;
}

}  // namespace

BoxAliases::BoxAliases(const BoxPortModel& port, double period, double delay, int direct,
                       double tail_end)
    : port_(port),
      sampling_frequency_(2 * std::numbers::pi / period),
      turn_(2 * std::numbers::pi * std::fmod(delay / period, 1.0)),
      direct_(direct) {
  if (turn_ < 1e-9 || turn_ > 2 * std::numbers::pi - 1e-9) turn_ = 0;
  int first = direct + 1;
  while ((first - 0.5) * sampling_frequency_ < tail_end) {
    const double width = first < far_from_first * direct ? group_width : far_group_width;
    const int last = std::max(first, static_cast<int>(first * (1 + width)) - 1);
    add_group(first, last);
    first = last + 1;
  }
  add_rest((first - 0.5) * sampling_frequency_);
}

// Aliases first … last on either side, w_k = w_s (k ± x), with g = c + s (k ± x - kappa) ± rest:
//   e^(-jk theta) g/(k + x)^2 + (e^(-jk theta) g)*|_(-x)/(k - x)^2
// to second order in x, |x| <= 1/2.
void BoxAliases::add_group(int first, int last) {
  const double w_s = sampling_frequency_;
  const double middle = (first + last) / 2.0;
  const double half = (last - first + 1) / 2.0;
  const BoxPort port = port_.expand({middle * w_s, half * w_s});
  if (!is_damped(port)) {
    left_out_ = infinity;
    return;
  }
  const Reach g = find_reach(port);
  const double near = 1 / (1 - 0.5 / first);
  const Sums plain = sum_powers(first, last, 0);
  const double unit = 1 / (w_s * w_s);
  const auto add = [&](Quadratic& sum, const BoxModel& reach, const Sums& n) {
    const BoxModel c = unit * without_frequency(reach);
    const Complex s = unit * reach.slopes[0] / half;  // over k
    const double kappa = middle;
    sum.a0 = sum.a0 + twice_real(n.p2 * c + constant_box(s * (n.p1 - kappa * n.p2)));
    sum.a1 =
        sum.a1 + twice_imaginary(-2.0 * n.p3 * c + constant_box(-s * (n.p2 - 2 * kappa * n.p3)));
    sum.a2 = sum.a2 + twice_real(3.0 * n.p4 * c + constant_box(s * (n.p3 - 3 * kappa * n.p4)));
    const double third = 2 * 0.125 * std::pow(near, 5);
    const double p4 = plain.p4.real();
    left_out_ +=
        third * (4 * p4 / first * (c.highest_size() + plain_abs(s) * kappa) + plain_abs(s) * p4);
    left_out_ += 2 * near * near * plain.p2.real() * unit * reach.remainder;
  };
  add(radius_, g.size, plain);
  if (turn_ != 0 && first > one_by_one) {  // too many to follow the phase of
    left_out_ += 2 * near * near * plain.p2.real() * unit * g.center.highest_size();
  } else {
    add(center_, g.center, turn_ == 0 ? plain : sum_powers(first, last, turn_));
  }
}

// Beyond the last group.
void BoxAliases::add_rest(double from) {
  const BoxPort port = port_.expand({from, 0});
  const BoxPort beyond = port_.expand({10 * from, 0});
  if (!is_damped(port) || !is_damped(beyond)) {
    left_out_ = infinity;
    return;
  }
  const auto add = [&](const BoxModel& near, const BoxModel& far) {
    const double size = plain_abs(near.value);
    if (near.highest_size() == 0) return;
    const double exponent = size > 0 ? std::log10(plain_abs(far.value) / size) : 1;
    left_out_ += exponent < 0.95 ? 2 * (1 + rest_reserve) * near.highest_size() /
                                       (from * sampling_frequency_ * (1 - exponent))
                                 : infinity;
  };
  const Reach near = find_reach(port);
  const Reach far = find_reach(beyond);
  add(near.size, far.size);
  add(near.center, far.center);
}

BoxModel BoxAliases::expand(const Quadratic& q, const Band& band) const {
  BoxModel x = constant_box(band.omega / sampling_frequency_);
  x.slopes[0] = band.reach / sampling_frequency_;
  return q.a0 + x * (q.a1 + x * q.a2);
}

// At w_k = k w_s + w, and at its conjugate -|w_k| for negative k.
void BoxAliases::add_direct(AliasSums& sums, int k, const Band& band) const {
  const double at = band.omega + k * sampling_frequency_;
  const BoxPort port = port_.expand({std::abs(at), band.reach});
  if (!is_damped(port)) {
    sums.radius.remainder = infinity;
    return;
  }
  Reach g = find_reach(port);
  if (at < 0) {  // |w_k| falls as w rises
    g.center = conj(g.center);
    g.center.slopes[0] = -g.center.slopes[0];
    g.size.slopes[0] = -g.size.slopes[0];
  }
  BoxModel omega = constant_box(at);
  omega.slopes[0] = band.reach;
  const BoxModel weight = inverse_square(omega);
  const Complex phase = turn_ == 0 ? Complex(1) : std::polar(1.0, -k * turn_);
  sums.center = sums.center + phase * (weight * g.center);
  sums.radius = sums.radius + weight * g.size;
}

AliasSums AliasSums::over(const Band& within) const {
  AliasSums moved = *this;
  moved.band = within;
  if (!(band.reach > 0)) return moved;
  const double shift = (within.omega - band.omega) / band.reach;
  const double ratio = within.reach / band.reach;
  for (BoxModel* sum : {&moved.center, &moved.radius}) {
    sum->value += shift * sum->slopes[0];
    sum->slopes[0] *= ratio;
  }
  return moved;
}

AliasSums BoxAliases::sum(const Band& band) const {
  AliasSums sums{expand(center_, band), expand(radius_, band), band};
  sums.radius.remainder += left_out_;
  for (int k = 1; k <= direct_; ++k) {
    add_direct(sums, k, band);
    add_direct(sums, -k, band);
  }
  return sums;
}

}  // namespace gyrator
