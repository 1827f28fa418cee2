#pragma once

#include "gyrator/controllers/discrete_state_space.hpp"
#include "gyrator/controllers/linear_motion.hpp"

namespace gyrator {

/// What a controller knows of the device: m x'' + b x' = w + u, u its own command.
struct DeviceModel {
  double inertia = 0;          ///< m [kg, kg.m^2]
  double damping = 0;          ///< b [N.s/m, N.m.s/rad]
  double constant_effort = 0;  ///< w, such as a weight [N, N.m]
};

/// A spring and damper for x > 0 that knows the device, and so where it will be between samples.
///
/// Observer. From the last two positions and the command u between them (free motion (motion-1))
///   v[k-1] = (x[k] - x[k-1] - xw (w + u))/xv,   v[k] = vv v[k-1] + vw (w + u)            (pred-1)
/// exact for the model from the second sample on; zero at the first.
///
/// Half-sample prediction. A held command comes half a period late. The wall is rendered where the
/// device will be in the middle of the period, under this very command:
///   u = -(K x' + B v'),  x' = x + xv' v + xw' (w + u),  v' = vv' v + vw' (w + u)          (pred-2)
/// with (motion-1) over T/2. On an undamped mass this is lossless for every K below 8 m/T^2, where
/// the plain sampled spring, u = -K x, grows by sqrt(1 + K T^2/2m) a sample. Active for x > 0.
///
/// Dead-beat. The surface is crossed between samples: the plain wall acts too late and too long.
/// Where the model's free motion enters within the coming period, or the wall's motion leaves
/// within the coming two, the continuous wall's state r after two periods is computed with its
/// crossings, and both held commands so that the device has this state then:
///   Phi^2 s + Phi Gamma (w + u[k]) + Gamma (w + u[k+1]) = r                               (pred-3)
/// The commands may push up to a period before the contact and pull after it: they have the impulse
/// of the wall's effort and its moment. A contact shorter than three samples leaves the device
/// exactly where the continuous wall would have left it; of a longer one the middle is (pred-2),
/// whose ellipse in (x, v) differs from the wall's by the factor 1 - K T^2/8m in K/m.
///
/// Holds without command delay, with an ideal drive and without quantization. A hand is not in the
/// model: its force F shows as an error -F T/2m of the velocity.
/// Source: Gillespie and Cutkosky 1996 [section 8.5.2]; (pred-2) and (pred-3) derived here.
struct PredictiveWall {
  enum class Prediction { none, half_sample };

  double stiffness = 0;  ///< K [N/m, N.m/rad]
  double damping = 0;    ///< B [N.s/m, N.m.s/rad]
  DeviceModel device;
  Prediction prediction = Prediction::half_sample;
  bool dead_beat = true;
  bool unilateral = true;  ///< false: always in contact, for linear criteria
};

/// From a sample to where the wall is rendered: (motion-1) over T/2, or no motion at all.
MotionStep find_predicted_motion(const PredictiveWall& wall, double period);

/// u = -(position x[k] + velocity v[k] + effort w) of (pred-2) while in contact.
struct PredictiveGains {
  double position = 0, velocity = 0, effort = 0;
};
PredictiveGains make_predictive_gains(const PredictiveWall& wall, double period);

/// v[k] = difference (x[k] - x[k-1]) + command u[k-1] of (pred-1), for w = 0.
struct ObserverGains {
  double difference = 0, command = 0;
};
ObserverGains make_observer_gains(const DeviceModel& device, double period);

/// H(z) in contact, from position to opposing effort (without w), observer included. Throws
/// bad_input for an inertia that is not positive and for negative values elsewhere.
DiscreteStateSpace make_predictive_law(const PredictiveWall& wall, double period);

/// The running wall. `step` allocates nothing.
class RunningPredictiveWall {
 public:
  RunningPredictiveWall(const PredictiveWall& wall, double period);

  /// Command for the position y.
  double step(double y);

  /// What the command became on its way to the drive; the observer reckons with that.
  void take_applied(double command) { applied_ = command; }

  double velocity() const { return state_.velocity; }  ///< observed [m/s, rad/s]

 private:
  void observe(double y);
  double render() const;
  bool crosses_soon() const;
  double plan();
  MotionState follow_wall(MotionState s, double horizon) const;

  PredictiveWall wall_;
  double period_;
  LinearMotion free_, contact_;
  MotionStep step_;  // free motion over a period
  PredictiveGains gains_;
  MotionState state_;
  double applied_ = 0;
  double second_ = 0;  // u[k+1] of a plan
  bool has_second_ = false;
  bool started_ = false;
};

}  // namespace gyrator
