#include "gyrator/verification/alias_bands.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace gyrator {
namespace {

constexpr double growth = 1.12;  // of a band's frequencies from end to end
constexpr double far = 6;        // times the fastest pole: the last band begins
constexpr int most_bands = 400;
constexpr int deepest_split = 14;

// Both in one: the smallest disc around two.
Disc join(const Disc& a, const Disc& b) {
  const double distance = std::abs(b.middle - a.middle);
  if (distance + b.radius <= a.radius) return a;
  if (distance + a.radius <= b.radius) return b;
  const double radius = (distance + a.radius + b.radius) / 2;
  if (!std::isfinite(radius)) return {a.middle, radius};
  return {a.middle + (b.middle - a.middle) / distance * (radius - a.radius), radius};
}

HeldBand join(const HeldBand& a, const HeldBand& b) {
  return {join(a.center, b.center), std::min(a.lowest, b.lowest), std::max(a.highest, b.highest)};
}

// Split until the enclosure is narrow beside what it encloses.
HeldBand enclose_band(const HeldEnclosure& device, double low, double high, int depth) {
  const HeldBand whole = device.at_inverse(low, high);
  const bool narrow = whole.highest <= 1.1 * whole.lowest + 1e-300;
  if (depth == 0 || (narrow && std::isfinite(whole.center.radius))) return whole;
  const double middle = (low + high) / 2;
  return join(enclose_band(device, low, middle, depth - 1),
              enclose_band(device, middle, high, depth - 1));
}

}  // namespace

template <class Real>
Real compute_zeta(int power, Real a) {
  // Bernoulli numbers over factorials; the first one left out is below 1e-20 of the sum for a >= 32.
  constexpr std::array<Real, 7> coefficients{Real(1) / 12,
                                             -Real(1) / 720,
                                             Real(1) / 30240,
                                             -Real(1) / 1209600,
                                             Real(1) / 47900160,
                                             -Real(691) / Real(1307674368000),
                                             Real(1) / Real(74724249600)};
  const Real term = std::pow(a, Real(-power));
  Real sum = term * a / (power - 1) + term / 2;
  Real factor = Real(power) * term / a;
  for (std::size_t i = 0; i < coefficients.size(); ++i) {
    sum += coefficients[i] * factor;
    const int k = power + 2 * static_cast<int>(i) + 1;
    factor *= Real(k) * Real(k + 1) / (a * a);
  }
  return sum;
}
template double compute_zeta(int, double);
template long double compute_zeta(int, long double);

std::vector<AliasBand> enclose_alias_bands(const HeldEnclosure& device, double rate, int first) {
  std::vector<AliasBand> bands;
  const double end = std::max(far * device.fastest() / rate, 1.0 * first);
  int from = first;
  while (from < end && static_cast<int>(bands.size()) < most_bands) {
    const int to = std::max(from + 1, static_cast<int>(from * growth));
    const double low = 1 / ((to - 0.5) * rate);
    const double high = 1 / ((from - 0.5) * rate);
    bands.push_back({from, to, enclose_band(device, low, high, deepest_split)});
    from = to;
  }
  bands.push_back({from, 0, enclose_band(device, 0, 1 / ((from - 0.5) * rate), deepest_split)});
  return bands;
}

SlopeForm weigh_band(const AliasBand& band, int side, double rate, double omega, double reach) {
  const auto sum = [&](int power, double frequency) {
    const double shift = side * frequency / rate;
    const double whole = compute_zeta(power, band.first + shift);
    const double rest = band.last > 0 ? compute_zeta(power, band.last + shift) : 0;
    return (whole - rest) / std::pow(rate, power);
  };
  // The derivative moves one way only.
  const double a = -2 * side * sum(3, omega - reach);
  const double b = -2 * side * sum(3, omega + reach);
  return {sum(2, omega), {(a + b) / 2, std::abs(b - a) / 2}, reach};
}

}  // namespace gyrator
