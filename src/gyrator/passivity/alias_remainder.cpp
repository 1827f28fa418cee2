#include "gyrator/passivity/alias_remainder.hpp"

#include "gyrator/passivity/tail_quadrature.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <optional>

namespace gyrator {
namespace {

using Complex = std::complex<double>;
constexpr double infinity = std::numeric_limits<double>::infinity();
constexpr double reserve = 2e-4;  // of the tail's integral

struct AliasFit {
  TaylorModel center, radius;
};

// M + S A/(2R) and |S A|/(2R) as parabolas through three points, with twice their bend as the
// bound: for a smooth response whose Re Z falls too fast for its modes to bound it (as w^-4 behind
// a lossless transmission). None where Re Z is not positive at one of them.
std::optional<AliasFit> fit_alias(PortModel& model, double omega, double reach) {
  std::array<Complex, 3> center;
  std::array<double, 3> radius{};
  for (std::size_t i = 0; i < 3; ++i) {
    const PortResponse r = model.at(omega + (static_cast<double>(i) - 1) * reach);
    const double damping = r.impedance.real();
    if (!(damping > 0)) return std::nullopt;
    const Complex swing = plain_product(r.sensor_path, r.actuation) / (2 * damping);
    center[i] = r.blocked_motion + swing;
    radius[i] = plain_abs(swing);
  }
  const auto fit = [&](const auto& q) {
    return TaylorModel{q[1], (q[2] - q[0]) / (2 * reach),
                       plain_abs(Complex(q[2] + q[0] - 2.0 * q[1])) / (reach * reach), reach};
  };
  return AliasFit{fit(center), fit(radius)};
}

}  // namespace

AliasRemainder::AliasRemainder(PortModel& model, double period, double delay, bool whole,
                               int direct, int bounded)
    : sampling_frequency_(2 * std::numbers::pi / period) {
  const double theta = whole ? 0 : sampling_frequency_ * delay;
  for (int k = direct + 1; k <= bounded; ++k) add_alias(model, k, theta);
  add_tail(model, (bounded + 0.5) * sampling_frequency_, whole, theta);
}

// The k-th alias above and the k-th below, |w| = w_s (k ± x), to third order in x.
void AliasRemainder::add_alias(PortModel& model, int k, double theta) {
  const double w_s = sampling_frequency_;
  const PortTaylor port = expand_port(model, k * w_s, w_s / 2);
  TaylorModel center;
  TaylorModel radius;
  if (port.damping.lowest_real() > 0) {
    const TaylorModel reach = port.path * (Complex(0.5) * reciprocal(port.damping));
    center = port.blocked + reach;
    radius = majorant(reach);
  } else {
    last_undamped_ = k;
    const auto swing = fit_alias(model, k * w_s, w_s / 2);
    if (!swing) {
      left_out_ = infinity;
      return;
    }
    center = swing->center;
    radius = swing->radius;
  }
  // (v + s y + …)/(k + y)^2 with y = x above and -x below, 1/(k + y)^2 = (1 - 2 y/k + 3 y^2/k^2 -
  // 4 y^3/k^3 + …)/k^2; what follows is at most 5 |y/k|^4/(1 - |y/k|)^6 of it.
  const double square = 1 / (w_s * w_s * k * k);
  const double y = 0.5 / k;
  const double beyond = 5 * y * y * y * y / std::pow(1 - y, 6);
  const auto add = [&](Cubic& sum, Complex v, Complex slope, Complex turn, double sign) {
    const Complex s = slope * w_s;  // over y
    const std::array<Complex, 4> terms{v, s - 2.0 / k * v, 3.0 / k / k * v - 2.0 / k * s,
                                       -4.0 / k / k / k * v + 3.0 / k / k * s};
    double power = 1;
    for (std::size_t i = 0; i < 4; ++i, power *= sign) sum[i] += power * turn * square * terms[i];
    left_out_ += square * (plain_abs(v) * beyond + plain_abs(s) * 0.5 * 4 * y * y * y * 1.2);
  };
  const Complex turn = std::polar(1.0, -k * theta);
  add(center_, center.value, center.slope, turn, 1);
  add(center_, std::conj(center.value), std::conj(center.slope), std::conj(turn), -1);
  add(radius_, radius.value, radius.slope, 1, 1);
  add(radius_, radius.value, radius.slope, 1, -1);
  const double bend = (center.curvature + radius.curvature) * w_s * w_s / 4;
  left_out_ += 2 * square * bend * 1.2;
}

// integral of g/w^2 over panels in ln w, then a power law.
void AliasRemainder::add_tail(PortModel& model, double from, bool whole, double theta) {
  const double w_s = sampling_frequency_;
  const double to = find_tail_end(from, model.poles());
  struct Reach {
    Complex center;
    double size = 0;
  };
  const auto reach_at = [&](double omega) -> Reach {
    const PortResponse r = model.at(omega);
    const Complex path = plain_product(r.sensor_path, r.actuation);
    const double size = plain_abs(path);
    if (size == 0) return {r.blocked_motion, 0};
    const double damping = r.impedance.real();
    if (!(damping > 0)) return {0, infinity};
    return {r.blocked_motion + path / (2 * damping), size / (2 * damping)};
  };
  Complex center = 0;
  double size = 0;
  double radius = 0;
  double variation = 0;  // of the centre's terms g/w^2
  Complex last = 0;
  auto nodes = make_tail_nodes(from, to, model.poles());
  std::sort(nodes.begin(), nodes.end(),
            [](const TailNode& a, const TailNode& b) { return a.omega < b.omega; });
  for (const TailNode& node : nodes) {
    const Reach g = reach_at(node.omega);
    const double weight = node.weight / w_s;
    center += weight * g.center;
    size += weight * plain_abs(g.center);
    radius += weight * g.size;
    const Complex term = g.center / (node.omega * node.omega);
    variation += plain_abs(term - last);  // from zero to the first, and so on
    last = term;
  }
  const double near = reach_at(to).size;
  if (near > 0) {
    const double exponent = std::log10(reach_at(10 * to).size / near);
    const double rest = exponent < 0.95 ? near / (to * w_s * (1 - exponent)) : infinity;
    radius += rest;
    left_out_ += 2 * rest;
  }
  radius_[0] += 2 * radius;
  left_out_ += 2 * reserve * radius;
  if (whole) {
    center_[0] += 2 * center.real();
    // The odd part of the sum, Im g of the two sides: at most this at x = 1/2.
    left_out_ += std::abs(reach_at(from).center.imag()) / (from * from);
    left_out_ += 2 * reserve * size;
  } else {
    // By parts: partial sums of e^(-jk theta) are at most 1/|sin(theta/2)|.
    left_out_ += 2 * std::min(1.01 * size, 1.1 * variation / std::abs(std::sin(theta / 2)));
  }
}

TaylorModel AliasRemainder::expand(const Cubic& q, double omega, double reach) const {
  const double x = omega / sampling_frequency_;
  const double h = reach / sampling_frequency_;
  return {q[0] + x * (q[1] + x * (q[2] + x * q[3])),
          (q[1] + x * (2.0 * q[2] + 3 * x * q[3])) / sampling_frequency_,
          (plain_abs(q[2] + 3 * x * q[3]) + plain_abs(q[3]) * h) /
              (sampling_frequency_ * sampling_frequency_),
          reach};
}

TaylorModel AliasRemainder::center(double omega, double reach) const {
  return expand(center_, omega, reach);
}

TaylorModel AliasRemainder::radius(double omega, double reach) const {
  return expand(radius_, omega, reach) + left_out_;
}

}  // namespace gyrator
