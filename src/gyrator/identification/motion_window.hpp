#pragma once

#include "gyrator/amplifiers/experiment.hpp"

#include <vector>

namespace gyrator {

/// Weighted means over a stretch of a capture. With the weight p(t) = sin^4(pi t/D), 0 <= t <= D,
/// which is zero at its ends with three derivatives, rates are found without any difference:
///   mean of x   = S p x,   mean of dx/dt = -S p' x,   mean of d^2x/dt^2 = S p'' x    (window-1)
/// S the integral over the stretch divided by that of p. So a linear differential equation of the
/// signals holds between the means exactly. Source: modulating functions, Shinbrot 1957.
struct MotionWindow {
  double time = 0;          ///< of its middle after the excitation's begin [s]
  double current = 0;       ///< [A]
  double current_rate = 0;  ///< [A/s]
  double voltage = 0;       ///< [V]; 0 where not offered
  double velocity = 0;      ///< [rad/s, m/s]
  double acceleration = 0;  ///< [rad/s^2, m/s^2]
  int direction = 0;        ///< +1 or -1 where it moves that way throughout, 0 where it may not
  double temperature = 0;   ///< of the winding [K]
  double frequency_hz = 0;  ///< of the sine that drives the run; 0: none does
  int run = 0, group = 0;   ///< for fit_grouped
};

struct WindowOptions {
  double length = 0.02;                 ///< D [s]
  double least_velocity = 0;            ///< below which a window is not sure to slide [rad/s, m/s]
  double position_quantum = 0;          ///< [rad, m]
  double default_temperature = 298.15;  ///< where the capture has none [K]
};

/// The windows of a capture, each overlapping half of the one before. Velocity and acceleration
/// come from the position, or from the velocity where there is none. Throws bad_input for a capture
/// without current or motion.
std::vector<MotionWindow> find_windows(const Capture& capture, const WindowOptions& options);

}  // namespace gyrator
