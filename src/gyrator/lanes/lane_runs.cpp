#include "gyrator/lanes/lane_runs.hpp"

#include "gyrator/core/interrupt.hpp"
#include "gyrator/lanes/lane_block.hpp"

#include <algorithm>
#include <array>
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
  std::vector<double> position, velocity;
};

// The whole run of a lane; of positions, the last third.
Classification classify_whole(Worker& worker, int lane, const LaneScene& scene) {
  const long rows = worker.block.rows(lane);
  worker.position.resize(static_cast<std::size_t>(rows));
  worker.velocity.resize(static_cast<std::size_t>(rows));
  for (long row = 0; row < rows; ++row)
    worker.velocity[static_cast<std::size_t>(row)] = worker.block.velocity(row, lane);
  for (long row = rows - rows / 3; row < rows; ++row)
    worker.position[static_cast<std::size_t>(row)] = worker.block.position(row, lane);
  return classify(worker.position, worker.velocity, scene.sampling.period.to_double(), false,
                  scene.options.classification);
}

// As classify(), most of whose work is not needed where a lane ran away or came to rest.
void classify_block(Worker& worker, std::size_t size, const LaneScene& scene, Classification* to) {
  LaneBlock& block = worker.block;
  const ClassificationOptions& options = scene.options.classification;
  const double period = scene.sampling.period.to_double();
  std::array<bool, lanes_per_block> goes_on{};
  std::array<RunSizes, lanes_per_block> sizes{};
  for (std::size_t i = 0; i < size; ++i) {
    const int lane = static_cast<int>(i);
    to[i] = {};
    if (block.ran_away(lane)) {
      to[i].outcome = Outcome::diverges;
      continue;
    }
    sizes[i] = block.sizes(lane);
    goes_on[i] = sizes[i].last_swing > options.rest_fraction * sizes[i].largest_swing;
  }
  block.find_cycles(goes_on);
  for (std::size_t i = 0; i < size; ++i) {
    if (!goes_on[i]) continue;
    const int lane = static_cast<int>(i);
    const auto found = classify_cycles(block.cycles(lane), sizes[i], period, options);
    to[i] = found ? *found : classify_whole(worker, lane, scene);
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
                  std::vector<LaneDesign>(lanes),
                  {},
                  {}};
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
