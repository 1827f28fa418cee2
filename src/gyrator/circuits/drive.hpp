#pragma once

#include "gyrator/circuits/damping.hpp"
#include "gyrator/circuits/network.hpp"

#include <optional>
#include <variant>
#include <vector>

namespace gyrator {

/// Copper, around room temperature [1/K].
inline constexpr double copper_temperature_coefficient = 0.00393;

/// How a winding warms: C_th dh/dt = R(h) i² - h/R_th, ambient at the reference temperature.
struct WindingThermal {
  double resistance = 0;  ///< R_th [K/W]
  double capacity = 0;    ///< C_th [J/K]
};

/// A permanent-magnet motor, rotary or linear. K_t [N.m/A or N/A], R_m [ohm], L_m [H].
/// The power-conserving two-port e = K_t w, tau = K_t i behind the winding (equations, section 2),
/// whose resistance follows its temperature, R = R_m (1 + alpha rise).                (motor-1)
struct Motor {
  double torque_constant = 0;
  double resistance = 0;  ///< at the reference temperature
  double inductance = 0;
  double temperature_coefficient = copper_temperature_coefficient;  ///< alpha [1/K]
  double temperature_rise = 0;  ///< of the winding above the reference temperature [K]
  /// None: it stays at that rise. With it the rise is where it starts, and the linear tools' own.
  std::optional<WindingThermal> thermal = {};

  double warm_resistance() const {
    return resistance * (1 + temperature_coefficient * temperature_rise);
  }
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
///
/// `current_limit` [A] bounds the current that is asked for; `voltage_limit` [V] the terminal
/// voltage: what is too much flows into the supply rails (rail_resistance), and a loop that senses
/// the motor is kept from winding up by it.
struct CurrentAmplifier {
  std::optional<double> bandwidth_hz;
  CurrentSense sense = CurrentSense::total;
  std::optional<double> current_limit = {}, voltage_limit = {};
};

/// Voltage amplifier behind `output_resistance` [ohm], first-order with -3 dB at `bandwidth_hz`.
/// `voltage_limit` [V] bounds the voltage that is asked for; beyond `current_limit` [A] the output
/// gives way by limiter_resistance per ampere.
struct VoltageAmplifier {
  std::optional<double> bandwidth_hz;
  double output_resistance = 0;
  std::optional<double> current_limit = {}, voltage_limit = {};
};

/// Small against a winding, so that 10 A of excess lift a rail by 0.1 V [ohm].
inline constexpr double rail_resistance = 0.01;
/// Large against a winding, so that 24 V of excess are 24 mA above the limit [ohm].
inline constexpr double limiter_resistance = 1000;

using Amplifier = std::variant<IdealDrive, CurrentAmplifier, VoltageAmplifier>;

/// -3 dB frequency of an amplifier [Hz]; none: ideal.
std::optional<double> find_bandwidth(const Amplifier& amplifier);

struct Drive {
  std::optional<Motor> motor;  ///< required by every amplifier but IdealDrive
  Amplifier amplifier = IdealDrive{};
  std::vector<Damping> damping;
};

/// The nodes of a network that a drive is built between.
struct DriveNodes {
  NodeId command;  ///< signal: the wanted effort, one volt per N.m or N
  NodeId shaft;    ///< mechanical: what the motor acts on
  NodeId port;     ///< mechanical: what the operator holds
  NodeId sensed;   ///< mechanical: where position is sensed
};

/// Where a drive can be read after it has been added to a network.
struct DriveTaps {
  std::optional<ElementId> motor_ammeter;  ///< current into the winding, or none without a motor
  std::optional<NodeId> terminal;          ///< terminal against ground, where circuits hang
  std::vector<NodeId> positions;           ///< signal nodes that hold the sensed position
  std::optional<NodeId> source;            ///< U of a wave drive, behind all its resistance
  double volts_per_command = 0;            ///< of a wave drive's source; 0 for any other
};

/// Adds motor, amplifier and damping to the network. `gain` is the amplifier's output per unit of
/// command [A/N.m, V/N.m, N.m/N.m]. Throws bad_input for what makes no sense together.
DriveTaps add_drive(Network& network, const Drive& drive, const DriveNodes& nodes, double gain);

/// Throws bad_input, naming the damping, where two parts of a drive make no sense together.
void check_drive(const Drive& drive);

}  // namespace gyrator
