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
std::optional<AmplifierFit> fit_amplifier(std::span<const SineMeasurement> sines, double tick);

}  // namespace gyrator
