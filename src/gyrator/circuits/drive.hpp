#pragma once

#include "gyrator/circuits/network.hpp"

#include <optional>
#include <string>
#include <variant>
#include <vector>

namespace gyrator {

/// A permanent-magnet motor, rotary or linear. K_t [N.m/A or N/A], R_m [ohm], L_m [H].
/// The power-conserving two-port e = K_t w, tau = K_t i behind the winding (equations, section 2).
struct Motor {
  double torque_constant = 0;
  double resistance = 0;
  double inductance = 0;
};

/// Which current a current amplifier regulates: all that it delivers, or what passes the winding.
enum class CurrentSense { total, motor };

/// An effort source without any circuit: A = 1.
struct IdealDrive {};

/// Current amplifier. With a bandwidth, di/dt = w_b (i_command - i_sensed), a first-order closed
/// loop whose -3 dB frequency is `bandwidth_hz` when it senses its own output; without one, ideal.
///
/// Sensing the motor current inside a damping branch holds the winding's current against the
/// back-EMF and so removes that branch's damping within the bandwidth (equations, section 3).
struct CurrentAmplifier {
  std::optional<double> bandwidth_hz;
  CurrentSense sense = CurrentSense::total;
};

/// Voltage amplifier behind `output_resistance` [ohm], first-order with -3 dB at `bandwidth_hz`.
struct VoltageAmplifier {
  std::optional<double> bandwidth_hz;
  double output_resistance = 0;
};

using Amplifier = std::variant<IdealDrive, CurrentAmplifier, VoltageAmplifier>;

/// A resistor across the motor terminals.
struct ResistorDamping {
  double resistance = 0;
};
/// R_1 in series with C across the motor terminals [8.48]. R_1 may be zero.
struct RcDamping {
  double resistance = 0;
  double capacitance = 0;
};

using Damping = std::variant<ResistorDamping, RcDamping>;

struct Drive {
  std::optional<Motor> motor;  ///< required by every amplifier but IdealDrive
  Amplifier amplifier = IdealDrive{};
  std::vector<Damping> damping;
};

/// Where a drive can be read after it has been added to a network.
struct DriveTaps {
  std::optional<ElementId> motor_ammeter;  ///< current into the winding, or none without a motor
  std::optional<NodeId> terminal;          ///< motor terminal against ground
};

/// Adds motor, amplifier and damping circuits to the network.
///
/// `command` is the signal node that carries the wanted effort, `shaft` the mechanical node that
/// the motor acts on, `gain` the amplifier's output per unit of command [A/N.m, V/N.m, N.m/N.m].
/// Throws bad_input for a circuit without a motor.
DriveTaps add_drive(Network& network, const Drive& drive, NodeId command, NodeId shaft,
                    double gain);

}  // namespace gyrator
