#include "gyrator/cosim/first_negative.hpp"

namespace gyrator {
namespace {

constexpr int samples = 12;  // along the way, before extrema are looked for

// Value and slope of a polynomial.
struct Point {
  double value, slope;
};
Point evaluate(const Eigen::VectorXd& c, double x) {
  Point p{0, 0};
  for (Eigen::Index j = c.size() - 1; j >= 0; --j) {
    p.slope = p.slope * x + p.value;
    p.value = p.value * x + c(j);
  }
  return p;
}

// Where `negative` turns true between low, where it is not, and high, where it is.
template <class Negative>
double bisect(double low, double high, const Negative& negative) {
  for (;;) {
    const double middle = low + (high - low) / 2;
    if (!(middle > low && middle < high)) return high;
    (negative(middle) ? high : low) = middle;
  }
}

}  // namespace

double find_first_negative(const Eigen::VectorXd& c) {
  const auto is_negative = [&](double x) { return evaluate(c, x).value < 0; };
  Point before = evaluate(c, 0);
  for (int i = 1; i <= samples; ++i) {
    const double x0 = static_cast<double>(i - 1) / samples;
    const double x1 = static_cast<double>(i) / samples;
    const Point at = evaluate(c, x1);
    if (before.slope < 0 && at.slope > 0) {
      const double lowest = bisect(x0, x1, [&](double x) { return evaluate(c, x).slope > 0; });
      if (is_negative(lowest)) return bisect(x0, lowest, is_negative);
    }
    if (at.value < 0) return bisect(x0, x1, is_negative);
    before = at;
  }
  return 2;
}

}  // namespace gyrator
