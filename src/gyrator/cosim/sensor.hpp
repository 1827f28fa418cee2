#pragma once

#include "gyrator/core/random_stream.hpp"

#include <cstdint>

namespace gyrator {

/// The sensor: to the true position comes noise, then the nearest multiple of `quantum` is taken,
/// halves up, and `offset` added.
struct Sensor {
  double quantum = 0;  ///< [m, rad]; 0 for none
  double offset = 0;   ///< [m, rad]
  double noise = 0;    ///< standard deviation of normal noise, new at each sample [m, rad]
};

// Each source of randomness of a run has a stream of its own, so that adding one changes no other.
inline constexpr std::uint64_t noise_stream = 1;
inline constexpr std::uint64_t jitter_stream = 2;
inline constexpr std::uint64_t gesture_stream = 3;

/// A sensor while it runs.
class RunningSensor {
 public:
  RunningSensor(const Sensor& sensor, std::uint64_t seed)
      : sensor_(sensor), noise_(seed, noise_stream) {}

  /// What is measured of a true position. Draws noise: once per sample.
  double read(double position);

 private:
  Sensor sensor_;
  RandomStream noise_;
};

/// The multiple of `quantum` nearest to `value`, halves up; `value` itself for a quantum of 0.
double round_to_multiple(double value, double quantum);

}  // namespace gyrator
