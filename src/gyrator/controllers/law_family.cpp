#include "gyrator/controllers/law_family.hpp"

#include <cmath>

namespace gyrator {

using Complex = std::complex<double>;

LawFamily::LawFamily(const Controller& controller, double period)
    : period_(period), output_(make_output_law(controller)) {
  VelocityEstimator estimator = DifferenceEstimator{};
  if (const auto* wall = std::get_if<VirtualWall>(&controller.law)) estimator = wall->velocity;
  if (const auto* wave = std::get_if<WaveController>(&controller.law)) wave_ = *wave;
  if (const auto* wall = std::get_if<PredictiveWall>(&controller.law)) predictive_ = *wall;
  velocity_ = make_velocity_law(estimator, period);
}

LawFamily::Point LawFamily::prepare(double omega) const {
  const Complex z = std::polar(1.0, omega * period_);
  return {omega, wave_ ? Complex(0) : velocity_.response(z), output_.response(z)};
}

MobiusLaw LawFamily::at_predictive(const Point& point, double virtual_damping) const {
  const Complex late = std::polar(1.0, -point.omega * period_);
  const MotionStep ahead = find_predicted_motion(*predictive_, period_);
  const ObserverGains seen = make_observer_gains(predictive_->device, period_);
  const Complex difference = seen.difference * (1.0 - late);
  const Complex command = seen.command * late;
  const double B = virtual_damping;
  return {point.output * B * ahead.vv * difference, point.output * (1.0 + ahead.xv * difference),
          1.0 + B * ahead.vw + B * ahead.vv * command, ahead.xw + ahead.xv * command};
}

MobiusLaw LawFamily::at(const Point& point, double virtual_damping) const {
  if (predictive_) return at_predictive(point, virtual_damping);
  if (!wave_) return {point.output * virtual_damping * point.velocity, point.output, 1, 0};
  const double omega = point.omega;
  // Numerator and denominator times z^(-1/2), so that neither has a difference of near numbers:
  // z^(1/2) - z^(-1/2) = 2 j sin(wT/2) and z^(1/2) + z^(-1/2) = 2 cos(wT/2).
  const Complex half = std::polar(1.0, -omega * period_ / 2);
  const Complex minus(0, 2 * std::sin(omega * period_ / 2));
  // Zero at Nyquist, where rounding would leave a spring that only 1e18 N.m/rad makes felt.
  const double cosine = std::cos(omega * period_ / 2);
  const double plus = std::abs(cosine) < 1e-12 ? 0 : 2 * cosine;
  const Complex scale = -point.output * half * minus / (period_ * wave_->volts_per_command);
  const double b_w = wave_->impedance;
  const double spring = period_ / 2 * plus;
  return {scale * minus * (b_w - virtual_damping), -scale * spring, minus * (b_w + virtual_damping),
          spring};
}

DiscreteStateSpace LawFamily::make(double stiffness, double virtual_damping) const {
  if (predictive_) {
    PredictiveWall wall = *predictive_;
    wall.stiffness = stiffness;
    wall.damping = virtual_damping;
    return in_series(make_predictive_law(wall, period_), output_);
  }
  if (!wave_) {
    const auto wall = in_parallel(make_gain(stiffness), scaled(velocity_, virtual_damping));
    return in_series(wall, output_);
  }
  WaveController wave = *wave_;
  wave.environment = WaveWall{stiffness, virtual_damping};
  return in_series(make_wave_law(wave, period_), output_);
}

bool LawFamily::has(double virtual_damping) const {
  if (predictive_) return virtual_damping >= 0;
  return !wave_ || virtual_damping > -wave_->impedance;
}

std::optional<double> LawFamily::line_stiffness() const {
  if (!wave_) return std::nullopt;
  return 2 * wave_->impedance / period_;
}

}  // namespace gyrator
