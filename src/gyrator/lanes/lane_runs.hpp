#pragma once

#include "gyrator/lanes/lane_design.hpp"

#include <cstddef>
#include <functional>
#include <string_view>
#include <vector>

namespace gyrator {

/// One design: which plant, under which law. The plants live as long as the run.
struct LaneDesign {
  const LanePlant* plant = nullptr;
  LaneLaw law;
};

/// Instruction sets that the kernel is compiled for.
enum class LaneInstructions { baseline, avx2, avx512 };
std::string_view name_of(LaneInstructions instructions);
/// The widest that this machine has.
LaneInstructions find_lane_instructions();

struct LaneOptions {
  int threads = 0;                                 ///< 0: all cores; changes nothing but the time
  std::optional<LaneInstructions> instructions{};  ///< the machine's widest
  /// Called after each block with the designs done since the last call, from any thread.
  std::function<void(std::size_t)> on_progress;
};

/// Classification of the runs of `count` designs, as simulate() would give it: the same samples, in
/// the same order; sums are taken in the same order, too, with one rounding less for each product
/// where the instruction set multiplies and adds at once. Lanes that run away end early; growth
/// and frequency are given for motions that go on. `design_of` fills in design i, on which a former
/// one may be left; it is called from many threads. All designs are of one kind: same number of
/// states, delay and switch; throws bad_input for others.
std::vector<Classification> classify_lanes(
    const LaneScene& scene, std::size_t count,
    const std::function<void(std::size_t, LaneDesign&)>& design_of,
    const LaneOptions& options = {});

/// Positions and velocities at the sample instants, for comparison with an engine's.
struct LaneTrace {
  std::vector<double> position, velocity;
  bool stopped_early = false;
};
std::vector<LaneTrace> trace_lanes(const LaneScene& scene, const std::vector<LaneDesign>& designs,
                                   const LaneOptions& options = {});

}  // namespace gyrator
