#include "gyrator/identification/held_lag.hpp"

#include <cmath>
#include <numbers>

namespace gyrator {

std::complex<double> compute_held_lag(const HeldLag& lag, double frequency_hz) {
  const double T = lag.tick, w = 2 * std::numbers::pi * frequency_hz;
  const double whole = std::floor(lag.delay / T), rest = lag.delay - whole * T;
  const double decay = std::exp(-T / lag.time_constant);
  const double late = std::exp(-(T - rest) / lag.time_constant);
  const std::complex<double> z = std::polar(1.0, w * T);
  return ((late - decay) / z + (1 - late)) * std::polar(1.0, -w * T * whole) / (z - decay);
}

std::complex<double> compute_held_slope(const HeldLag& lag, double frequency_hz, int age) {
  const double w = 2 * std::numbers::pi * frequency_hz;
  const std::complex<double> response = compute_held_lag(lag, frequency_hz);
  return (std::polar(1.0, -w * lag.tick * age) / response - 1.0) / lag.time_constant;
}

std::complex<double> compute_held_mean(const HeldLag& lag, double frequency_hz) {
  const std::complex<double> jw(0, 2 * std::numbers::pi * frequency_hz);
  const std::complex<double> hold = (1.0 - std::exp(-jw * lag.tick)) / (jw * lag.tick);
  return hold * std::exp(-jw * lag.delay) / (1.0 + jw * lag.time_constant) /
         compute_held_lag(lag, frequency_hz);
}

int find_acting_age(const HeldLag& lag) {
  return static_cast<int>(std::floor(lag.delay / lag.tick)) + 1;
}

}  // namespace gyrator
