#include "gyrator/controllers/wave_controller.hpp"

#include "gyrator/core/error.hpp"

#include <algorithm>
#include <cmath>

#include <fmt/core.h>

namespace gyrator {
namespace {

void check(const WaveController& c) {
  if (!(c.impedance > 0 && c.volts_per_velocity > 0 && c.volts_per_command > 0)) {
    throw Error(
        ErrorCode::bad_input, "controller",
        fmt::format("wave impedance {:g}, {:g} V per velocity, {:g} V per command: all must "
                    "be above 0",
                    c.impedance, c.volts_per_velocity, c.volts_per_command));
  }
  const auto* wall = std::get_if<WaveWall>(&c.environment);
  if (wall && !(wall->damping > -c.impedance)) {
    throw Error(ErrorCode::bad_input, "controller/environment/damping",
                fmt::format("{:g}: must be above {:g}, minus the wave impedance: below, the "
                            "environment has no answer to a wave",
                            wall->damping, -c.impedance));
  }
}

}  // namespace

DiscreteStateSpace make_wave_law(const WaveController& c, double period) {
  check(c);
  const auto* wall = std::get_if<WaveWall>(&c.environment);
  if (!wall) return make_gain(0);
  // With w = W/K_t = (y - y[k-1])/(K_t T):  (b_w + B + K T/2) v = b_w w - K p[k-1]  of (wave-4),
  // and the opposing command is -U/volts_per_command = scale (w - 2 v).
  const double K = wall->stiffness;
  const double per_sample = 1 / (c.volts_per_velocity * period);
  const double scale = c.volts_per_velocity / c.volts_per_command;
  const double stiff = c.impedance + wall->damping + K * period / 2;
  const double from_wave = c.impedance / stiff * per_sample;
  const double from_position = -K / stiff;
  // States: y[k-1], and p[k-1] where there is a spring.
  const Eigen::Index n = K > 0 ? 2 : 1;
  DiscreteStateSpace law{Eigen::MatrixXd::Zero(n, n), Eigen::VectorXd::Unit(n, 0),
                         Eigen::RowVectorXd::Zero(n), scale * (per_sample - 2 * from_wave)};
  law.C(0) = -law.D;
  if (n == 2) {
    law.A(1, 0) = -period * from_wave;
    law.A(1, 1) = 1 + period * from_position;
    law.B(1) = period * from_wave;
    law.C(1) = -2 * scale * from_position;
  }
  return law;
}

RunningWaveController::RunningWaveController(const WaveController& controller, double period,
                                             double position)
    : config_(controller), period_(period), position_(position) {
  check(controller);
  if (const auto* wall = std::get_if<WaveWall>(&controller.environment)) {
    matched_ = false;
    wall_ = *wall;
  }
}

// d = p[k] - p[k-1] for which b_w d + T f = b_w T w, with f of (wave-4) or (wave-5).
double RunningWaveController::find_displacement(double wave) const {
  const double b = config_.impedance;
  const double B = wall_.damping;
  const double k = wall_.stiffness * period_ / 2;
  const double a = position_;
  const double sum = b + B + k;
  const double wanted = b * wave * period_;
  const double inside = (wanted - 2 * k * a) / sum;
  if (!wall_.unilateral) return inside;
  if (a <= 0) {
    if (wanted <= -b * a) return wanted / b;
    // Entered within the step: b d + k p^2/d + B p = wanted, p = a + d, the root with p > 0.
    const double linear = (2 * k + B) * a - wanted;
    return (-linear + std::sqrt(std::max(0.0, linear * linear - 4 * sum * k * a * a))) / (2 * sum);
  }
  if (wanted > (k - b - B) * a) return inside;
  // Left within the step, e = -d > a: b e - k a^2/e + B a = -wanted.
  const double linear = B * a + wanted;
  return -(-linear + std::sqrt(linear * linear + 4 * b * k * a * a)) / (2 * b);
}

double RunningWaveController::step(double y) {
  if (!started_) last_ = y;
  started_ = true;
  const double wave = (y - last_) / (config_.volts_per_velocity * period_);
  last_ = y;
  if (matched_) return 0;
  const double displacement = find_displacement(wave);
  position_ += displacement;
  return config_.volts_per_velocity / config_.volts_per_command *
         (2 * displacement / period_ - wave);
}

}  // namespace gyrator
