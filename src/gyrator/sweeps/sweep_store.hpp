#pragma once

#include "gyrator/sweeps/sweep_point.hpp"

#include <array>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

namespace gyrator {

/// How many points have ended how.
struct SweepCounts {
  std::size_t points = 0, ok = 0, failed = 0, timed_out = 0;

  std::size_t done() const { return ok + failed + timed_out; }
};

/// The results of a sweep's points while they come in, in any order. Not for several threads.
class SweepStore {
 public:
  SweepStore(std::size_t points, std::size_t outputs);

  /// Results of a chunk within the sweep; a point that is there already stays. Throws bad_input,
  /// without a place, for one that is not.
  void add(const ChunkResult& result);

  std::size_t size() const { return status_.size(); }
  /// None while it is missing.
  std::optional<PointStatus> status(std::size_t point) const;
  double output(std::size_t point, std::size_t output) const;
  const std::string& reason(std::size_t point) const;
  SweepCounts count() const;
  /// What is missing, in order.
  std::vector<Chunk> find_missing() const;

 private:
  static constexpr std::uint8_t missing = 255;

  std::size_t outputs_;
  std::vector<std::uint8_t> status_;
  std::vector<double> values_;
  std::map<std::size_t, std::string> reasons_;
};

}  // namespace gyrator
