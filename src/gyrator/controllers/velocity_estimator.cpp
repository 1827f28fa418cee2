#include "gyrator/controllers/velocity_estimator.hpp"

#include "gyrator/core/error.hpp"

#include <cmath>
#include <numbers>
#include <string>

#include <fmt/core.h>

namespace gyrator {
namespace {

using std::numbers::pi;

void require_positive(double value, const char* key, const char* unit) {
  if (value > 0 && std::isfinite(value)) return;
  throw Error(ErrorCode::bad_input, std::string("controller/velocity/") + key,
              fmt::format("{:g}{}: must be positive and finite", value, unit));
}

void require_window(int window, const char* key) {
  if (window >= 1) return;
  throw Error(ErrorCode::bad_input, std::string("controller/velocity/") + key,
              fmt::format("{} samples: must be at least 1", window));
}

struct Check {
  double period;

  void operator()(const DifferenceEstimator& e) const { require_window(e.window, "window"); }

  void operator()(const FilteredDifferenceEstimator& e) const {
    require_positive(e.cutoff_hz, "cutoff", " Hz");
  }

  void operator()(const ButterworthEstimator& e) const {
    if (e.order < 1 || e.order > 8) {
      throw Error(ErrorCode::bad_input, "controller/velocity/order",
                  fmt::format("{}: must be 1 to 8", e.order));
    }
    require_positive(e.cutoff_hz, "cutoff", " Hz");
    const double nyquist_hz = 0.5 / period;
    if (e.cutoff_hz < nyquist_hz) return;
    throw Error(ErrorCode::bad_input, "controller/velocity/cutoff",
                fmt::format("{:g} Hz: must be below {:g} Hz, the Nyquist frequency at a period of "
                            "{:g} s",
                            e.cutoff_hz, nyquist_hz, period));
  }

  void operator()(const AdaptiveWindowEstimator& e) const {
    if (!(e.noise > 0 && std::isfinite(e.noise))) {
      throw Error(ErrorCode::bad_input, "controller/velocity/noise",
                  fmt::format("{:g}: must be positive: give the noise itself, or the sensor a "
                              "quantum, which it is then taken from",
                              e.noise));
    }
    require_window(e.max_window, "max_window");
  }

  void operator()(const LevantEstimator& e) const {
    require_positive(e.acceleration_bound, "acceleration_bound", "");
    require_positive(e.root_gain, "root_gain", "");
    if (e.sign_gain > 1 && std::isfinite(e.sign_gain)) return;
    throw Error(ErrorCode::bad_input, "controller/velocity/sign_gain",
                fmt::format("{:g}: must be above 1: below, the estimate cannot follow the "
                            "acceleration that it is meant for",
                            e.sign_gain));
  }
};

DiscreteStateSpace make_difference(int window, double period) {
  // The state is the last n samples, newest first.
  DiscreteStateSpace law;
  law.A = Eigen::MatrixXd::Zero(window, window);
  for (int i = 1; i < window; ++i) law.A(i, i - 1) = 1;
  law.B = Eigen::VectorXd::Unit(window, 0);
  law.C = Eigen::RowVectorXd::Zero(window);
  law.C(window - 1) = -1 / (window * period);
  law.D = 1 / (window * period);
  return law;
}

DiscreteStateSpace make_filtered_difference(double cutoff_hz, double period) {
  const double tau = 1 / (2 * pi * cutoff_hz);
  // q[k+1] = tau v[k] - y[k], so that v[k] = (q[k] + y[k]) / (tau + T).
  const double a = 1 / (tau + period);
  DiscreteStateSpace law;
  law.A = Eigen::MatrixXd::Constant(1, 1, tau * a);
  law.B = Eigen::VectorXd::Constant(1, tau * a - 1);
  law.C = Eigen::RowVectorXd::Constant(1, a);
  law.D = a;
  return law;
}

// 1/(s + 1), s in units of the cut-off, by the trapezoidal rule with w = tan(pi f_c T). The states
// of this section and the next are the trapezoidal integrators' own: near z = 1 they lose w, not
// w^2, to rounding, as the polynomials' coefficients would.
DiscreteStateSpace make_first_order_section(double w) {
  const double a = 1 / (1 + w);
  return {Eigen::MatrixXd::Constant(1, 1, 1 - 2 * w * a), Eigen::VectorXd::Constant(1, 2 * w * a),
          Eigen::RowVectorXd::Constant(1, a), w * a};
}

// 1/(s^2 + r s + 1): the states are the velocity and the output of the analog section.
DiscreteStateSpace make_second_order_section(double w, double r) {
  const double a = 1 / (1 + r * w + w * w);
  DiscreteStateSpace law;
  law.A.resize(2, 2);
  law.A << 1 - 2 * w * (r + w) * a, -2 * w * a,  //
      2 * w * a, 1 - 2 * w * w * a;
  law.B.resize(2);
  law.B << 2 * w * a, 2 * w * w * a;
  law.C.resize(2);
  law.C << w * a, 1 - w * w * a;
  law.D = w * w * a;
  return law;
}

DiscreteStateSpace make_butterworth(const ButterworthEstimator& e, double period) {
  const double w = std::tan(pi * e.cutoff_hz * period);
  DiscreteStateSpace law = make_difference(1, period);
  if (e.order % 2 == 1) law = in_series(law, make_first_order_section(w));
  for (int i = 0; i < e.order / 2; ++i)
    law = in_series(law,
                    make_second_order_section(w, 2 * std::sin(pi * (2 * i + 1) / (2 * e.order))));
  return law;
}

struct FindLaw {
  double period;

