#pragma once

#include "gyrator/core/error.hpp"
#include "gyrator/studies/progress.hpp"
#include "gyrator/sweeps/sweep_journal.hpp"
#include "gyrator/sweeps/sweep_queue.hpp"
#include "gyrator/sweeps/sweep_store.hpp"

#include <mutex>
#include <optional>

namespace gyrator {

/// Where the results of all workers come together: first the journal, then the store. From many
/// threads.
class SweepRecord {
 public:
  SweepRecord(SweepStore& store, SweepJournal& journal, Progress& progress)
      : store_(store), journal_(journal), progress_(progress) {}

  void take(const ChunkResult& result) {
    const std::lock_guard lock(mutex_);
    journal_.append(result);
    store_.add(result);
    progress_.advance(result.points.size());
    if (result.stopped_by && !stopped_by_) stopped_by_ = result.stopped_by;
  }

  /// Why the sweep ends before its time; to be asked when all have stopped.
  const std::optional<Error>& stopped_by() const { return stopped_by_; }

 private:
  std::mutex mutex_;
  SweepStore& store_;
  SweepJournal& journal_;
  Progress& progress_;
  std::optional<Error> stopped_by_;
};

/// Computes what the queue hands out on so many threads, until it is empty or stopped.
void work_off(const SweepPlan& plan, SweepQueue& queue, SweepRecord& record, int threads);

}  // namespace gyrator
