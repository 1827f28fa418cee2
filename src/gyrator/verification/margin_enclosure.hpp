#pragma once

#include "gyrator/controllers/sampling.hpp"
#include "gyrator/verification/alias_bands.hpp"

#include <optional>
#include <vector>

namespace gyrator {

/// D of (disk-3) over an interval of frequencies.
struct MarginBound {
  double middle = 0;  ///< in the middle, aliases beyond the direct ones as their bands have them
  double lowest = 0;  ///< nowhere less; -infinity where nothing is known
};

/// Encloses the margin D over intervals, without modes, Taylor models or quadrature:
///   D = R (|W|^2 - |H|^2 (w sinc Q)^2) + Im{W* V}/w - |V| |H| sinc Q                 (vm-1)
///   W = 1 + H phi M e/(jw) - j w H phi e C,   V = H phi e S A,   e = e^(-jw t_d)
///   phi = e^(-jwT/2) sinc,   sinc = sin(wT/2)/(wT/2)
/// with R = Re Z and C, Q the sums over all aliases but the base one of
///   C = sum e^(-jn rate t_d) (M + S A/(2R))/w_n^2,   Q = sum |S A|/(2R)/w_n^2.
/// V, C and Q have no pole at zero, so that (vm-1) is as sharp there as elsewhere. The first 32
/// aliases on either side are SlopeForms of their own, the rest AliasBands. A delay with a
/// fraction of a period turns the bands' phases: with z = e^(-j rate t_d),
///   |sum over n >= N of z^n f_n| <= 2 f_N/|1 - z|  for f_n falling to zero.          (vm-2)
/// Rounding is allowed for with 1e-13 of the terms.
class MarginEnclosure {
 public:
  MarginEnclosure(const HeldDevice& device, const Sampling& sampling, DiscreteStateSpace law);

  /// |w - omega| <= reach < omega.
  MarginBound over(double omega, double reach) const;

  /// 0 < w <= omega, expanded around zero itself, where Im{W* V}/w is the slope of Im{W* V}; none
  /// where the sensor does not see the port's own velocity (W then has a removable pole).
  std::optional<double> lowest_below(double omega) const;

 private:
  struct Terms;
  std::optional<Terms> collect(double omega, double reach) const;
  void add_bands(double omega, double reach, Terms& terms) const;
  double correction(const Terms& terms, double omega, double reach) const;

  HeldEnclosure device_;
  DiscreteStateSpace law_;
  bool collocated_;
  double period_, rate_, delay_;
  std::complex<double> turn_;
  bool whole_delay_;
  std::vector<AliasBand> bands_;
};

}  // namespace gyrator
