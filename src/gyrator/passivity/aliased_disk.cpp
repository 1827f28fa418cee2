#include "gyrator/passivity/aliased_disk.hpp"

#include "gyrator/core/plain_complex.hpp"
#include "gyrator/cosim/hold.hpp"
#include "gyrator/passivity/tail_quadrature.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <utility>

#include <boost/math/quadrature/gauss.hpp>

namespace gyrator {
namespace {

using Complex = std::complex<double>;
constexpr double infinity = std::numeric_limits<double>::infinity();

constexpr int fewest_aliases = 22;
constexpr int fewest_aliases_oscillating = 200;
constexpr int most_aliases = 20000;

struct QuadratureNode {
  double x, weight;
};

// Gauss–Legendre nodes over [from, to].
template <unsigned Points>
std::array<QuadratureNode, Points> gauss_nodes(double from, double to) {
  using Rule = boost::math::quadrature::gauss<double, Points>;
  static_assert(Points % 2 == 0);
  std::array<QuadratureNode, Points> nodes;
  const double middle = (from + to) / 2;
  const double half = (to - from) / 2;
  for (unsigned i = 0; i < Points / 2; ++i) {
    nodes[2 * i] = {middle - half * Rule::abscissa()[i], half * Rule::weights()[i]};
    nodes[2 * i + 1] = {middle + half * Rule::abscissa()[i], half * Rule::weights()[i]};
  }
  return nodes;
}

}  // namespace

AliasedDisk::AliasedDisk(const Device& device, const Sampling& sampling, PortCorrection correction)
    : model_(device),
      correction_(std::move(correction)),
      period_(sampling.period.to_double()),
      delay_(sampling.delay.to_double()) {
  split_ = split_delay(sampling);
  whole_delay_ = split_.rest == 0;
  const double sampling_frequency = 2 * std::numbers::pi / period_;
  aliases_ = std::clamp(count_resonant_aliases(model_.poles(), sampling_frequency),
                        whole_delay_ ? fewest_aliases : fewest_aliases_oscillating, most_aliases);
  least_.value = infinity;
  prepare_tail();
}

// Sum of k_n over all aliases but the base one, times what M tends to: that part of the series is a
// held input integrated over the period, whatever the delay,
//   sum_n k_n = z^-m (T - rest + rest z^-1) / (z - 1),  t_d = m T + rest.               (disk-4)
Complex AliasedDisk::sum_feedthrough(double omega, Complex base_weight) const {
  if (model_.blocked_feedthrough() == 0) return 0;
  const Complex later = std::polar(1.0, -omega * period_);
  const Complex held = split_.period - split_.rest + split_.rest * later;
  const Complex late =
      std::polar(1.0, -omega * period_ * (static_cast<double>(split_.whole) + 0.5));
  const Complex all = late * held / Complex(0, 2 * std::sin(omega * period_ / 2));
  return model_.blocked_feedthrough() * (all - base_weight);
}

void AliasedDisk::note_damping(const PortResponse& response) {
  const double damping = response.impedance.real();
  if (damping >= least_.value) return;
  least_ = {std::abs(response.omega), damping, damping < -1e-12 * plain_abs(response.impedance)};
}

AliasedDisk::Term AliasedDisk::make_term(double omega) {
  PortResponse r = model_.at(std::abs(omega));
  if (correction_) correction_(r);
  note_damping(r);
  const Complex path = plain_product(r.sensor_path, r.actuation);
  const Complex blocked = r.blocked_motion - model_.blocked_feedthrough();
  Term term{0, 0, path, blocked, std::max(0.0, r.impedance.real())};
  if (omega < 0) {
    term.path = std::conj(term.path);
    term.blocked = std::conj(term.blocked);
  }
  return term;
}

void AliasedDisk::prepare_tail() {
  const double sampling_frequency = 2 * std::numbers::pi / period_;
  tail_start_ = (aliases_ + 1) * sampling_frequency;
  far_omega_ = find_tail_end(tail_start_, model_.poles());
  // sum over n -> (1/w_s) integral of g(w)/w^2 dw
  for (const TailNode& node : make_tail_nodes(tail_start_, far_omega_, model_.poles())) {
    Term term = make_term(node.omega);
    term.radius_weight = node.weight / sampling_frequency;
    tail_.push_back(term);
  }
  far_ = make_term(far_omega_);
  farther_ = make_term(10 * far_omega_);
  bare_tail_ = sum_tail(0);
}

AliasedDisk::Terms AliasedDisk::collect(double omega) {
  const double sampling_frequency = 2 * std::numbers::pi / period_;
  // (1 - e^(-jwT)) / T of (disk-1), the same at every alias.
  const Complex hold = Complex(0, omega) * compute_normalized_hold(omega, period_);
  Terms terms;
  terms.omega = omega;
  terms.aliases.reserve(static_cast<std::size_t>(2 * aliases_) + 24);
  const double hold_size = plain_abs(hold);
  // e^(-jw_n t_d) is the same at every alias where the delay is whole.
  const Complex base_turn = std::polar(1.0, -omega * delay_);
  const auto weigh = [&](Term term, double at, double factor) {
    const Complex turn = whole_delay_ ? base_turn : std::polar(1.0, -at * delay_);
    const double weight = factor / (at * at);
    term.center_weight = -weight * plain_product(hold, turn);  // 1/(jw)^2 = -1/w^2
    term.radius_weight = weight * hold_size;
    return term;
  };
  terms.base = weigh(make_term(omega), omega, 1);
  terms.base.blocked += model_.blocked_feedthrough();
  terms.feedthrough = sum_feedthrough(omega, terms.base.center_weight);
  for (int n = 1; n <= aliases_; ++n) {
    for (const double at : {omega + n * sampling_frequency, omega - n * sampling_frequency}) {
      terms.aliases.push_back(weigh(make_term(at), at, 1));
    }
  }

  // Euler–Maclaurin from the midpoint a = |w_(N+1/2)|, in units of w_s:
  //   sum_{n>N} f(w_n) = integral_a^inf f dw + f'(a)/24 - 7 f'''(a)/5760 + …                 (em-1)
  // with the derivatives from values at a ± h and a ± 3h:
  //   f' = (27 d_1 - d_3)/(48 h),  f''' = (d_3 - 3 d_1)/(8 h^3),  d_k = f(a + k h) - f(a - k h).
  constexpr double h = 0.25;
  constexpr double third = -7.0 / 5760 / (8 * h * h * h);
  constexpr double near_weight = 27 / (24 * 48 * h) - 3 * third;
  constexpr double far_weight = -1 / (24 * 48 * h) + third;
  for (const double side : {1.0, -1.0}) {
    const double a = (aliases_ + 0.5) * sampling_frequency + side * omega;
    const auto add = [&](double at, double factor) {
      Term term = weigh(make_term(side * at), side * at, factor);
      if (!whole_delay_) term.center_weight = 0;  // oscillates between the aliases
      terms.aliases.push_back(term);
    };
    for (const auto& node : gauss_nodes<6>(a, tail_start_))
      add(node.x, node.weight / sampling_frequency);
    for (const double sign : {1.0, -1.0}) {
      add(a + sign * h * sampling_frequency, sign * near_weight);
      add(a + sign * 3 * h * sampling_frequency, sign * far_weight);
    }
  }
  terms.tail_factor = -plain_product(hold, base_turn);
  return terms;
}

namespace {

// 1/(2 Re Z) of a term with a path; without one its damping does not matter.
double find_compliance(const AliasedDisk::Term& term, double size, double extra_damping) {
  if (!(size > 0)) return 0;
  const double damping = term.damping + extra_damping;
  return damping > 0 ? 1 / (2 * damping) : infinity;
}

}  // namespace

AliasedDisk::Tail AliasedDisk::sum_tail(double extra_damping) const {
  Tail tail;
  for (const Term& term : tail_) {
    const double size = plain_abs(term.path);
    const double compliance = find_compliance(term, size, extra_damping);
    const Complex reach = term.blocked + (size > 0 ? term.path * compliance : Complex(0));
    tail.center += term.radius_weight * reach;
    tail.size += term.radius_weight * std::abs(reach);
    tail.radius += term.radius_weight * size * compliance;
  }
  // Behind the last panel g ~ w^q: integral of g/w^2 from W is g(W)/(W (1 - q)).
  const double sampling_frequency = 2 * std::numbers::pi / period_;
  const auto reach_at = [&](const Term& term) {
    const double size = std::abs(term.path);
    return size * find_compliance(term, size, extra_damping);
  };
  const double near = reach_at(far_);
  if (near > 0) {
    const double exponent = std::log10(reach_at(farther_) / near);
    const double weight =
        exponent < 0.95 ? 1 / (far_omega_ * sampling_frequency * (1 - exponent)) : infinity;
    tail.center += weight * far_.path * find_compliance(far_, std::abs(far_.path), extra_damping);
    tail.size += weight * near;
    tail.radius += weight * near;
  }
  return tail;
}

DiskPoint AliasedDisk::evaluate(const Terms& terms, double extra_damping) const {
  Complex center = terms.feedthrough;
  double radius = 0;
  double oscillating = 0;  // bound of the centre's tail where the delay makes it oscillate
  for (const Term& term : terms.aliases) {
    const double size = plain_abs(term.path);
    const double compliance = find_compliance(term, size, extra_damping);
    const Complex reach = size > 0 ? term.blocked + term.path * compliance : term.blocked;
    center += plain_product(term.center_weight, reach);
    radius += term.radius_weight * size * compliance;
    if (!whole_delay_ && term.center_weight == Complex(0))
      oscillating += term.radius_weight * (plain_abs(term.blocked) + size * compliance);
  }
  const Tail tail = extra_damping == 0 ? bare_tail_ : sum_tail(extra_damping);
  const double factor = std::abs(terms.tail_factor);
  if (whole_delay_) {
    // Upper aliases carry the tail as it is, lower ones its conjugate.
    center += terms.tail_factor * 2.0 * tail.center.real();
  } else {
    oscillating += 2 * factor * tail.size;
  }
  radius += 2 * factor * tail.radius + oscillating;

  DiskPoint point;
  point.omega = terms.omega;
  const Term& base = terms.base;
  const double R = base.damping + extra_damping;
  point.damping = R;
  // The base term c_0 = k (M + S A/(2 R)) with its part of (disk-3) multiplied out:
  //   R (|c_0|^2 - r_0^2) = |k|^2 (R |M|^2 + Re{M* S A}).
  const Complex scaled_base = base.center_weight * (R * base.blocked + base.path / 2.0);
  const double scaled_base_radius = base.radius_weight * std::abs(base.path) / 2;
  if (!std::isfinite(radius)) {  // an alias without any damping: no disk bounds the loop
    point.scaled_center = scaled_base;
    point.scaled_gap = -infinity;
    point.center = R > 0 ? scaled_base / R : Complex(infinity, 0);
    point.radius = infinity;
    return point;
  }
  point.scaled_center = scaled_base + R * center;
  point.scaled_gap =
      std::norm(base.center_weight) *
          (R * std::norm(base.blocked) + std::real(std::conj(base.blocked) * base.path)) +
      2 * std::real(std::conj(scaled_base) * center) - 2 * scaled_base_radius * radius +
      R * (std::norm(center) - radius * radius);
  point.center = R > 0 ? point.scaled_center / R : Complex(infinity, 0);
  point.radius = R > 0 ? scaled_base_radius / R + radius : infinity;
  return point;
}

DiskPoint AliasedDisk::at(double omega, double extra_damping) {
  return evaluate(collect(omega), extra_damping);
}

}  // namespace gyrator
