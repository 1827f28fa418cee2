#pragma once

#include "gyrator/cosim/motion_cycles.hpp"
#include "gyrator/lanes/lane_program.hpp"
#include "gyrator/lanes/lane_runs.hpp"

#include <array>
#include <span>
#include <vector>

#include <boost/align/aligned_allocator.hpp>

namespace gyrator {

/// Memory and program of one block of lanes, made once and used for block after block.
class LaneBlock {
 public:
  enum class Positions { all, last_third };  // what fits a core's own memory is faster

  /// For designs of the size of `example`.
  LaneBlock(const LaneScene& scene, const LaneDesign& example, LaneInstructions instructions,
            Positions kept);

  /// Advances up to lanes_per_block designs to their end.
  void run(std::span<const LaneDesign> designs);

  long rows(int lane) const { return end_rows_[static_cast<std::size_t>(lane)]; }
  bool ran_away(int lane) const {
    return ends_[static_cast<std::size_t>(lane)] == LaneEnd::ran_away;
  }
  double position(long row, int lane) const {
    return position_[static_cast<std::size_t>((row - program_.first_position) * lanes_per_block +
                                              lane)];
  }
  double velocity(long row, int lane) const {
    return velocity_[static_cast<std::size_t>(row * lanes_per_block + lane)];
  }

  /// Of a block whose positions are kept for the last third. Sizes of the run of each lane that
  /// ran through.
  RunSizes sizes(int lane) const;
  /// Cycles in the last third of lanes `wanted`, that ran through.
  void find_cycles(const std::array<bool, lanes_per_block>& wanted);
  std::span<const MotionCycle> cycles(int lane) const {
    return cycles_[static_cast<std::size_t>(lane)];
  }

 private:
  struct Range {
    double low, high;
  };
  Range range(LaneStretch stretch, int lane) const;

  using Numbers = std::vector<double, boost::alignment::aligned_allocator<double, 64>>;

  void prepare_scene(const LaneScene& scene);
  void prepare_program(const LaneDesign& example);
  void check_kind(const LaneDesign& design) const;
  void set_plant(const LanePlant& plant, int lane);
  void set_law(const LaneLaw& law, int lane);
  void set_start(const LaneDesign& design, int lane);

  const LaneScene& scene_;
  LaneProgram program_;
  LaneKernel kernel_;
  LaneCrossingsFinder find_crossings_;
  const LanePlant* loaded_ = nullptr;  // that all lanes share
  Numbers propagate_, signals_, law_, pushing_, xi_, law_state_, commands_, reference_;
  Numbers position_, velocity_;
  Numbers low_, high_, middle_, crossing_, swing_;
  std::array<std::vector<MotionCycle>, lanes_per_block> cycles_;
  std::vector<double> noise_, efforts_;
  std::array<LaneEnd, lanes_per_block> ends_{};
  std::array<long, lanes_per_block> end_rows_{};
};

}  // namespace gyrator
