#include "gyrator/sweeps/sweep_point.hpp"

#include "gyrator/core/bytes.hpp"
#include "gyrator/core/interrupt.hpp"
#include "gyrator/studies/parallel.hpp"

#include <algorithm>
#include <array>
#include <exception>
#include <limits>

#include <fmt/core.h>

namespace gyrator {
namespace {

PointResult fail(const SweepPlan& plan, PointStatus status, std::string reason) {
  return {status,
          std::vector<double>(plan.outputs().size(), std::numeric_limits<double>::quiet_NaN()),
          std::move(reason)};
}

}  // namespace

std::string_view name_of(PointStatus status) {
  constexpr std::array<std::string_view, 3> names{"ok", "failed", "timed_out"};
  return names.at(static_cast<std::size_t>(status));
}

PointResult compute_point(const SweepPlan& plan, std::size_t point, ErrorCode* code) {
  const TimeLimit limit(plan.study().timeout_s);
  try {
    throw_if_interrupted("study");
    const Model model = parse_model(plan.document_at(point), plan.study().model_file);
    return {PointStatus::ok, plan.analysis().compute(model), {}};
  } catch (const Error& error) {
    if (error.code() == ErrorCode::interrupted) throw;
    if (code != nullptr) *code = error.code();
    if (!limit.has_stopped()) return fail(plan, PointStatus::failed, error.what());
    // Where it was stopped depends on the machine, and has no place in a result.
    return fail(plan, PointStatus::timed_out,
                fmt::format("not done within {:g} s", *plan.study().timeout_s));
  } catch (const std::exception& error) {  // out of memory
    if (code != nullptr) *code = ErrorCode::numerical;
    return fail(plan, PointStatus::failed, error.what());
  }
}

ChunkResult compute_chunk(const SweepPlan& plan, const Chunk& chunk, int threads) {
  std::vector<std::optional<PointResult>> points(chunk.count);
  std::vector<ErrorCode> codes(chunk.count, ErrorCode::numerical);
  std::optional<Error> interrupted;
  const auto compute = [&](std::size_t i) {
    points[i] = compute_point(plan, chunk.first + i, &codes[i]);
    if (!plan.study().keep_going && points[i]->status != PointStatus::ok)
      throw Error(ErrorCode::numerical, "", "");  // ends the others; the point has the reason
  };
  try {
    if (threads == 1) {
      for (std::size_t i = 0; i < chunk.count; ++i) compute(i);
    } else {
      run_parallel(chunk.count, threads, compute);
    }
  } catch (const Error& error) {
    if (error.code() == ErrorCode::interrupted) interrupted = error;
  }
  ChunkResult result{chunk.first, {}, interrupted};
  const auto stops = [&](const std::optional<PointResult>& point) {
    return !plan.study().keep_going && point && point->status != PointStatus::ok;
  };
  // Before it may be points that were never begun, since it ended the other threads' work.
  if (const auto stop = std::find_if(points.begin(), points.end(), stops); stop != points.end()) {
    const auto i = static_cast<std::size_t>(stop - points.begin());
    const std::size_t point = chunk.first + i;
    result.stopped_by = Error(
        codes[i], fmt::format("point {} ({})", point, plan.describe_point(point)), (*stop)->reason);
  }
  for (std::size_t i = 0; i < chunk.count && points[i] && !stops(points[i]); ++i)
    result.points.push_back(std::move(*points[i]));
  return result;
}

std::string write_chunk_bytes(const ChunkResult& result) {
  ByteWriter bytes;
  bytes.put(static_cast<std::uint64_t>(result.first));
  bytes.put(static_cast<std::uint64_t>(result.points.size()));
  for (const PointResult& point : result.points) {
    bytes.put(static_cast<std::uint8_t>(point.status));
    for (const double value : point.outputs) bytes.put(value);
    bytes.put_text(point.reason);
  }
  return bytes.bytes();
}

ChunkResult read_chunk_bytes(std::string_view bytes, std::size_t outputs) {
  ByteReader reader(bytes);
  ChunkResult result;
  result.first = reader.take<std::uint64_t>();
  const auto count = reader.take<std::uint64_t>();
  for (std::uint64_t i = 0; i < count; ++i) {
    PointResult point;
    const auto status = reader.take<std::uint8_t>();
    if (status > static_cast<std::uint8_t>(PointStatus::timed_out))
      throw Error(ErrorCode::bad_input, "", "an unknown status");
    point.status = static_cast<PointStatus>(status);
    for (std::size_t k = 0; k < outputs; ++k) point.outputs.push_back(reader.take<double>());
    point.reason = reader.take_text();
    result.points.push_back(std::move(point));
  }
  return result;
}

}  // namespace gyrator
