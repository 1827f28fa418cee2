#include "gyrator/core/statistics.hpp"

#include "gyrator/core/error.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace gyrator {
namespace {

// From 0; equal values share the mean of theirs.
std::vector<double> find_ranks(std::span<const double> values) {
  std::vector<std::size_t> order(values.size());
  std::iota(order.begin(), order.end(), 0);
  std::sort(order.begin(), order.end(),
            [&](std::size_t a, std::size_t b) { return values[a] < values[b]; });
  std::vector<double> ranks(values.size());
  for (std::size_t i = 0; i < order.size();) {
    std::size_t end = i;
    while (end < order.size() && values[order[end]] == values[order[i]]) ++end;
    for (std::size_t k = i; k < end; ++k)
      ranks[order[k]] = (static_cast<double>(i) + static_cast<double>(end - 1)) / 2;
    i = end;
  }
  return ranks;
}

}  // namespace

double find_quantile(std::span<const double> sorted, double p) {
  if (sorted.empty()) throw Error(ErrorCode::bad_input, "quantile", "no values");
  const double n = static_cast<double>(sorted.size());
  const auto k = static_cast<std::size_t>(std::clamp(std::ceil(p * n), 1.0, n));
  return sorted[k - 1];
}

Share compute_share(std::size_t k, std::size_t n) {
  if (n == 0) throw Error(ErrorCode::bad_input, "share", "of nothing");
  constexpr double z = 1.959963984540054;
  const auto total = static_cast<double>(n);
  const double p = static_cast<double>(k) / total;
  const double centre = p + z * z / (2 * total);
  const double reach = z * std::sqrt(p * (1 - p) / total + z * z / (4 * total * total));
  const double scale = 1 + z * z / total;
  // Where none or all succeed the end is 0 or 1, but for rounding.
  return {p, k == 0 ? 0 : (centre - reach) / scale, k == n ? 1 : (centre + reach) / scale};
}

double compute_rank_correlation(std::span<const double> x, std::span<const double> y) {
  const std::vector<double> a = find_ranks(x);
  const std::vector<double> b = find_ranks(y);
  const double mean = (static_cast<double>(a.size()) - 1) / 2;
  double ab = 0;
  double aa = 0;
  double bb = 0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    ab += (a[i] - mean) * (b[i] - mean);
    aa += (a[i] - mean) * (a[i] - mean);
    bb += (b[i] - mean) * (b[i] - mean);
  }
  return aa > 0 && bb > 0 ? ab / std::sqrt(aa * bb) : 0;
}

}  // namespace gyrator
