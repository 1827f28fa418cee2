#pragma once

#include "gyrator/cosim/classification.hpp"

#include <cstddef>
#include <optional>
#include <span>

namespace gyrator {

/// One oscillation of the velocity, between two upward crossings of its middle value.
struct MotionCycle {
  double start = 0, end = 0;  ///< [samples]
  double swing = 0;           ///< half peak-to-peak velocity
};

/// Sizes of a run.
struct RunSizes {
  std::size_t samples = 0;   ///< of the whole run
  double largest_swing = 0;  ///< half the peak-to-peak velocity of the whole run
  double last_swing = 0;     ///< the same of its last sixth
  double amplitude = 0;      ///< half the peak-to-peak position of the last third
};

/// classify() of a run with these cycles at its end; none where they are too few to tell.
std::optional<Classification> classify_cycles(std::span<const MotionCycle> cycles,
                                              const RunSizes& sizes, double period,
                                              const ClassificationOptions& options);

}  // namespace gyrator
