#include "gyrator/cosim/rate_hardness.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <vector>

namespace gyrator {
namespace {

// Rows of the sample instants: rows in between, and the second row of a hold's edge, are left out.
std::vector<std::size_t> find_sample_rows(const std::vector<double>& time, double period) {
  std::vector<std::size_t> rows;
  for (std::size_t row = 0; row < time.size(); ++row) {
    const double next = static_cast<double>(rows.size()) * period;
    if (time[row] >= next * (1 - 1e-12)) rows.push_back(row);
  }
  return rows;
}

}  // namespace

std::optional<double> find_rate_hardness(const Trace& trace, double period) {
  const auto& names = trace.names;
  if (std::find(names.begin(), names.end(), "measured_position") == names.end())
    return std::nullopt;
  const auto& position = trace.column("measured_position");
  const auto& command = trace.column("command");
  const auto rows = find_sample_rows(trace.column("time_s"), period);
  for (std::size_t k = 1; k + 1 < rows.size(); ++k) {
    const double before = position[rows[k - 1]];
    const double now = position[rows[k]];
    if (!(before <= 0 && now > 0)) continue;
    const double since = now / (now - before);  // periods from the crossing to sample k
    const double start = command[rows[k - 1]];
    const double first = start - command[rows[k]];
    const double second = start - command[rows[k + 1]];
    const double rate_hardness = (since * first + (1 - since) * second) / (now - before);
    if (rate_hardness < 0) return std::nullopt;
    return rate_hardness == 0 ? 0.0 : rate_hardness;
  }
  return std::nullopt;
}

}  // namespace gyrator
