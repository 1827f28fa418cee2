#include "gyrator/controllers/predictive_wall.hpp"

#include "gyrator/core/error.hpp"

#include <string>

#include <fmt/core.h>

namespace gyrator {
namespace {

constexpr int most_crossings = 16;  // within two periods

void require(bool holds, const std::string& key, double value, const char* rule) {
  if (holds) return;
  throw Error(ErrorCode::bad_input, "controller/" + key,
              fmt::format("{:g}: must be {}", value, rule));
}

const PredictiveWall& check(const PredictiveWall& wall) {
  require(wall.device.inertia > 0, "device/inertia", wall.device.inertia, "above 0");
  require(wall.device.damping >= 0, "device/damping", wall.device.damping, "at least 0");
  require(wall.stiffness >= 0, "stiffness", wall.stiffness, "at least 0");
  require(wall.damping >= 0, "damping", wall.damping, "at least 0");
  return wall;
}

LinearMotion make_free_motion(const DeviceModel& device) {
  return {device.inertia, device.damping, 0, device.constant_effort};
}

}  // namespace

MotionStep find_predicted_motion(const PredictiveWall& wall, double period) {
  const bool half = wall.prediction == PredictiveWall::Prediction::half_sample;
  return half ? make_free_motion(wall.device).step(period / 2) : MotionStep{};
}

PredictiveGains make_predictive_gains(const PredictiveWall& wall, double period) {
  check(wall);
  const MotionStep m = find_predicted_motion(wall, period);
  const double K = wall.stiffness;
  const double B = wall.damping;
  const double under_own_command = 1 + K * m.xw + B * m.vw;
  return {K / under_own_command, (K * m.xv + B * m.vv) / under_own_command,
          (K * m.xw + B * m.vw) / under_own_command};
}

ObserverGains make_observer_gains(const DeviceModel& device, double period) {
  const MotionStep m = make_free_motion(device).step(period);
  return {m.vv / m.xv, m.vw - m.vv * m.xw / m.xv};
}

DiscreteStateSpace make_predictive_law(const PredictiveWall& wall, double period) {
  const PredictiveGains gains = make_predictive_gains(wall, period);
  if (gains.velocity == 0) return make_gain(gains.position);
  const ObserverGains seen = make_observer_gains(wall.device, period);
  // States x[k-1] and the opposing effort o[k-1] = -u[k-1].
  DiscreteStateSpace law{Eigen::MatrixXd::Zero(2, 2), Eigen::VectorXd::Zero(2),
                         Eigen::RowVectorXd::Zero(2),
                         gains.position + gains.velocity * seen.difference};
  law.C << -gains.velocity * seen.difference, -gains.velocity * seen.command;
  law.A.row(1) = law.C;
  law.B << 1, law.D;
  return law;
}

RunningPredictiveWall::RunningPredictiveWall(const PredictiveWall& wall, double period)
    : wall_(check(wall)),
      period_(period),
      free_(make_free_motion(wall.device)),
      contact_(wall.device.inertia, wall.device.damping + wall.damping, wall.stiffness,
               wall.device.constant_effort),
      step_(free_.step(period)),
      gains_(make_predictive_gains(wall, period)) {}

void RunningPredictiveWall::observe(double y) {
  if (started_) {
    const double effort = wall_.device.constant_effort + applied_;
    const double before = (y - state_.position - step_.xw * effort) / step_.xv;
    state_.velocity = step_.vv * before + step_.vw * effort;
  }
  state_.position = y;
  started_ = true;
}

double RunningPredictiveWall::render() const {
  return -(gains_.position * state_.position + gains_.velocity * state_.velocity +
           gains_.effort * wall_.device.constant_effort);
}

bool RunningPredictiveWall::crosses_soon() const {
  if (state_.position > 0) return contact_.find_crossing(state_, 2 * period_, true).has_value();
  return free_.find_crossing(state_, period_, false).has_value();
}

MotionState RunningPredictiveWall::follow_wall(MotionState s, double horizon) const {
  bool inside = s.position > 0;
  for (int crossings = 0; crossings < most_crossings; ++crossings) {
    const LinearMotion& motion = inside ? contact_ : free_;
    const auto time = motion.find_crossing(s, horizon, inside);
    if (!time) return motion.after(s, horizon);
    s = {0, motion.after(s, *time).velocity};
    horizon -= *time;
    inside = !inside;
  }
  return s;
}

double RunningPredictiveWall::plan() {
  const double w = wall_.device.constant_effort;
  const MotionState wanted = follow_wall(state_, 2 * period_);
  const MotionState coasting = step_.apply(step_.apply(state_, w), w);
  // What u[k] and u[k+1] each leave behind after two periods.
  const MotionState first = step_.apply({step_.xw, step_.vw}, 0);
  const MotionState second{step_.xw, step_.vw};
  const double x = wanted.position - coasting.position;
  const double v = wanted.velocity - coasting.velocity;
  const double det = first.position * second.velocity - second.position * first.velocity;
  second_ = (first.position * v - first.velocity * x) / det;
  has_second_ = true;
  return (x * second.velocity - v * second.position) / det;
}

double RunningPredictiveWall::step(double y) {
  observe(y);
  if (has_second_) {
    has_second_ = false;
    applied_ = second_;
  } else if (!wall_.unilateral) {
    applied_ = render();
  } else if (wall_.dead_beat && crosses_soon()) {
    applied_ = plan();
  } else {
    applied_ = y > 0 ? render() : 0;
  }
  return applied_;
}

}  // namespace gyrator
