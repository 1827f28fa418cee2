#pragma once

#include "gyrator/controllers/discrete_state_space.hpp"
#include "gyrator/mechanics/device.hpp"

#include <cstddef>

namespace gyrator {

/// What the operator and the wall do at worst, at the same time.
struct Operation {
  double speed = 0;          ///< of the port, amplitude [rad/s, m/s]
  double effort = 0;         ///< that the wall commands, amplitude [N.m, N]
  double frequency_hz = 10;  ///< up to which both may alternate
};

/// The largest that parts and amplifier see in it.
struct OperatingExtremes {
  double resistor_power = 0;                            ///< peak in the resistor of the damping [W]
  double capacitor_voltage = 0;                         ///< peak across its capacitor [V]
  double amplifier_voltage = 0, amplifier_current = 0;  ///< peaks [V], [A]
};

/// What the command passes before it is held: of the law [z] at the controller's period [s].
struct CommandStage {
  DiscreteStateSpace law = make_gain(1);
  double period = 1e-3;
};

/// From the network itself, with the port's velocity v imposed and the command u: each quantity is
///   q = q_v(s) v + q_u(s) F u,   at worst |q_v| speed + |q_u F| effort              (extreme-1)
/// F(e^(sT)) the output stage, in whatever phase the two come, and over the frequencies from rest
/// to the operation's. Parts are those of the damping `index` of the drive. The power is (peak
/// current)² R: a steady motion heats with all of it, an alternating one with half.
OperatingExtremes compute_operating_extremes(const Device& device, std::size_t index,
                                             const Operation& operation,
                                             const CommandStage& stage = {});

}  // namespace gyrator
