#include "gyrator/verification/sampled_disk.hpp"

#include "gyrator/verification/alias_bands.hpp"

#include <cmath>
#include <limits>
#include <numbers>

namespace gyrator {
namespace {

using Long = long double;
using Complex = std::complex<long double>;

constexpr int direct = 32;  // aliases on either side, one by one
constexpr int degree = 10;
constexpr int oscillating = 2000;   // aliases under a fractional delay
constexpr Long fit_error = 1e-10L;  // of a polynomial between its nodes, relative
constexpr Long last_begins = 3;     // the last panel, times the fastest pole
constexpr Long pi = std::numbers::pi_v<Long>;

template <class Value>
Value evaluate_polynomial(const std::vector<Value>& coefficients, Long u) {
  Value sum = 0;
  for (std::size_t i = coefficients.size(); i-- > 0;) sum = sum * u + coefficients[i];
  return sum;
}

}  // namespace

long double SampledDiskPoint::margin(Complex law) const {
  const Complex W = Complex(1) + law * other_center;
  const Complex L = law * path;
  const Long reach = std::abs(law) * other_radius;
  return damping * (std::norm(W) - reach * reach) + (std::conj(W) * L).real() - std::abs(L) * reach;
}

long double SampledDiskPoint::margin_terms(Complex law) const {
  const Long W = std::abs(Complex(1) + law * other_center);
  const Long reach = std::abs(law) * other_radius;
  return damping * (W * W + reach * reach) + std::abs(law * path) * (W + reach);
}

SampledDisk::SampledDisk(const HeldDevice& device, const Sampling& sampling)
    : device_(device),
      period_(static_cast<Long>(sampling.period.num()) / sampling.period.den()),
      rate_(2 * pi / period_),
      delay_(static_cast<Long>(sampling.delay.num()) / sampling.delay.den()) {
  const Rational periods = sampling.delay / sampling.period;
  const Rational rest = periods - Rational(floor_divide(periods, Rational(1)));
  whole_delay_ = rest == Rational(0);
  turn_ = std::polar<Long>(1, -2 * pi * rest.num() / rest.den());
  const double fastest = HeldEnclosure(device).fastest();
  int first = direct + 1;
  while (first * rate_ < last_begins * static_cast<Long>(fastest)) {
    add_panels(first, 2 * first, 8);
    first *= 2;
  }
  add_panels(first, 0, 0);
}

SampledDisk::Alias SampledDisk::alias_at(Long omega) const {
  const HeldResponse r = compute_held_response(device_, omega);
  const Complex path = r.sensor_path * r.actuation;
  const Long twice = 2 * r.impedance.real();
  return {r.blocked + path / twice, std::abs(path) / twice};
}

SampledDisk::Panel SampledDisk::fit(int first, int last) const {
  using Matrix = Eigen::Matrix<Complex, Eigen::Dynamic, Eigen::Dynamic>;
  Panel panel{first, last, {}, {}, 0};
  const Long base = (first - 0.5L) * rate_;
  const Long low = last > 0 ? base / ((last - 0.5L) * rate_) : 0;
  const auto node = [&](Long k) {
    return (1 + low) / 2 + (1 - low) / 2 * std::cos(pi * (k + 0.5L) / (degree + 1));
  };
  Matrix powers(degree + 1, degree + 1);
  Matrix values(degree + 1, 2);
  for (int i = 0; i <= degree; ++i) {
    const Long u = node(i);
    const Alias alias = alias_at(base / u);
    values(i, 0) = alias.center;
    values(i, 1) = alias.radius;
    for (int k = 0; k <= degree; ++k) powers(i, k) = std::pow(u, static_cast<Long>(k));
  }
  const Matrix coefficients = powers.partialPivLu().solve(values);
  for (int k = 0; k <= degree; ++k) {
    panel.center.push_back(coefficients(k, 0));
    panel.radius.push_back(coefficients(k, 1).real());
  }
  for (int i = 0; i < degree; ++i) {
    const Long u = node(i + 0.5L);
    const Alias exact = alias_at(base / u);
    const Alias fitted = evaluate(panel, base / u);
    panel.error = std::max({panel.error, std::abs(exact.center - fitted.center),
                            std::abs(exact.radius - fitted.radius)});
  }
  return panel;
}

void SampledDisk::add_panels(int first, int last, int depth) {
  Panel panel = fit(first, last);
  const Alias begin = alias_at(first * rate_);
  const bool good = panel.error <= fit_error * (std::abs(begin.center) + begin.radius);
  if (good || last == 0) {
    panels_.push_back(panel);
  } else if (depth == 0 || last - first < 8) {
    panels_.push_back({first, last, {}, {}, 0});
  } else {
    const int middle = (first + last) / 2;
    add_panels(first, middle, depth - 1);
    add_panels(middle, last, depth - 1);
  }
}

SampledDisk::Alias SampledDisk::evaluate(const Panel& panel, Long omega) const {
  if (panel.center.empty()) return alias_at(omega);
  const Long u = (panel.first - 0.5L) * rate_ / std::abs(omega);
  const Complex center = evaluate_polynomial(panel.center, u);
  return {omega > 0 ? center : std::conj(center), evaluate_polynomial(panel.radius, u)};
}

// Sums of center and radius over omega_n^2, the delay's turn at the base frequency left out.
void SampledDisk::add_tail(Long omega, SampledDiskPoint& point, Complex& center,
                           Long& radius) const {
  for (const Panel& panel : panels_) {
    for (const int side : {1, -1}) {
      const Long shift = side * omega / rate_;
      if (panel.center.empty()) {
        for (int n = panel.first; n < panel.last; ++n) {
          const Long w = omega + side * n * rate_;
          const Alias alias = alias_at(w);
          radius += alias.radius / (w * w);
          if (whole_delay_) center += alias.center / (w * w);
        }
        continue;
      }
      Long scale = 1 / (rate_ * rate_);
      for (std::size_t k = 0; k <= degree; ++k, scale *= panel.first - 0.5L) {
        const int power = 2 + static_cast<int>(k);
        Long sum = compute_zeta<Long>(power, panel.first + shift);
        if (panel.last > 0) sum -= compute_zeta<Long>(power, panel.last + shift);
        if (k == 0) point.error += panel.error * sum * scale;
        radius += panel.radius[k] * sum * scale;
        if (whole_delay_)
          center += (side > 0 ? panel.center[k] : std::conj(panel.center[k])) * sum * scale;
      }
    }
  }
  if (whole_delay_) return;
  // sum of z^n f_n = z^N f_N/(1 - z) + (1/(1 - z)) sum over n > N of z^n (f_n - f_(n-1))
  for (const int side : {1, -1}) {
    const Complex z = side > 0 ? turn_ : std::conj(turn_);
    std::size_t at = 0;
    const auto term = [&](int n) {
      while (panels_[at].last > 0 && n >= panels_[at].last) ++at;
      const Long w = omega + side * n * rate_;
      return evaluate(panels_[at], w).center / (w * w);
    };
    Complex turn = std::polar<Long>(1, std::arg(z) * (direct + 1));
    for (int n = direct + 1; n < oscillating; ++n, turn *= z) center += turn * term(n);
    const Complex next = term(oscillating);
    const Long step = std::abs(term(oscillating + 1) - next);
    center += turn * next / (Complex(1) - z);
    point.error += 2 * step / std::norm(Complex(1) - z);
  }
}

SampledDiskPoint SampledDisk::at(Long omega) const {
  SampledDiskPoint point;
  point.omega = omega;
  Complex center = 0;
  Long radius = 0;
  add_tail(omega, point, center, radius);
  for (int n = direct; n >= 1; --n) {
    for (const int side : {1, -1}) {
      const Long w = omega + side * n * rate_;
      const Alias alias = alias_at(w);
      center += std::polar<Long>(1, std::arg(turn_) * side * n) * alias.center / (w * w);
      radius += alias.radius / (w * w);
    }
  }
  const HeldResponse r = compute_held_response(device_, omega);
  // (1 - e^(-jwT)) e^(-jw delay)/(T j^2), of every k_n
  const Complex common = -(Complex(1) - std::polar<Long>(1, -omega * period_)) *
                         std::polar<Long>(1, -omega * delay_) / period_;
  const Long square = omega * omega;
  point.damping = r.impedance.real();
  point.path = common * r.sensor_path * r.actuation / square;
  point.other_center = common * (center + r.blocked / square);
  point.other_radius = std::abs(common) * radius;
  point.error *= std::abs(common);
  point.center = point.other_center + point.path / (2 * point.damping);
  point.radius = point.other_radius + std::abs(point.path) / (2 * point.damping);
  return point;
}

}  // namespace gyrator
