#pragma once

#include "gyrator/tuning/drive_response.hpp"

#include <vector>

namespace gyrator {

/// Plays a sine, lets it settle, keeps whole periods of it and fits them (sine-1). Throws as
/// Bench::run, and device where a signal is not offered.
Tone measure_tone(Bench& bench, DriveMode mode, double amplitude, double frequency_hz);

/// Up to where a sine can be played and sampled [Hz].
double find_highest_frequency(const BenchLimits& limits);

/// Frequencies, so many and evenly spread over the logarithm, within what the bench can do. Those
/// near to the capture's rate are left out.
std::vector<double> spread_frequencies(const BenchLimits& limits, double lowest_hz,
                                       double highest_hz, int count);

}  // namespace gyrator