  using Found = std::optional<DiscreteStateSpace>;
  Found operator()(const DifferenceEstimator& e) const { return make_difference(e.window, period); }
  Found operator()(const FilteredDifferenceEstimator& e) const {
    return make_filtered_difference(e.cutoff_hz, period);
  }
  Found operator()(const ButterworthEstimator& e) const { return make_butterworth(e, period); }
  Found operator()(const AdaptiveWindowEstimator&) const { return std::nullopt; }
  Found operator()(const LevantEstimator&) const { return std::nullopt; }
};

struct NameOf {
  std::string_view operator()(const DifferenceEstimator&) const { return "difference"; }
  std::string_view operator()(const FilteredDifferenceEstimator&) const {
    return "filtered_difference";
  }
  std::string_view operator()(const ButterworthEstimator&) const { return "butterworth"; }
  std::string_view operator()(const AdaptiveWindowEstimator&) const { return "foaw"; }
  std::string_view operator()(const LevantEstimator&) const { return "levant"; }
};

}  // namespace

std::string_view name_of(const VelocityEstimator& estimator) {
  return std::visit(NameOf{}, estimator);
}

bool is_linear(const VelocityEstimator& estimator) {
  return !std::holds_alternative<AdaptiveWindowEstimator>(estimator) &&
         !std::holds_alternative<LevantEstimator>(estimator);
}

void check_velocity_estimator(const VelocityEstimator& estimator, double period) {
  std::visit(Check{period}, estimator);
}

std::optional<DiscreteStateSpace> find_velocity_law(const VelocityEstimator& estimator,
                                                    double period) {
  check_velocity_estimator(estimator, period);
  return std::visit(FindLaw{period}, estimator);
}

DiscreteStateSpace make_velocity_law(const VelocityEstimator& estimator, double period) {
  if (auto law = find_velocity_law(estimator, period)) return *std::move(law);
  throw Error(
      ErrorCode::bad_input, "controller/velocity/kind",
      fmt::format(
          "\"{}\" is not linear: it has no V(z), and passivity and limits of stiffness have "
          "no wall H(z) to judge; use \"difference\", \"filtered_difference\" or "
          "\"butterworth\" there, and `simulate` for this one",
          name_of(estimator)));
}

}  // namespace gyrator
