#include "gyrator/sweeps/sweep_queue.hpp"

#include <algorithm>

namespace gyrator {

SweepQueue::SweepQueue(const std::vector<Chunk>& missing, std::size_t workers)
    : missing_(missing.begin(), missing.end()), workers_(std::max<std::size_t>(1, workers)) {
  for (const Chunk& chunk : missing_) left_ += chunk.count;
}

std::optional<Chunk> SweepQueue::take(std::size_t wanted) {
  const std::lock_guard lock(mutex_);
  if (stopped_ || missing_.empty()) return std::nullopt;
  const std::size_t share = std::max<std::size_t>(1, left_ / (2 * workers_));
  Chunk& front = missing_.front();
  const Chunk chunk{front.first, std::min({front.count, share, std::max<std::size_t>(1, wanted)})};
  front.first += chunk.count;
  front.count -= chunk.count;
  left_ -= chunk.count;
  if (front.count == 0) missing_.pop_front();
  return chunk;
}

void SweepQueue::stop() {
  const std::lock_guard lock(mutex_);
  stopped_ = true;
}

bool SweepQueue::is_stopped() const {
  const std::lock_guard lock(mutex_);
  return stopped_;
}

void ChunkPace::note(std::size_t points, std::chrono::duration<double> time) {
  constexpr double goal = 0.25;  // [s]
  constexpr double most = 4096;  // points
  const double per_point =
      std::max(time.count(), 1e-9) / static_cast<double>(std::max<std::size_t>(1, points));
  // No more than four times as many as last time: the first point may have been an easy one.
  const double next = std::min(goal / per_point, 4.0 * static_cast<double>(points));
  wanted_ = static_cast<std::size_t>(std::clamp(next, 1.0, most));
}

}  // namespace gyrator
