#pragma once

#include "gyrator/core/error.hpp"
#include "gyrator/sweeps/sweep_plan.hpp"

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace gyrator {

enum class PointStatus : std::uint8_t { ok, failed, timed_out };
std::string_view name_of(PointStatus status);

struct PointResult {
  PointStatus status = PointStatus::ok;
  std::vector<double> outputs;  ///< nan where it failed
  std::string reason;           ///< why it failed
};

/// Points one after another.
struct Chunk {
  std::size_t first = 0;
  std::size_t count = 0;

  std::size_t end() const { return first + count; }
};

/// What has become of a chunk: of its first `points`, and why not of all.
struct ChunkResult {
  std::size_t first = 0;
  std::vector<PointResult> points;
  /// A point after them could not be computed, or the user pressed Ctrl-C.
  std::optional<Error> stopped_by;
};

/// One point, within the study's time limit. A failure is a result; throws interrupted on Ctrl-C.
PointResult compute_point(const SweepPlan& plan, std::size_t point, ErrorCode* code = nullptr);

/// The points of a chunk on `threads` cores. Without `keep_going` it ends before the first that
/// fails.
ChunkResult compute_chunk(const SweepPlan& plan, const Chunk& chunk, int threads);

/// A chunk's results in bytes, for the journal and for other processes; stopped_by is left out.
std::string write_chunk_bytes(const ChunkResult& result);
ChunkResult read_chunk_bytes(std::string_view bytes, std::size_t outputs);

}  // namespace gyrator
