#pragma once

#include "gyrator/circuits/drive.hpp"

namespace gyrator {

/// The temperature of a winding beside a plant that runs in ticks, above its ambient:
///   C_th dh/dt = p - h/R_th                                                     (thermal-1)
/// exactly for the heat p that is constant over a tick, p = R(h) times the mean of i² of a current
/// that goes linearly from one instant to the next. R(h) = R_m (1 + alpha (T_amb + h - T_ref)) is
/// the resistance at the tick's begin.
class WindingHeat {
 public:
  /// `ambient` above the temperature at which the motor has its resistance [K], `rise` above the
  /// ambient [K], `tick` [s].
  WindingHeat(const Motor& motor, const WindingThermal& thermal, double ambient, double rise,
              double tick);

  /// One tick in which the current goes from `before` to `after` [A].
  void warm(double before, double after);

  /// So long without a current [s].
  void cool(double seconds);

  double rise() const { return rise_; }  ///< above the ambient [K]
  double resistance() const { return cold_ * (1 + alpha_ * (ambient_ + rise_)); }  ///< [ohm]

 private:
  double cold_, alpha_, ambient_, rise_;
  double time_constant_;  ///< [s]
  double keeps_;          ///< part of the rise that is left after a tick
  double by_heat_;        ///< [K/W]
};

}  // namespace gyrator
