#pragma once

#include "gyrator/controllers/controller.hpp"

#include <complex>

namespace gyrator {

/// A law at one frequency over the stiffness K, H = (p_0 + p_1 K)/(q_0 + q_1 K).
struct MobiusLaw {
  std::complex<double> p0, p1, q0, q1;

  std::complex<double> at(double stiffness) const {
    return (p0 + p1 * stiffness) / (q0 + q1 * stiffness);
  }
};

/// All walls of one kind: what a controller becomes as stiffness and virtual damping vary.
///   a wall from the position   H = K + B V(z)
///   a predictive wall      H = (K + (K xv + B vv) d)/(1 + K xw + B vw + (K xv + B vv) c z^-1),
///                          d = difference (1 - z^-1), c, difference of (pred-1), xv … of (pred-2)
///   a wall behind a wave line  H = -(1 - z^-1)/(T volts_per_command) (b_w - Z)/(b_w + Z),
///                              Z = B + K T/2 (z + 1)/(z - 1)                        (family-1)
/// A controller without a wall stands for the wall of its kind. Linear wrappers (pre-emphasis) act
/// on the output of all. Throws bad_input for a velocity estimator that is not linear
/// (make_velocity_law).
class LawFamily {
 public:
  LawFamily(const Controller& controller, double period);

  /// What depends on the frequency [rad/s] alone, to be kept for many B.
  struct Point {
    double omega = 0;
    std::complex<double> velocity;    // V
    std::complex<double> output = 1;  // of the wrappers
  };
  Point prepare(double omega) const;

  /// The law there with virtual damping B, as a function of K.
  MobiusLaw at(const Point& point, double virtual_damping) const;

  DiscreteStateSpace make(double stiffness, double virtual_damping) const;

  /// Whether a law exists at all with this B: behind a wave line, for B > -b_w;
  /// of a predictive wall, for B >= 0.
  bool has(double virtual_damping) const;

  /// Of a wave line, the stiffness that its sampling gives it, 2 b_w/T; none for a plain wall.
  std::optional<double> line_stiffness() const;

 private:
  MobiusLaw at_predictive(const Point& point, double virtual_damping) const;

  double period_;
  DiscreteStateSpace velocity_;
  std::optional<WaveController> wave_;
  std::optional<PredictiveWall> predictive_;
  DiscreteStateSpace output_;
};

}  // namespace gyrator
