#pragma once

#include "gyrator/controllers/discrete_state_space.hpp"

#include <variant>

namespace gyrator {

/// Absorbs every wave: U = 0, a damper of the wave impedance.
struct MatchedEnvironment {};

/// Spring K and damper B at position zero behind the wave line, in wave variables passive for every
/// K, B >= 0 and every period. Unilateral: it acts where the environment's position is above zero.
struct WaveWall {
  double stiffness = 0;  ///< [N.m/rad, N/m]
  double damping = 0;    ///< [N.m.s/rad, N.s/m]; above -b_w
  bool unilateral = false;
};

/// The closed list of what may lie behind the wave line.
using WaveEnvironment = std::variant<MatchedEnvironment, WaveWall>;

/// The digital end of a wave line. It reads the outgoing wave averaged over the last period (an
/// integrating converter; its sampled signal y is the integral of W [V.s]) and answers with the
/// incoming one, which the amplifier holds:
///   Wbar[k] = (y[k] - y[k-1])/T,   U[k] = Gamma Wbar[k],   command = U/volts_per_command (wave-2)
/// With v and f the environment's velocity and opposing effort,
///   U/K_t = v - f/b_w,   W/K_t = v + f/b_w,   Gamma = (b_w - Z)/(b_w + Z) for f = Z v (wave-3)
/// so that for a wall, by the trapezoidal rule with the position p,
///   p[k] = p[k-1] + T v[k],   f = K (p[k-1] + p[k])/2 + B v (wave-4) Z(z) = B + K T/2 (z + 1)/(z -
///   1),   |Gamma| <= 1 for K, B >= 0
/// Averaging and hold do not raise the norm, T Wbar^2 <= int W^2 dt and int U^2 dt = T U^2: with
/// such a Gamma the line is passive, whatever the period and the delay.
///
/// A unilateral wall keeps this: spring and damper act over the part of the step that lies inside,
///   f v T = K/2 (max(p[k], 0)^2 - max(p[k-1], 0)^2) + B v (max(p[k], 0) - max(p[k-1], 0)) (wave-5)
/// which never falls with p[k], so that exactly one v meets the incoming wave. (The rule "K x + B v
/// while x > 0" makes up to K p^2/2 of energy on the way in, and has no solution for some waves.)
///
/// p is the integral of the environment's own v: it drifts from the device's position by what
/// winding resistance and inductance take up, and by what the line cannot carry.
/// Source: Diolaiti and Niemeyer 2006, fig. 8.27; averaging and (wave-5) derived here.
struct WaveController {
  double impedance = 0;           ///< b_w [N.m.s/rad, N.s/m]
  double volts_per_velocity = 0;  ///< K_t [V.s/rad, V.s/m]
  double volts_per_command = 0;   ///< source voltage per command [V/N.m, V/N]
  WaveEnvironment environment;
};

/// H(z) from the wave's integral y to the opposing command, -Gamma (1 - z^-1)/(T
/// volts_per_command); the wall in contact. Throws bad_input for an impedance or a scale that is
/// not positive, and for a damping that is not above -b_w.
DiscreteStateSpace make_wave_law(const WaveController& controller, double period);

/// The running line. The first average counts as zero. `step` allocates nothing.
class RunningWaveController {
 public:
  /// `position`: the environment's at the start [m, rad].
  RunningWaveController(const WaveController& controller, double period, double position = 0);

  /// Command for the wave's integral y [V.s].
  double step(double y);

  double position() const { return position_; }  ///< of the environment [m, rad]

 private:
  double find_displacement(double wave) const;

  WaveController config_;
  double period_;
  bool matched_ = true;
  WaveWall wall_;
  double position_;
  double last_ = 0;
  bool started_ = false;
};

}  // namespace gyrator
