#include "gyrator/sweeps/sweep_nodes.hpp"

#include "gyrator/core/bytes.hpp"
#include "gyrator/core/interrupt.hpp"

#include <atomic>
#include <chrono>
#include <exception>
#include <string>
#include <thread>
#include <vector>

namespace gyrator {
namespace {

// From a follower: how many points it wants next, why it stopped if it did, and the results of its
// last chunk. From the leader: the next chunk, of no points at the end.

std::string write_answer(const ChunkResult& result, std::size_t wanted) {
  ByteWriter bytes;
  bytes.put(static_cast<std::uint64_t>(wanted));
  const auto& error = result.stopped_by;
  bytes.put(static_cast<std::int32_t>(error ? static_cast<int>(error->code()) : 0));
  bytes.put_text(error ? error->place() : "");
  bytes.put_text(error ? error->message() : "");
  return bytes.bytes() + write_chunk_bytes(result);
}

struct Answer {
  std::size_t wanted = 0;
  ChunkResult result;
};

Answer read_answer(std::string_view bytes, std::size_t outputs) {
  ByteReader reader(bytes);
  Answer answer;
  answer.wanted = reader.take<std::uint64_t>();
  const auto code = reader.take<std::int32_t>();
  const std::string place = reader.take_text();
  const std::string message = reader.take_text();
  answer.result = read_chunk_bytes(reader.left(), outputs);
  if (code != 0) answer.result.stopped_by = Error(static_cast<ErrorCode>(code), place, message);
  return answer;
}

std::string write_order(const Chunk& chunk) {
  ByteWriter bytes;
  bytes.put(static_cast<std::uint64_t>(chunk.first));
  bytes.put(static_cast<std::uint64_t>(chunk.count));
  return bytes.bytes();
}

Chunk read_order(std::string_view bytes) {
  ByteReader reader(bytes);
  Chunk chunk;
  chunk.first = reader.take<std::uint64_t>();
  chunk.count = reader.take<std::uint64_t>();
  return chunk;
}

// The leader's own work, on a thread beside the one that talks to the others.
class OwnWork {
 public:
  OwnWork(const SweepPlan& plan, SweepQueue& queue, SweepRecord& record, int threads)
      : thread_([this, &plan, &queue, &record, threads] {
          try {
            work_off(plan, queue, record, threads);
          } catch (...) {
            error_ = std::current_exception();
          }
          done_.store(true);
        }) {}

  bool is_done() const { return done_.load(); }
  std::exception_ptr finish() {
    thread_.join();
    return error_;
  }

 private:
  std::atomic<bool> done_{false};
  std::exception_ptr error_;
  std::thread thread_;  // last: it uses the others
};

class Leader {
 public:
  Leader(const SweepPlan& plan, Nodes& nodes, SweepQueue& queue, SweepRecord& record)
      : plan_(plan), nodes_(nodes), queue_(queue), record_(record) {}

  bool all_wait() const { return waiting_.size() + 1 == static_cast<std::size_t>(nodes_.count()); }

  // Whether there was something to hear.
  bool listen() {
    auto message = nodes_.poll();
    if (!message) return false;
    std::size_t wanted = 1;
    try {
      const Answer answer = read_answer(message->bytes, plan_.outputs().size());
      wanted = answer.wanted;
      record_.take(answer.result);
      if (answer.result.stopped_by) queue_.stop();
    } catch (...) {
      error_ = std::current_exception();  // the journal cannot be written: all must hear of it
      queue_.stop();
    }
    if (const auto chunk = queue_.take(wanted)) {
      nodes_.send(message->from, write_order(*chunk));
    } else {
      waiting_.push_back(message->from);
    }
    return true;
  }

  void dismiss() {
    for (const int rank : waiting_) nodes_.send(rank, write_order({0, 0}));
  }

  std::exception_ptr error() const { return error_; }

 private:
  const SweepPlan& plan_;
  Nodes& nodes_;
  SweepQueue& queue_;
  SweepRecord& record_;
  std::vector<int> waiting_;
  std::exception_ptr error_;
};

}  // namespace

void lead_sweep(const SweepPlan& plan, Nodes& nodes, SweepQueue& queue, SweepRecord& record,
                int threads) {
  constexpr auto nap = std::chrono::microseconds(200);  // a chunk is a thousand times as long
  OwnWork own(plan, queue, record, threads);
  Leader leader(plan, nodes, queue, record);
  while (!own.is_done() || !leader.all_wait()) {
    if (interrupt_requested()) queue.stop();
    if (!leader.listen()) std::this_thread::sleep_for(nap);
  }
  leader.dismiss();
  const std::exception_ptr own_error = own.finish();
  nodes.finish();  // before an error is told: what is left unfinished is aborted without a word
  if (leader.error()) std::rethrow_exception(leader.error());
  if (own_error) std::rethrow_exception(own_error);
}

void follow_sweep(const SweepPlan& plan, Nodes& nodes, int threads) {
  using Clock = std::chrono::steady_clock;
  ChunkPace pace;
  ChunkResult result;
  for (;;) {
    nodes.send(0, write_answer(result, pace.wanted()));
    const Chunk chunk = read_order(nodes.wait().bytes);
    if (chunk.count == 0) return;
    const auto start = Clock::now();
    result = compute_chunk(plan, chunk, threads);
    pace.note(chunk.count, Clock::now() - start);
  }
}

}  // namespace gyrator
