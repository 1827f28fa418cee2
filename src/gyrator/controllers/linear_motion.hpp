#pragma once

#include <optional>

namespace gyrator {

struct MotionState {
  double position = 0;  ///< [m, rad]
  double velocity = 0;  ///< [m/s, rad/s]
};

/// How m x'' + c x' + k x = w moves in a time t:
///   x(t) = xx x + xv v + xw w,   v(t) = vx x + vv v + vw w                            (motion-1)
struct MotionStep {
  double xx = 1, xv = 0, xw = 0, vx = 0, vv = 1, vw = 0;

  MotionState apply(const MotionState& s, double effort) const {
    return {xx * s.position + xv * s.velocity + xw * effort,
            vx * s.position + vv * s.velocity + vw * effort};
  }
};

/// One degree of freedom under a constant effort, in closed form.
class LinearMotion {
 public:
  /// m > 0 [kg, kg.m^2], c [N.s/m, N.m.s/rad], k >= 0 [N/m, N.m/rad], w [N, N.m].
  LinearMotion(double inertia, double damping, double stiffness, double effort);

  MotionStep step(double time) const;
  MotionState after(const MotionState& start, double time) const {
    return step(time).apply(start, effort_);
  }

  /// When within `horizon` [s] the position first leaves its side of zero: above zero if `inside`,
  /// at or below if not.
  std::optional<double> find_crossing(const MotionState& start, double horizon, bool inside) const;

 private:
  template <class Value>
  static double find_root(const Value& value, double from, double to);
  double find_turn(const MotionState& start, double from, double to) const;
  double find_passage(const MotionState& start, double from, double to, double side) const;

  double inertia_, damping_, stiffness_, effort_;
  double rate_;       // mu = -c/2m
  double spread_;     // mu^2 - k/m
  double frequency_;  // that of oscillation [rad/s]; 0 for none
};

}  // namespace gyrator
