#include "gyrator/sweeps/sweep_store.hpp"

#include <limits>

namespace gyrator {

SweepStore::SweepStore(std::size_t points, std::size_t outputs)
    : outputs_(outputs),
      status_(points, missing),
      values_(points * outputs, std::numeric_limits<double>::quiet_NaN()) {}

void SweepStore::add(const ChunkResult& result) {
  if (result.first > size() || result.points.size() > size() - result.first)
    throw Error(ErrorCode::bad_input, "", "holds points that the study does not have");
  for (std::size_t i = 0; i < result.points.size(); ++i) {
    const std::size_t point = result.first + i;
    const PointResult& found = result.points[i];
    if (status_[point] != missing) continue;
    status_[point] = static_cast<std::uint8_t>(found.status);
    for (std::size_t k = 0; k < outputs_; ++k) values_[point * outputs_ + k] = found.outputs[k];
    if (!found.reason.empty()) reasons_[point] = found.reason;
  }
}

std::optional<PointStatus> SweepStore::status(std::size_t point) const {
  if (status_[point] == missing) return std::nullopt;
  return static_cast<PointStatus>(status_[point]);
}

double SweepStore::output(std::size_t point, std::size_t output) const {
  return values_[point * outputs_ + output];
}

const std::string& SweepStore::reason(std::size_t point) const {
  static const std::string none;
  const auto found = reasons_.find(point);
  return found == reasons_.end() ? none : found->second;
}

SweepCounts SweepStore::count() const {
  SweepCounts counts;
  counts.points = size();
  for (std::size_t i = 0; i < size(); ++i) {
    const auto found = status(i);
    if (found == PointStatus::ok) ++counts.ok;
    if (found == PointStatus::failed) ++counts.failed;
    if (found == PointStatus::timed_out) ++counts.timed_out;
  }
  return counts;
}

std::vector<Chunk> SweepStore::find_missing() const {
  std::vector<Chunk> chunks;
  for (std::size_t i = 0; i < size(); ++i) {
    if (status_[i] != missing) continue;
    if (!chunks.empty() && chunks.back().end() == i) {
      ++chunks.back().count;
    } else {
      chunks.push_back({i, 1});
    }
  }
  return chunks;
}

}  // namespace gyrator
