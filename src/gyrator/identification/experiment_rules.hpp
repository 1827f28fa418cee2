#pragma once

#include "gyrator/identification/identification.hpp"

#include <vector>

namespace gyrator {

/// What the experiments and their plan go by.
namespace experiment_rules {

inline constexpr double first_share = 0.02;   // of the current limit, with which it begins
inline constexpr double growth = 4;           // of amplitude or speed to the next experiment
inline constexpr double wanted_ratio = 1000;  // of a sine to its standard deviation
inline constexpr double visible_ratio = 10;   // … of a motion that counts as seen
inline constexpr double settle_time = 0.05;   // before a sine is captured [s]
inline constexpr double sine_time = 0.2;      // of its capture [s]
inline constexpr int least_sine_samples = 400;
inline constexpr int least_periods = 3;  // of a sine in its capture
inline constexpr int frequency_count = 10;
inline constexpr double lowest_frequency = 40, probe_frequency = 100;  // of the sines [Hz]
inline constexpr double slowest_frequency = 0.5;                       // to look for motion [Hz]
inline constexpr double slowest_inertia = 2, fastest_motion = 40;      // [Hz]
inline constexpr int inertia_periods = 4, inertia_rounds = 8;
inline constexpr int friction_periods = 2, friction_repeats = 3;
inline constexpr double pause = 0.1;            // between motions [s]
inline constexpr int segments = 4;              // groups of windows in a run
inline constexpr double window_periods = 0.2;   // of the sine
inline constexpr double longest_window = 0.05;  // [s]

}  // namespace experiment_rules

/// The frequencies of the sines [Hz]: whole periods in the capture, so many of them that every
/// phase of the sampling is met.
std::vector<double> choose_frequencies(const BenchLimits& limits,
                                       const IdentificationOptions& options);

/// That of them at which the amplitude is found [Hz].
double find_probe_frequency(const std::vector<double>& frequencies);

/// How long a sine is played and what is captured of it.
struct SineTiming {
  CaptureRequest capture;
  double duration = 0;  ///< [s]
};
SineTiming find_sine_timing(const BenchLimits& limits, double frequency_hz);

/// Registers are whole numbers of milliseconds and hundredths of a hertz, or finer: up to the next
/// 10 ms [s], and to the nearest hundredth [Hz].
double round_duration(double seconds);
double round_frequency(double frequency_hz);

/// Sines that move the motor for its inertia: above it a window has too few samples [Hz].
double find_fastest_motion(const BenchLimits& limits);
double find_slowest_inertia(const BenchLimits& limits);

}  // namespace gyrator
