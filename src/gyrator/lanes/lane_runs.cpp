#include "gyrator/lanes/lane_runs.hpp"

#include "gyrator/core/interrupt.hpp"
#include "gyrator/lanes/lane_block.hpp"

#include <algorithm>
#include <tbb/blocked_range.h>
#include <tbb/enumerable_thread_specific.h>
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

namespace gyrator {
namespace {

// A thread's own memory.
struct Worker {
  LaneBlock block;
  std::vector<LaneDesign> designs;
  std::vector<std::vector<double>> position, velocity;  // of each lane that has to be looked at
};

// Lanes as series, in one pass over the block; of positions the last third, which is all that
// classify() reads.
void copy_lanes(Worker& worker, const std::vector<int>& lanes, long rows) {
  const long first_position = rows - rows / 3;
  for (std::size_t i = 0; i < lanes.size(); ++i) {
    worker.position[i].resize(static_cast<std::size_t>(rows));
    worker.velocity[i].resize(static_cast<std::size_t>(rows));
  }
  for (long row = 0; row < rows; ++row) {
    const auto at = static_cast<std::size_t>(row);
    for (std::size_t i = 0; i < lanes.size(); ++i)
      worker.velocity[i][at] = worker.block.velocity(row, lanes[i]);
    if (row < first_position) continue;
    for (std::size_t i = 0; i < lanes.size(); ++i)
      worker.position[i][at] = worker.block.position(row, lanes[i]);
  }
}

// As classify(), most of whose work is not needed where a lane ran away or came to rest.
void classify_block(Worker& worker, std::size_t size, const LaneScene& scene, Classification* to) {
  const LaneBlock& block = worker.block;
  const ClassificationOptions& options = scene.options.classification;
  const long rows = floor_divide(scene.options.duration, scene.sampling.period) + 1;
  const auto largest = block.half_swings(0, rows);
  const auto late = block.half_swings(rows - rows / 3 / 2, rows);
  std::vector<int> lanes;
  for (std::size_t i = 0; i < size; ++i) {
    to[i] = {};
    if (block.ran_away(static_cast<int>(i))) {
      to[i].outcome = Outcome::diverges;
    } else if (late[i] > options.rest_fraction * largest[i]) {  // else it settles
      lanes.push_back(static_cast<int>(i));
    }
  }
  copy_lanes(worker, lanes, rows);
  for (std::size_t i = 0; i < lanes.size(); ++i) {
    to[lanes[i]] = classify(worker.position[i], worker.velocity[i],
                            scene.sampling.period.to_double(), false, options);
  }
}

LaneInstructions choose_instructions(const LaneOptions& options) {
  return options.instructions.value_or(find_lane_instructions());
}

}  // namespace

std::string_view name_of(LaneInstructions instructions) {
  switch (instructions) {
    case LaneInstructions::baseline:
      return "baseline";
    case LaneInstructions::avx2:
      return "avx2";
    case LaneInstructions::avx512:
      break;
  }
  return "avx512";
}

LaneInstructions find_lane_instructions() {
#if defined(__x86_64__)
  if (__builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512dq"))
    return LaneInstructions::avx512;
  if (__builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma"))
    return LaneInstructions::avx2;
#endif
  return LaneInstructions::baseline;
}

std::vector<Classification> classify_lanes(
    const LaneScene& scene, std::size_t count,
    const std::function<void(std::size_t, LaneDesign&)>& design_of, const LaneOptions& options) {
  std::vector<Classification> result(count);
  if (count == 0) return result;
  LaneDesign example;
  design_of(0, example);
  const LaneInstructions instructions = choose_instructions(options);
  constexpr auto lanes = static_cast<std::size_t>(lanes_per_block);
  tbb::enumerable_thread_specific<Worker> workers([&] {
    return Worker{LaneBlock(scene, example, instructions, LaneBlock::Positions::last_third),
                  std::vector<LaneDesign>(lanes), std::vector<std::vector<double>>(lanes),
                  std::vector<std::vector<double>>(lanes)};
  });
  const auto run_block = [&](std::size_t block) {
    throw_if_interrupted("lanes");
    Worker& worker = workers.local();
    const std::size_t first = block * lanes;
    const std::size_t size = std::min(lanes, count - first);
    for (std::size_t i = 0; i < size; ++i) design_of(first + i, worker.designs[i]);
    worker.block.run(std::span(worker.designs).first(size));
    classify_block(worker, size, scene, result.data() + first);
    if (options.on_progress) options.on_progress(size);
  };
  const std::size_t blocks = (count + lanes - 1) / lanes;
  tbb::task_arena arena(options.threads > 0 ? options.threads : tbb::task_arena::automatic);
  arena.execute([&] { tbb::parallel_for(std::size_t{0}, blocks, run_block); });
  return result;
}

std::vector<LaneTrace> trace_lanes(const LaneScene& scene, const std::vector<LaneDesign>& designs,
                                   const LaneOptions& options) {
  std::vector<LaneTrace> traces;
  if (designs.empty()) return traces;
  LaneBlock block(scene, designs.front(), choose_instructions(options), LaneBlock::Positions::all);
  constexpr auto lanes = static_cast<std::size_t>(lanes_per_block);
  for (std::size_t first = 0; first < designs.size(); first += lanes) {
    const std::size_t size = std::min(lanes, designs.size() - first);
    block.run(std::span(designs).subspan(first, size));
    for (int lane = 0; lane < static_cast<int>(size); ++lane) {
      LaneTrace trace;
      trace.stopped_early = block.ran_away(lane);
      for (long row = 0; row < block.rows(lane); ++row) {
        trace.position.push_back(block.position(row, lane));
        trace.velocity.push_back(block.velocity(row, lane));
      }
      traces.push_back(std::move(trace));
    }
  }
  return traces;
}

}  // namespace gyrator
