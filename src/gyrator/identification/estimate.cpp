#include "gyrator/identification/estimate.hpp"

#include <algorithm>
#include <cmath>

#include <boost/math/distributions/students_t.hpp>

namespace gyrator {
namespace {

// The errors of known size have many degrees of freedom; more than this is as good as normal.
constexpr double most_degrees = 1000;

Estimate combine(double value, double s_x, double n_x, double s_y, double n_y) {
  const double variance = s_x * s_x + s_y * s_y;
  if (!(variance > 0)) return {value, 0, most_degrees};
  const double shares =
      std::pow(s_x * s_x / variance, 2) / n_x + std::pow(s_y * s_y / variance, 2) / n_y;
  return {value, std::sqrt(variance), std::min(1 / shares, most_degrees)};
}

}  // namespace

double find_student_quantile(double p, double degrees) {
  return boost::math::quantile(boost::math::students_t(degrees), p);
}

Interval find_interval(const Estimate& estimate, double confidence) {
  const double half =
      find_student_quantile((1 + confidence) / 2, estimate.degrees) * estimate.deviation;
  return {estimate.value - half, estimate.value + half};
}

Estimate multiply(const Estimate& x, const Estimate& y) {
  return combine(x.value * y.value, std::abs(y.value) * x.deviation, x.degrees,
                 std::abs(x.value) * y.deviation, y.degrees);
}

Estimate add_error(const Estimate& estimate, double deviation) {
  return combine(estimate.value, estimate.deviation, estimate.degrees, deviation, most_degrees);
}

}  // namespace gyrator
