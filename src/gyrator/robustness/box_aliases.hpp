#pragma once

#include "gyrator/robustness/box_port.hpp"

#include <vector>

namespace gyrator {

/// Centre and radius of all aliases but the base one, over a band and a box, without the hold's
/// factor:
///   sum_k e^(-jk w_s t_d) (M + S A/(2R))(j w_k)/w_k^2   and   sum_k |S A|/(2R)/w_k^2,  k != 0
struct AliasSums {
  BoxModel center, radius;
  Band band;  ///< whose place d_0 is

  /// The same for a band within that one, whose own place d_0 then is:
  ///   d_0 = (omega' - omega)/reach + (reach'/reach) d_0'                           (box-11)
  AliasSums over(const Band& within) const;
};

/// The aliases over one box of parts: up to `direct` on either side for each band asked for, beyond
/// in groups of neighbours over which the response is taken to first order, once per box for all
/// base frequencies, as quadratics in x = w/w_s; from find_tail_end() on by the power law that the
/// response follows there, with twice as much again as a reserve.                        (box-8)
class BoxAliases {
 public:
  /// period [s], delay [s]; `tail_end` [rad/s]
  BoxAliases(const BoxPortModel& port, double period, double delay, int direct, double tail_end);

  /// Over a band of base frequencies, 0 <= w <= pi/T.
  AliasSums sum(const Band& band) const;

 private:
  struct Quadratic {
    BoxModel a0, a1, a2;
  };
  struct Weights;
  BoxModel expand(const Quadratic& q, const Band& band) const;
  void add_direct(AliasSums& sums, int k, const Band& band) const;
  void add_group(int first, int last);
  void add_rest(double from);

  const BoxPortModel& port_;
  double sampling_frequency_, turn_;
  int direct_;
  Quadratic center_, radius_;
  double left_out_ = 0;
};

}  // namespace gyrator
