// Where the velocities of a block's lanes cross their middle values. Compiled once per instruction
// set, as lane_kernel.inl is.

#include "gyrator/lanes/lane_program.hpp"
#include "gyrator/lanes/lane_vector.hpp"

namespace gyrator::LANE_NAMESPACE {
namespace {

// Vectors of lanes whose crossings are looked for side by side.
constexpr int pair = lanes_per_block >= 2 * vector_width ? 2 : 1;

// Of `pair` vectors from `lane` on, in rows [0, rows) of the last third.
void find_crossings_from(int lane, const double* velocity, long rows, const LaneCrossings& to) {
  Vector middle[pair], before[pair], low[pair], high[pair];
  for (int v = 0; v < pair; ++v) {
    middle[v] = load(to.middle + lane + v * vector_width);
    low[v] = high[v] = load(velocity + lane + v * vector_width);
    before[v] = low[v] - middle[v];
  }
  // Half of the range since the last crossing belongs to the cycle that ends here.
  const auto add = [&](int at, long k, double before_it, double after_it, double swing) {
    long& count = to.count[at];
    if (!to.wanted[at] || count >= to.most) return;
    if (count > 0) to.swing[at * to.most + count - 1] = swing;
    to.crossing[at * to.most + count++] =
        static_cast<double>(k) - after_it / (after_it - before_it);
  };
  for (long k = 1; k < rows; ++k) {
#pragma GCC unroll 2
    for (int v = 0; v < pair; ++v) {
      const Vector value = load(velocity + k * lanes_per_block + lane + v * vector_width);
      const Vector after = value - middle[v];
      const Mask crosses = (before[v] < 0) & (after >= 0);
      if (unsigned crossing = bits_of(crosses)) {
        const Vector swing = (high[v] - low[v]) / broadcast(2);
        for (int i = 0; i < vector_width; ++i) {
          if ((crossing >> i & 1) != 0)
            add(lane + v * vector_width + i, k, before[v][i], after[i], swing[i]);
        }
        low[v] = select(crosses, value, low[v]);
        high[v] = select(crosses, value, high[v]);
      }
      low[v] = smaller(value, low[v]);
      high[v] = larger(value, high[v]);
      before[v] = after;
    }
  }
}

}  // namespace

void find_crossings(const LaneProgram& program, const double* velocity, const LaneCrossings& to) {
  for (int lane = 0; lane < lanes_per_block; ++lane) to.count[lane] = 0;
  const double* third = velocity + program.last_third * lanes_per_block;
  for (int lane = 0; lane < lanes_per_block; lane += pair * vector_width) {
    bool any = false;
    for (int i = 0; i < pair * vector_width; ++i) any = any || to.wanted[lane + i];
    if (any) find_crossings_from(lane, third, program.samples + 1 - program.last_third, to);
  }
}

}  // namespace gyrator::LANE_NAMESPACE
