#include "gyrator/verification/margin_enclosure.hpp"

#include <cmath>
#include <limits>
#include <numbers>

namespace gyrator {
namespace {

using Complex = std::complex<double>;

constexpr int direct = 32;  // aliases with a form of their own, on either side
constexpr double rounding = 1e-13;
constexpr double infinity = std::numeric_limits<double>::infinity();

}  // namespace

struct MarginEnclosure::Terms {
  HeldForms base;
  SlopeForm law, sinc, turn;  // turn: phi e^(-jw t_d)
  SlopeForm centers = SlopeForm::constant(0);
  SlopeForm radii = SlopeForm::constant(0);
  double center_error = 0, radius_error = 0;  // of the two sums, by the bands

  SlopeForm drive() const { return law * turn * base.path; }  // V
};

MarginEnclosure::MarginEnclosure(const HeldDevice& device, const Sampling& sampling,
                                 DiscreteStateSpace law)
    : device_(device),
      law_(std::move(law)),
      collocated_(device.collocated()),
      period_(sampling.period.to_double()),
      rate_(2 * std::numbers::pi / period_),
      delay_(sampling.delay.to_double()) {
  const Rational periods = sampling.delay / sampling.period;
  const Rational rest = periods - Rational(floor_divide(periods, Rational(1)));
  whole_delay_ = rest == Rational(0);
  turn_ = std::polar(1.0, -2 * std::numbers::pi * rest.to_double());
  bands_ = enclose_alias_bands(device_, rate_, direct + 1);
}

void MarginEnclosure::add_bands(double omega, double reach, Terms& terms) const {
  const double settled = bands_.back().response.center.middle.real();
  double turned = 0;   // what oscillates, by (vm-2)
  double at_once = 0;  // the same without regard to its sign
  for (const AliasBand& band : bands_) {
    const HeldBand& response = band.response;
    for (const int side : {1, -1}) {
      const SlopeForm weight = weigh_band(band, side, rate_, omega, reach);
      const double most = highest(weight);
      const Complex middle = side > 0 ? response.center.middle : std::conj(response.center.middle);
      if (whole_delay_) {
        terms.centers = terms.centers + middle * weight;
        terms.center_error += most * response.center.radius;
      }
      turned += most * (std::abs(middle - settled) + response.center.radius);
      at_once += most * response.center.largest();
      terms.radii = terms.radii + (response.lowest + response.highest) / 2 * weight;
      terms.radius_error += most * (response.highest - response.lowest) / 2;
    }
  }
  if (whole_delay_) return;
  for (const int side : {1, -1}) {
    const double first = (bands_.front().first - 0.5 * (side < 0)) * rate_;
    turned += 2 * std::abs(settled) / (first * first * std::abs(1.0 - turn_));
  }
  terms.center_error += std::min(turned, at_once);
}

std::optional<MarginEnclosure::Terms> MarginEnclosure::collect(double omega, double reach) const {
  Terms terms;
  terms.base = device_.at(omega, reach);
  if (!(lowest(terms.base.damping) > 0)) return std::nullopt;
  terms.law = enclose_law(law_, period_, omega, reach);
  terms.sinc = sinc_form(omega, period_ / 2, reach);
  terms.turn =
      terms.sinc * delay_form(omega, period_ / 2, reach) * delay_form(omega, delay_, reach);
  add_bands(omega, reach, terms);
  for (int n = 1; n <= direct; ++n) {
    for (const int side : {1, -1}) {
      const double alias = omega + side * n * rate_;
      const HeldForms forms = device_.at(alias, reach);
      if (!(lowest(forms.damping) > 0)) return std::nullopt;
      const SlopeForm frequency = frequency_form(alias, reach);
      const SlopeForm square = invert(frequency * frequency);
      const SlopeForm half = invert(2.0 * forms.damping);
      const Complex phase = std::polar(1.0, side * n * std::arg(turn_));
      terms.centers = terms.centers + phase * (square * (forms.blocked + half * forms.path));
      terms.radii = terms.radii + square * (half * magnitude(forms.path));
    }
  }
  return terms;
}

// By how much the bands' widths may lower D.
double MarginEnclosure::correction(const Terms& terms, double omega, double reach) const {
  const double highest_omega = omega + reach;
  const double law = terms.law.range().largest();
  const double damping = highest(terms.base.damping);
  const double drive = terms.drive().range().largest();
  const double moved = highest_omega * law * terms.center_error;  // of W
  const double size =
      1 + highest_omega * law * terms.centers.range().largest() +
      (collocated_ ? 0 : law * terms.base.blocked.range().largest() / (omega - reach));
  const double wide = highest_omega * law;
  return 2 * damping * size * moved + drive * law * terms.center_error +
         damping * wide * wide * (2 * highest(terms.radii) + terms.radius_error) *
             terms.radius_error +
         drive * law * terms.radius_error;
}

MarginBound MarginEnclosure::over(double omega, double reach) const {
  const auto terms = collect(omega, reach);
  if (!terms) return {0, -infinity};
  const SlopeForm frequency = frequency_form(omega, reach);
  const SlopeForm inverse = invert(frequency);
  const SlopeForm law_turn = terms->law * terms->turn;
  SlopeForm W = SlopeForm::constant(1) + Complex(0, -1) * (frequency * (law_turn * terms->centers));
  if (!collocated_) W = W + Complex(0, -1) * (inverse * (law_turn * terms->base.blocked));
  const SlopeForm V = terms->drive();
  const SlopeForm law = magnitude(terms->law);
  const SlopeForm radius = law * (terms->sinc * terms->radii);  // |H| r_a/w
  const SlopeForm wide = frequency * radius;
  const SlopeForm D = terms->base.damping * (squared_magnitude(W) - wide * wide) +
                      inverse * imaginary_part(conjugate(W) * V) - magnitude(V) * radius;
  const double size = std::abs(terms->base.damping.value) * std::norm(W.value) +
                      std::abs(W.value * V.value) / omega;
  return {D.value.real(),
          lowest(real_part(D)) - correction(*terms, omega, reach) - rounding * size};
}

std::optional<double> MarginEnclosure::lowest_below(double omega) const {
  if (!collocated_) return std::nullopt;
  const auto terms = collect(0, omega);
  if (!terms) return std::nullopt;
  const SlopeForm frequency = frequency_form(0, omega);
  const SlopeForm W = SlopeForm::constant(1) +
                      Complex(0, -1) * (frequency * (terms->law * terms->turn * terms->centers));
  const SlopeForm V = terms->drive();
  const SlopeForm product = imaginary_part(conjugate(W) * V);
  if (std::abs(product.value) > rounding * std::abs(V.value)) return std::nullopt;
  const double radius = terms->law.range().largest() * highest(terms->radii);
  const double square = lowest(squared_magnitude(W)) - omega * omega * radius * radius;
  if (!(square > 0)) return std::nullopt;
  const double bound = lowest(terms->base.damping) * square + product.slope.middle.real() -
                       product.slope.radius - V.range().largest() * radius -
                       correction(*terms, 0, omega);
  if (!std::isfinite(bound)) return std::nullopt;
  return bound;
}

}  // namespace gyrator
