#include "gyrator/controllers/pre_emphasis.hpp"

#include "gyrator/core/error.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include <fmt/core.h>

namespace gyrator {
namespace {

using Complex = std::complex<double>;

// 1 + q_1/z + q_2/z^2 over its value at z = 1: one root, a conjugate pair, two roots, or none.
struct Factor {
  std::array<double, 3> q{1, 0, 0};
  double sum() const { return q[0] + q[1] + q[2]; }
};

// The roots within the band, mapped to the z-plane, as factors of at most second order, slow before
// fast: numerator and denominator of a section then lie close together.
std::vector<Factor> map_roots(std::vector<Complex> roots, double band, double period) {
  std::erase_if(roots, [&](Complex s) {
    return !(s.real() < 0) || std::abs(s) > band || s.imag() < 0;  // the pair comes with its upper
  });
  std::sort(roots.begin(), roots.end(),
            [](Complex a, Complex b) { return std::abs(a) < std::abs(b); });
  std::vector<Factor> factors;
  for (const Complex s : roots) {
    const Complex z = std::exp(s * period);
    if (s.imag() > 0) {
      factors.push_back({{1, -2 * z.real(), std::norm(z)}});
    } else {
      factors.push_back({{1, -z.real(), 0}});
    }
  }
  return factors;
}

// By how much the roots beyond Nyquist delay a slow command [s]: A_0 = 1 - lag s + ...
double find_fast_lag(const std::vector<Complex>& poles, const std::vector<Complex>& zeros,
                     double nyquist) {
  double lag = 0;
  for (const Complex p : poles) lag -= std::abs(p) > nyquist ? (1.0 / p).real() : 0;
  for (const Complex z : zeros) lag += std::abs(z) > nyquist ? (1.0 / z).real() : 0;
  return lag;
}

// numerator/denominator with gain 1 at z = 1, in controllable form; no more states than it needs.
DiscreteStateSpace make_section(const Factor& numerator, const Factor& denominator) {
  const double gain = denominator.sum() / numerator.sum();
  const Eigen::Index n = numerator.q[2] != 0 || denominator.q[2] != 0 ? 2 : 1;
  DiscreteStateSpace section;
  section.A = Eigen::MatrixXd::Zero(n, n);
  section.B = Eigen::VectorXd::Unit(n, 0);
  section.C = Eigen::RowVectorXd::Zero(n);
  for (Eigen::Index i = 0; i < n; ++i) {
    const auto order = static_cast<std::size_t>(i) + 1;
    section.A(0, i) = -denominator.q[order];
    section.C(i) = gain * (numerator.q[order] - denominator.q[order]);
  }
  if (n == 2) section.A(1, 0) = 1;
  section.D = gain;
  return section;
}

}  // namespace

PreEmphasis make_pre_emphasis(const std::vector<Complex>& poles, const std::vector<Complex>& zeros,
                              double band, double period) {
  const double nyquist = std::numbers::pi / period;
  if (!(band > 0) || band > nyquist * (1 + 1e-12)) {
    throw Error(ErrorCode::bad_input, "controller/pre_emphasis/band",
                fmt::format("{:g} Hz: must be above 0 and at most half the sampling rate, {:g} Hz",
                            band / (2 * std::numbers::pi), 0.5 / period));
  }
  const auto numerators = map_roots(poles, band, period);
  const auto denominators = map_roots(zeros, band, period);
  PreEmphasis stage;
  for (std::size_t i = 0; i < std::max(numerators.size(), denominators.size()); ++i) {
    stage.filter =
        in_series(stage.filter, make_section(i < numerators.size() ? numerators[i] : Factor{},
                                             i < denominators.size() ? denominators[i] : Factor{}));
  }
  const double lag = find_fast_lag(poles, zeros, nyquist) / period;
  if (lag != 0) {
    const Factor lead{{1, -lag / (1 + lag), 0}};
    stage.filter = in_series(stage.filter, make_section(lead, Factor{}));
  }
  return stage;
}

}  // namespace gyrator
