#pragma once

#include "gyrator/studies/limit_sampler.hpp"

#include <string>
#include <vector>

namespace gyrator {

/// The lowest limit found in a box, and where.
struct WorstLimit {
  LimitSample limit;
  std::vector<double> values;
  std::string found_by;  ///< "nominal", "corner", "sample", "search"
};

/// A point of the box whose limit is known.
struct BoxPoint {
  std::vector<double> values;
  LimitSample limit;
};

/// All corners of a box, where it has few enough for that (find_worst_limit).
inline constexpr std::size_t most_parts_for_corners = 10;
std::vector<std::vector<double>> list_corners(const std::vector<Tolerance>& tolerances);

struct SearchOptions {
  int threads = 0;    ///< 0: all
  bool quiet = true;  ///< no progress bar
};

/// Lowest passive limit over the box: the lowest of the points given, all corners (of at most
/// most_parts_for_corners parts) and of searches from the lowest of those, bound to the box
/// (Subplex of NLopt, no derivatives: a limit is the lowest of many over frequency, with edges
/// where another frequency takes over). What it finds is an upper bound of the true worst case;
/// only where the limit is monotonic in every part is the worst corner proven to be it.
WorstLimit find_worst_limit(const LimitSampler& sampler, const std::vector<BoxPoint>& known,
                            const SearchOptions& options);

}  // namespace gyrator
