#pragma once

#include "gyrator/regression/regression_study.hpp"

#include <optional>
#include <string>
#include <vector>

namespace gyrator {

/// Columns over time; times do not fall, and where one stands twice the columns jump.
struct TraceTable {
  std::vector<double> time_s;
  std::vector<std::vector<double>> columns;
};

/// Where a trace first leaves its tube.
struct TubeExit {
  std::size_t column = 0;
  double time_s = 0;
  double value = 0;
  double limit = 0;                       ///< the edge that it crossed
  double outside = 0;                     ///< largest distance outside, over the whole trace
  bool is_start = false, is_end = false;  ///< it does so at `value`, the reference at `limit` [s]
};

/// Where the trace leaves the tube around the reference, both linear between their rows:
///   upper(t) = max r over [t - dt, t + dt] + dy,   lower(t) = min r … - dy               (tube-1)
///   dy = absolute + relative (max r - min r)
/// r the reference's column, dt the tolerance in time. Exact between the rows too: the edges are
/// compared where any of the lines has a corner, and each row, that of a jump and a lone one too,
/// with what the window has from its first instant to its last. One that starts or ends elsewhere
/// than the reference, by more than dt, leaves it there. For tables of the tube's columns, in its
/// order.
std::optional<TubeExit> find_tube_exit(const TraceTable& trace, const TraceTable& reference,
                                       const TraceExpectation& tube);

/// The rows of a trace without which the lines between the others are wrong by more than a tenth of
/// the tube's dy in some column; first, last and jumps stay.
TraceTable thin_trace(const TraceTable& trace, const TraceExpectation& tube);

/// dy of a column over this reference.
double compute_tube_width(const TubeColumn& column, const std::vector<double>& reference);

}  // namespace gyrator
