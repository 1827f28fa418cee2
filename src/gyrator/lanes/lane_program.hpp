#pragma once

namespace gyrator {

// What the kernel of lane_kernel.inl reads and writes. Plain data: the kernel is compiled once per
// instruction set and shares no code with the rest.

/// Designs that a block advances side by side.
inline constexpr int lanes_per_block = 16;

/// Samples between two looks at whether a lane has run away.
inline constexpr long samples_between_looks = 16;

/// What all lanes of a run have in common.
struct LaneProgram {
  int states = 0, law_states = 0;
  bool shared_plant = false;            ///< `propagate` holds one number per entry, for all lanes
  bool law_is_difference = false;       ///< q' = y: one law state, the last sample
  long samples = 0;                     ///< steps; one more row is recorded than there are steps
  long first_position = 0;              ///< row from which positions are kept
  long last_third = 0, last_sixth = 0;  ///< rows with which these begin
  int whole_delay = 0;                  ///< m of a delay m T + rest
  bool split = false;  ///< rest > 0: the command before the last still acts on the first part
  double quantum = 0;  ///< of the sensor; 0 for none
  double offset = 0;   ///< of the sensor
  double dac_quantum = 0;
  double dac_limit = 0;            ///< infinite for none
  double contact_threshold = 0;    ///< the law acts above it; -infinity: everywhere
  double most_command = 0;         ///< infinite, or 0 for a wall that may not pull
  const double* noise = nullptr;   ///< of the sensor, one per row; none
  const double* effort = nullptr;  ///< at the port, one per step
  // Coordinates of the state that are signals; -1: a row of coefficients instead.
  int sensed = -1, position = -1, velocity = -1;
  double runaway_ratio = 0;
  double period = 0;
};

/// What each lane has of its own: arrays of [entry][lane].
struct LaneCoefficients {
  double* propagate;  ///< states x (states + 3), row by row: ξ, command before, command, effort
  double* signals;    ///< 3 x states: sensed, position, velocity
  double* law;      ///< (law_states + 1) square, row by row: [A B; -C -D], the last one the command
  double* pushing;  ///< largest rate of a state per effort at the port
};

/// What a block remembers from sample to sample: arrays of [entry][lane].
struct LaneState {
  double* xi;         ///< states
  double* law;        ///< law_states
  double* commands;   ///< whole_delay + 2, those under way
  double* reference;  ///< largest size at the start
};

enum class LaneEnd : unsigned char { ran_through, ran_away };

/// Stretches of a run of which the smallest and the largest value are kept: velocities before the
/// last third, in its first half and in its second, positions in the last third.
enum class LaneStretch { early, before_last, last, position };
inline constexpr int lane_stretches = 4;

/// Rows of [sample][lane], of positions from `first_position` on, and how each lane has ended and
/// in which row.
struct LaneTraces {
  double* position;
  double* velocity;
  LaneEnd* end;
  long* rows;
  double* low;   ///< [stretch][lane]; infinite for a stretch without samples; none: not wanted
  double* high;  ///< the same, -infinite
};

/// Where velocities cross their middle value upwards in the last third of a run, per lane.
struct LaneCrossings {
  const double* middle;
  const bool* wanted;
  long most;         ///< crossings that there is room for, half the samples of the third and one
  double* crossing;  ///< [lane][i], samples after the beginning of the third
  double* swing;     ///< [lane][i], half peak-to-peak velocity from crossing i to i + 1
  long* count;       ///< crossings of each lane
};

/// Advances a block from its state at t = 0 to the end, or until every lane has run away.
using LaneKernel = void (*)(const LaneProgram&, const LaneCoefficients&, const LaneState&,
                            const LaneTraces&);
/// Of a block that has run.
using LaneCrossingsFinder = void (*)(const LaneProgram&, const double* velocity,
                                     const LaneCrossings&);

namespace lane_baseline {
LaneKernel find_kernel(const LaneProgram& program);
void find_crossings(const LaneProgram& program, const double* velocity, const LaneCrossings& to);
}  // namespace lane_baseline
namespace lane_avx2 {
LaneKernel find_kernel(const LaneProgram& program);
void find_crossings(const LaneProgram& program, const double* velocity, const LaneCrossings& to);
}  // namespace lane_avx2
namespace lane_avx512 {
LaneKernel find_kernel(const LaneProgram& program);
void find_crossings(const LaneProgram& program, const double* velocity, const LaneCrossings& to);
}  // namespace lane_avx512

}  // namespace gyrator
