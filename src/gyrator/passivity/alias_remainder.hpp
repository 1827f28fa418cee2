#pragma once

#include "gyrator/passivity/port_taylor.hpp"

#include <array>

namespace gyrator {

/// The aliases beyond the n-th on either side, over the whole range of base frequencies at once:
///   sum_{|k|>n} e^(-jk w_s t_d) (M + S A/(2R))(j w_k)/w_k^2   and   sum_{|k|>n} |S A|/(2R)/w_k^2
/// as cubics in x = w/w_s, 0 <= x <= 1/2, with a bound on what is left out. (remainder-1)
class AliasRemainder {
 public:
  /// Beyond `direct` on either side; one by one up to `bounded`. delay [s]; `whole`: of periods.
  AliasRemainder(PortModel& model, double period, double delay, bool whole, int direct,
                 int bounded);

  /// The first sum, without its remainder.
  TaylorModel center(double omega, double reach) const;
  /// The second, with what is left out of both.
  TaylorModel radius(double omega, double reach) const;

  /// The part of radius() that is left out of the sums; not a part of the disk itself.
  double left_out() const { return left_out_; }

  /// The last of the aliases one by one whose damping its modes could not bound away from zero,
  /// so that three values stand for it; 0: none.
  int last_undamped() const { return last_undamped_; }

 private:
  using Cubic = std::array<std::complex<double>, 4>;  // coefficients of 1, x, x^2, x^3
  TaylorModel expand(const Cubic& q, double omega, double reach) const;
  void add_alias(PortModel& model, int k, double theta);
  void add_tail(PortModel& model, double from, bool whole, double theta);

  double sampling_frequency_;
  Cubic center_{}, radius_{};
  double left_out_ = 0;
  int last_undamped_ = 0;
};

}  // namespace gyrator
