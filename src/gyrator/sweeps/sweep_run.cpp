#include "gyrator/sweeps/sweep_run.hpp"

#include "gyrator/documents/output_file.hpp"
#include "gyrator/studies/parallel.hpp"
#include "gyrator/sweeps/sweep_nodes.hpp"
#include "gyrator/sweeps/sweep_result.hpp"

#include <algorithm>
#include <chrono>
#include <optional>
#include <thread>

#include <fmt/core.h>

namespace gyrator {
namespace {

int choose_threads(int asked, bool has_processes) {
  if (asked > 0) return asked;
  return has_processes ? 1 : std::max(1, static_cast<int>(std::thread::hardware_concurrency()));
}

std::string describe_kept(const SweepStore& store, const SweepJournal& journal) {
  return fmt::format("{} of {} points are kept in {}", store.count().done(), store.size(),
                     journal.path());
}

// The error of a point, or Ctrl-C, with what is kept and how to go on.
[[noreturn]] void throw_stopped(const Error& error, const SweepStore& store,
                                const SweepJournal& journal, const std::string& output) {
  if (error.code() == ErrorCode::interrupted) {
    throw Error(error.code(), output,
                fmt::format("interrupted: {}; the same command goes on with them",
                            describe_kept(store, journal)));
  }
  throw Error(error.code(), error.place(),
              fmt::format("{} ({}; --keep-going records what fails and goes on)", error.message(),
                          describe_kept(store, journal)));
}

SweepSummary summarize(const SweepStore& store, std::size_t resumed) {
  SweepSummary summary{store.count(), resumed, {}, false};
  for (std::size_t i = 0; i < store.size() && summary.first_reason.empty(); ++i)
    summary.first_reason = store.reason(i);
  return summary;
}

// What the processes of a run tell one another before the first chunk.
class Agreement {
 public:
  explicit Agreement(Nodes* nodes) : nodes_(nodes) {}

  // Calls a step that may fail in one process and must then stop all of them.
  template <class Step>
  auto take(const Step& step) -> std::optional<decltype(step())> {
    std::optional<Error> error;
    std::optional<decltype(step())> result;
    try {
      result.emplace(step());
    } catch (const Error& caught) {
      error = caught;
    }
    if (nodes_ == nullptr) {
      if (error) throw Error(*error);
      return result;
    }
    const int code = error ? static_cast<int>(error->code()) : 0;
    // The leader's own error is told once, by the leader.
    const int leaders = nodes_->find_largest(nodes_->rank() == 0 ? code : 0);
    const int largest = nodes_->find_largest(code);
    if (largest == 0) return result;
    nodes_->finish();
    if (error && (nodes_->rank() == 0 || leaders == 0)) throw Error(*error);
    return std::nullopt;
  }

  // Whether all processes have read the same.
  bool has_same(const std::string& digest) {
    if (nodes_ == nullptr) return true;
    const int number = std::stoi(digest.substr(0, 7), nullptr, 16);
    const int largest = nodes_->find_largest(number);
    const int smallest = -nodes_->find_largest(-number);
    return largest == smallest;
  }

 private:
  Nodes* nodes_;
};

SweepSummary told_elsewhere() {
  SweepSummary summary;
  summary.is_told_elsewhere = true;
  return summary;
}

struct Kept {
  std::unique_ptr<SweepStore> store;
  std::unique_ptr<SweepJournal> journal;
  std::size_t resumed = 0;
};

Kept open_kept(const SweepPlan& plan, const SweepRequest& request) {
  check_writable(request.output);
  Kept kept;
  kept.store = std::make_unique<SweepStore>(plan.size(), plan.outputs().size());
  kept.journal = std::make_unique<SweepJournal>(journal_name(request.output), plan, *kept.store,
                                                request.restart);
  kept.resumed = kept.store->count().done();
  return kept;
}

}  // namespace

void work_off(const SweepPlan& plan, SweepQueue& queue, SweepRecord& record, int threads) {
  using Clock = std::chrono::steady_clock;
  run_parallel(static_cast<std::size_t>(threads), threads, [&](std::size_t) {
    ChunkPace pace;
    try {
      while (const auto chunk = queue.take(pace.wanted())) {
        const auto start = Clock::now();
        const ChunkResult result = compute_chunk(plan, *chunk, 1);
        pace.note(chunk->count, Clock::now() - start);
        record.take(result);
        if (result.stopped_by) queue.stop();
      }
    } catch (...) {
      queue.stop();
      throw;
    }
  });
}

SweepSummary run_study(const std::function<SweepPlan()>& prepare, const SweepRequest& request) {
  std::optional<Nodes> many;
  if (is_one_of_many()) many.emplace();
  Nodes* nodes = many ? &*many : nullptr;
  const int threads = choose_threads(request.threads, many.has_value());
  Agreement agreement(nodes);

  const std::optional<SweepPlan> plan = agreement.take(prepare);
  if (!plan) return told_elsewhere();
  const bool same = agreement.has_same(plan->digest());
  const bool follows = nodes != nullptr && nodes->rank() > 0;
  const std::optional<Kept> kept = agreement.take([&] {
    if (!same) {
      throw Error(ErrorCode::bad_input, plan->study().file,
                  "the processes of this run have not read the same study and model: put them "
                  "where all machines see them");
    }
    return follows ? Kept{} : open_kept(*plan, request);
  });
  if (!kept) return told_elsewhere();
  if (follows) {
    follow_sweep(*plan, *nodes, threads);
    nodes->finish();
    return told_elsewhere();
  }

  SweepStore& store = *kept->store;
  const auto processes = static_cast<std::size_t>(nodes != nullptr ? nodes->count() : 1);
  SweepQueue queue(store.find_missing(), static_cast<std::size_t>(threads) * processes);
  {
    Progress progress("study", store.size() - kept->resumed, request.quiet);
    SweepRecord record(store, *kept->journal, progress);
    if (nodes != nullptr) {
      lead_sweep(*plan, *nodes, queue, record, threads);
    } else {
      work_off(*plan, queue, record, threads);
    }
    if (record.stopped_by())
      throw_stopped(*record.stopped_by(), store, *kept->journal, request.output);
  }
  if (!store.find_missing().empty()) {  // Ctrl-C between two chunks
    throw_stopped(Error(ErrorCode::interrupted, "study", "interrupted"), store, *kept->journal,
                  request.output);
  }
  write_sweep_file(request.output, *plan, store, request.command_line);
  kept->journal->remove();
  return summarize(store, kept->resumed);
}

}  // namespace gyrator
