#pragma once

#include "gyrator/sweeps/sweep_point.hpp"

#include <chrono>
#include <cstddef>
#include <deque>
#include <mutex>
#include <optional>
#include <vector>

namespace gyrator {

/// The points that are still to be computed, handed out to whoever has time. From many threads.
class SweepQueue {
 public:
  /// For so many workers.
  SweepQueue(const std::vector<Chunk>& missing, std::size_t workers);

  /// The next points, `wanted` at the most and fewer towards the end, so that all end together;
  /// none when all are handed out or stop() was called.
  std::optional<Chunk> take(std::size_t wanted);
  void stop();
  bool is_stopped() const;

 private:
  mutable std::mutex mutex_;
  std::deque<Chunk> missing_;
  std::size_t left_ = 0;
  std::size_t workers_;
  bool stopped_ = false;
};

/// How many points a worker takes at once: about a quarter of a second's work, which is what a
/// crash loses and what a look at the disk (some milliseconds) is small against.
class ChunkPace {
 public:
  std::size_t wanted() const { return wanted_; }
  /// So many points have taken so long.
  void note(std::size_t points, std::chrono::duration<double> time);

 private:
  std::size_t wanted_ = 1;
};

}  // namespace gyrator
