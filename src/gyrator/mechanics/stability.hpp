#pragma once

#include "gyrator/mechanics/device.hpp"

#include <optional>
#include <string>

namespace gyrator {

/// Strongest right-half-plane pole of the plant's own dynamics [rad/s] and the element that
/// stores most of its energy; none where every pole is stable or at zero.
struct UnstablePole {
  double real = 0, imag = 0;
  std::string element;
};
std::optional<UnstablePole> find_unstable_pole(const DeviceNetwork& device);

/// The element that takes most part in the plant's fastest pole, and that pole's rate [rad/s].
struct FastestElement {
  double rate = 0;
  std::string element;
};
FastestElement find_fastest_element(const DeviceNetwork& device);

/// Throws where the device alone, without the loop of a held impedance, is unstable: bad_input
/// naming the cancellation and what it may be, else numerical naming pole and element.
void require_stable_device(const Device& device);

/// How far a drive that cancels its winding, or feeds back its back-EMF, is from oscillating by
/// itself with the port held in one way.
struct StabilityEdge {
  /// First cancelled resistance R_c at which it oscillates [ohm]; none without a cancellation.
  std::optional<double> cancellation;
  /// Winding temperature rises between which it is stable [K]; none where nothing bounds it down to
  /// a winding without resistance or up to `hottest_rise`.
  std::optional<double> coldest_rise, hottest_rise;
};
inline constexpr double hottest_rise = 400;  // [K]; no winding survives more

struct StabilityEdges {
  StabilityEdge clamped, free;
};

/// None for a drive whose stability does not hang on its winding's resistance.
std::optional<StabilityEdges> find_stability_edges(const Device& device);

}  // namespace gyrator
