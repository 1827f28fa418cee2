#pragma once

#include <optional>
#include <variant>
#include <vector>

namespace gyrator {

// What is added to a wall's effort for a short time after contact, in proportion to the velocity of
// impact: open loop, so that it makes no stiff wall unstable, and felt by the receptors for
// vibration, which tell hard from soft.

/// A constant push for `duration` that takes out momentum as fast as a damper g at the velocity of
/// impact would,
///   effort = min(g, m/(n T)) v,  for n = max(1, duration/T rounded) samples             (brake-1)
/// never more than stops the device: m v of momentum, where its inertia m is given. g = m/T over
/// one sample stops a free device there and then. Source: Salcudean and Vlaar 1997; the limit
/// derived here.
struct BrakingPulse {
  double damping = 0;                  ///< g [N.s/m, N.m.s/rad]
  double duration = 0;                 ///< [s]; at least one sample is made of it
  std::optional<double> inertia = {};  ///< m [kg, kg.m^2]
};

/// Q(t) = A(v) e^(-B t) sin(w t) with A(v) = gain v                               [8.49] (event-1)
/// taken in the middle of each sample period. The first 14 time constants are played.
/// Source: Okamura et al. 1998, 2001; gain, decay and frequency belong to a material, a geometry
/// and a display together and have to be measured.
struct EventTransient {
  double gain = 0;          ///< A/v [N.s/m, N.m.s/rad]
  double decay_time = 0;    ///< 1/B [s]
  double frequency_hz = 0;  ///< w/2 pi, below half the sampling rate
};

/// Opposing acceleration a(t) = A v e^(-B t) sin(w t) with A such that, played to its end, it
/// changes the velocity by `velocity_change` times that of impact: A = velocity_change (B^2 +
/// w^2)/w.
struct DecayingSine {
  double velocity_change = 0;  ///< 1 stops a free device
  double decay_time = 0;       ///< 1/B [s]
  double frequency_hz = 0;
};

/// An opposing acceleration as it was measured after an impact at `velocity`, linear between the
/// samples, the first at the moment of contact; zero after the last.
struct RecordedTransient {
  std::vector<double> acceleration;  ///< [m/s^2, rad/s^2]
  double time_step = 0;              ///< [s]
  double velocity = 0;               ///< [m/s, rad/s]
};

/// An acceleration transient through the inverse of the device m v' + b v = u: the effort that,
/// held over each period, gives a free device at every sample instant the velocity of the
/// transient,
///   u[k] = b (v[k+1] - e v[k])/(1 - e),  v[k] = int_0^{kT} a dt,  e = exp(-b T/m)       (match-1)
/// which is m (v[k+1] - v[k])/T for b = 0. It goes over into J a + b v as T -> 0. The velocity that
/// is left at the end is not braked away further: with b > 0 the wall takes over there.
/// Source: Kuchenbecker et al. 2006; (match-1) derived here.
struct AccelerationMatching {
  double inertia = 0;  ///< m of the device [kg, kg.m^2]
  double damping = 0;  ///< b of the device [N.s/m, N.m.s/rad]
  std::variant<DecayingSine, RecordedTransient> transient = DecayingSine{};
};

/// Opposing effort per velocity of impact [N.s/m, N.m.s/rad], sample by sample from the one that
/// finds the device in contact; `period` in s. Throws bad_input for what has no such course.
std::vector<double> make_effect_course(const BrakingPulse& pulse, double period);
std::vector<double> make_effect_course(const EventTransient& transient, double period);
std::vector<double> make_effect_course(const AccelerationMatching& matching, double period);

/// Plays a course at each contact: when the sampled position comes from at or below zero to above
/// it, at the velocity of that last step. Ends with the course or when the contact ends. `step`
/// allocates nothing.
class RunningContactEffect {
 public:
  RunningContactEffect(std::vector<double> course, double period)
      : course_(std::move(course)), period_(period), next_(course_.size()) {}

  double step(double y, double command) {
    const bool inside = y > 0;
    if (!inside) next_ = course_.size();
    if (inside && outside_) {
      velocity_ = (y - last_) / period_;
      next_ = 0;
    }
    outside_ = !inside;
    last_ = y;
    return next_ < course_.size() ? command - velocity_ * course_[next_++] : command;
  }

 private:
  std::vector<double> course_;
  double period_;
  std::size_t next_;
  double velocity_ = 0;
  double last_ = 0;
  bool outside_ = false;  // a run that starts inside has seen no impact
};

}  // namespace gyrator
