#pragma once

#include "gyrator/robustness/box_disk.hpp"

#include <functional>
#include <string>
#include <vector>

namespace gyrator {

enum class BoxOutcome {
  passive,      ///< with every choice of parts in the box
  not_passive,  ///< with the parts `at`
  undecided     ///< the budget is used up, or too close at `at`
};

struct BoxProof {
  BoxOutcome outcome = BoxOutcome::undecided;
  std::size_t boxes = 0;      ///< looked at
  std::size_t intervals = 0;  ///< of frequency, over all of them
  std::vector<double> at;     ///< parts of the counterexample, or where it is undecided
  double omega = 0;           ///< frequency there [rad/s]
  double margin = 0;   ///< D there [N.s/m, N.m.s/rad]; for passive the lowest bound of all, NaN
                       ///< where the loop is unstable with nothing attached
  std::string reason;  ///< where undecided, or unstable with nothing attached: why
};

struct BoxBudget {
  std::size_t most_boxes = 20000;
  double seconds = 600;
  int threads = 0;  ///< 0: all cores; changes nothing but the time
};

/// Proves the sampled loop passive for every device of a box of parts, by branch and bound over
/// frequency and parts: D > 0 (box-9) on intervals of frequency times boxes that together are all
/// of both. What is not yet positive is divided along whatever widens its bound most; where the
/// linear part says that a corner fails, the point proof (prove_disk) of that corner decides.
///
/// One stable device proves all stable: D > 0 and Re Z > 0 for every device at every frequency up
/// to pi/T, at rest included, and Re Z > 0 beyond. The loop's poles move continuously with the
/// parts through the box; on the unit circle none can be, since the free port (Σ = 0) is among the
/// passive operators that D > 0 excludes there. Nor can the device's own cross the imaginary axis:
/// M_rr is regular on it with the port held (box-7), Z != 0 with the port free.
///
/// `whole.half` > 0 in each part. Throws bad_input for a device or law to which this does not
/// apply, interrupted by the user as others. `progress` is told the share of the box's volume that
/// is done.
BoxProof prove_box(const DeviceMaker& maker, const PartBox& whole, const Sampling& sampling,
                   const DiscreteStateSpace& law, const BoxBudget& budget = {},
                   const std::function<void(double)>& progress = {});

}  // namespace gyrator
