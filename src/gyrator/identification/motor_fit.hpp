#pragma once

#include "gyrator/identification/grouped_fit.hpp"
#include "gyrator/identification/held_lag.hpp"
#include "gyrator/identification/motion_window.hpp"
#include "gyrator/identification/sine_measurement.hpp"

#include <complex>
#include <optional>
#include <span>
#include <vector>

namespace gyrator {

/// What the motion is made of, in amperes, as it is before K is known.
struct MotionFit {
  GroupedFit fit;  ///< J/K [A s^2/rad], b/K [A s/rad], f_c/K [A], offset [A]
  int slides = 0;  ///< windows that count
  double inertia() const { return fit.values[0]; }
  double damping() const { return fit.values[1]; }
  double friction() const { return fit.values[2]; }
};

/// Least squares over the windows that slide, of
///   i = (J/K) dw/dt + (b/K) w + (f_c/K) sgn w + i_0                                  (motion-1)
/// i is the current's mean, which differs from its samples by (lag-4) where the lag is known. i_0
/// is the current sensor's offset and any torque that does not turn with the motion. The noise is
/// the current's: what stands right of it is known from the encoder. Throws numerical for too few
/// windows.
MotionFit fit_motion(std::span<const MotionWindow> windows,
                     const std::optional<HeldLag>& lag = std::nullopt);

/// The speed of the sine that the current drives through inertia, viscous and dry friction, whose
/// own sine is 4 f_c/pi against it (describing function),
///   (jw J + b) W + (4/pi) f_c W/|W| = K I                                             (motion-2)
/// and 0 where that is more than K |I|.
std::complex<double> compute_sine_velocity(const MotionFit& motion, std::complex<double> current,
                                           double frequency_hz);

/// The winding.
struct WindingFit {
  GroupedFit fit;  ///< R at 298.15 K [ohm], L [H], K [N.m/A], voltage offset [V]
  int age = 1;     ///< of the command that acts at the sampled instant (lag-3), in ticks
};

struct WindingOptions {
  std::optional<HeldLag> lag;  ///< none: dy/dt is taken to be jw y
  std::optional<MotionFit> motion;
  double position_quantum = 0;
  double temperature_coefficient = 0.00393;
};

/// Least squares over sines and windows together, of
///   V = R (1 + a (h - 298.15 K)) I + L dI/dt + K W (+ v_0 in the windows)            (winding-1)
/// h the winding's temperature. The sines' dI/dt is that of (lag-3). W is whichever is surest of
/// the position's, the velocity's and (motion-2)'s. Each equation is weighted by the noise of all
/// three signals in it,
///   s^2 = s_V^2 + |Z|^2 s_I^2 + K^2 s_W^2                                            (winding-2)
/// (errors in variables; sines are means of so many samples that the bias, of the order of
/// s_I^2/|I|^2, is nothing). None without a voltage.
std::optional<WindingFit> fit_winding(std::span<const SineMeasurement> sines,
                                      std::span<const MotionWindow> windows,
                                      const WindingOptions& options);

/// The right side of (winding-1) for a sine [V].
std::complex<double> compute_terminal_voltage(const SineMeasurement& sine, const WindingFit& fit,
                                              const WindingOptions& options);

/// The mean of (lag-4) of a window's current [A].
double find_mean_current(const MotionWindow& window, const std::optional<HeldLag>& lag);

/// The velocity that fit_winding takes, with its deviation.
Phasor choose_velocity(const SineMeasurement& sine, const WindingOptions& options);

}  // namespace gyrator
