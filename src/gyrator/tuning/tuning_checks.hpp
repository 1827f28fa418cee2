#pragma once

#include "gyrator/mechanics/device.hpp"
#include "gyrator/tuning/drive_response.hpp"

#include <optional>
#include <string>
#include <vector>

namespace gyrator {

/// Why a tuning must not go on, in words; none where all is as it should be. What is not finite
/// never is.

/// Whether the slowest sines of the bare drive are those of the model's motor: its back-EMF, its
/// winding, its inertia.
std::optional<std::string> find_contradiction(const std::vector<Tone>& bare, const Device& device);

/// The winding's resistance as the slowest sines measure it [ohm], weighted by their errors. Throws
/// device for one that no temperature makes of the model's.
double measure_winding(const std::vector<Tone>& tones, const Motor& motor);

/// What is left of a motion after its command has ended.
struct RingDown {
  /// Of the velocity, from the second eighth of the capture to the last [1/s]; negative: it grows.
  /// 0 where it is lost in the noise.
  double decay = 0;
  double oscillating_current = 0;  ///< root mean square in the last quarter, without its trend [A]
};
/// Throws device for a capture of fewer than 64 samples, or one that is not finite.
RingDown measure_ring_down(const Capture& capture);

/// A sign of instability: motion that grows, or a current that goes on oscillating, above a
/// twentieth of what may flow.
std::optional<std::string> find_instability(const RingDown& ring, double largest_current);

/// A sign of it to come: less than half of what should be left of the winding's resistance.
std::optional<std::string> find_shortage(double remaining, double expected);

/// Whether the model's damping is what was measured, to half of it.
std::optional<std::string> find_deviation(double measured, double modelled);

}  // namespace gyrator
