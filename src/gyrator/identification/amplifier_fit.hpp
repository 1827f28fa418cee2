#pragma once

#include "gyrator/identification/grouped_fit.hpp"
#include "gyrator/identification/held_lag.hpp"
#include "gyrator/identification/sine_measurement.hpp"

#include <optional>
#include <span>

namespace gyrator {

/// The first-order lag from command to current, and the gain between the two.
struct AmplifierFit {
  GroupedFit fit;  ///< gain, time constant [s], delay [s]
  HeldLag lag(double tick) const { return {fit.values[1], fit.values[2], tick}; }
};

/// Fits
///   I/U = g Y/U                                                                      (lag-2)
/// to the sines, each weighted by its noise, by Levenberg's and Marquardt's steps within every tick
/// of delay (Y/U has a kink at whole ones) from the best of a grid. None where the command was not
/// captured at three sines of different groups. A time constant below 2 us counts as that.
/// The variances are the larger ones of the jackknife and of the curvature of the squares.
std::optional<AmplifierFit> fit_amplifier(std::span<const SineMeasurement> sines, double tick);

/// The same with what was asked of the generator in place of the captured command. Its delay holds
/// whatever time lies between generator and capture, so it is good for (lag-3) and (lag-4) only.
std::optional<AmplifierFit> fit_apparent_amplifier(std::span<const SineMeasurement> sines,
                                                   double tick);

}  // namespace gyrator
