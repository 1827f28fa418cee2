#pragma once

#include <cstddef>
#include <span>
#include <vector>

namespace gyrator {

/// The smallest of the values that at least a share p of them does not exceed; infinities are
/// values as others.
///   x_(k),  k = max(1, ceil(p n))                                                  (stat-1)
/// `sorted` rises; p in [0, 1]. Throws bad_input for no values.
double find_quantile(std::span<const double> sorted, double p);

struct Share {
  double value = 0;          ///< k/n
  double low = 0, high = 0;  ///< ends of the interval
};

/// A share k/n with Wilson's 95 % interval: all probabilities P for which k of n lies within z
/// standard deviations sqrt(n P (1 - P)) of n P,
///   (p + z^2/(2n) ± z sqrt(p (1 - p)/n + z^2/(4 n^2)))/(1 + z^2/n),  z = 1.959964    (stat-2)
/// which says something of n successes out of n too. Source: Wilson 1927. Throws bad_input for
/// n = 0.
Share compute_share(std::size_t k, std::size_t n);

/// Spearman's coefficient: the correlation of the ranks, in [-1, 1]; equal values share the mean
/// of their ranks. 0 where one of the two does not vary.                             (stat-3)
double compute_rank_correlation(std::span<const double> x, std::span<const double> y);

}  // namespace gyrator
