#pragma once

#include "gyrator/circuits/descriptor.hpp"
#include "gyrator/circuits/drive.hpp"
#include "gyrator/mechanics/contact.hpp"

#include <optional>
#include <variant>
#include <vector>

namespace gyrator {

/// Units of the motion: N, m or N·m, rad. The equations are the same.
enum class Motion { rotary, linear };

/// A compliant transmission from the motor's inertia to a load that the operator holds.
struct Transmission {
  double stiffness = 0;     ///< [N.m/rad or N/m]
  double damping = 0;       ///< [N.m.s/rad or N.s/m]
  double load_inertia = 0;  ///< [kg.m^2 or kg]
};

struct Mechanics {
  double inertia = 0;           ///< of motor and all that is rigid with it [kg.m^2 or kg]
  double damping = 0;           ///< viscous, to ground, at the motor [N.m.s/rad or N.s/m]
  double coulomb_friction = 0;  ///< sliding level at the motor [N.m or N]
  std::optional<Transmission> transmission;
  std::optional<double> stiction;  ///< breakaway effort [N.m or N]; none: coulomb_friction
  double stribeck_velocity = 0;    ///< up to which friction falls from one to the other
  std::optional<HardStops> stops;  ///< at the operator port
};

/// The dry friction that the mechanics have. Throws bad_input for a breakaway effort below the
/// sliding level.
std::optional<DryFriction> find_dry_friction(const Mechanics& mechanics);

/// What the controller samples: the integral of the port's velocity, of the motor's, or of the wave
/// that leaves a wave drive, W = V - R_w i [V].
enum class SensorLocation { port, motor, outgoing_wave };

/// An analog low-pass between the position sensor and the sampler, which loads neither:
///   order 1   F(s) = 1/(1 + s/w_c)
///   order 2   F(s) = 1/(1 + sqrt(2) s/w_c + (s/w_c)^2)   (Butterworth)              (filter-1)
/// -3 dB at `cutoff_hz` = w_c/(2 pi) [Hz]. It lags slow motion by 1/w_c or sqrt(2)/w_c.
struct SensorFilter {
  double cutoff_hz = 0;
  int order = 1;
};

/// How far the filter's output trails a constant velocity, -F'(0) [s].
double find_lag(const SensorFilter& filter);

/// Everything continuous: drive, mechanics and what is sensed.
struct Device {
  Motion motion = Motion::rotary;
  Drive drive;
  Mechanics mechanics;
  SensorLocation sensor = SensorLocation::port;
  /// Of the amplifier, set once for a device that this one differs from; none: that at which the
  /// blocked effort equals the command.
  std::optional<double> gain = {};
  std::optional<SensorFilter> sensor_filter = {};
};

// What the operator does at the port.

struct FreeOperator {};
struct ClampedOperator {};
/// A hand as mass–spring–damper to ground; the spring is at rest at position zero. Zero leaves a
/// part out. `resonators` are inertias hung on springs of their own (lossless, for
/// counterexamples).
struct MassSpringDamper {
  double inertia = 0;    ///< [kg.m^2 or kg]
  double damping = 0;    ///< [N.m.s/rad or N.s/m]
  double stiffness = 0;  ///< [N.m/rad or N/m]
  struct Resonator {
    double inertia = 0;
    double stiffness = 0;
  };
  std::vector<Resonator> resonators;
};

/// Any passive hand as a network from a SPICE file, in the mobility analogy: its first pin is the
/// port, its second ground; a capacitor is an inertia [kg, kg.m^2], an inductor a spring of 1/L, a
/// resistor a damper of 1/R, coupled inductors springs of several motions. At the start all
/// inertias move as the port does.
struct NetworkOperator {
  SpiceCircuit circuit;
};

/// Throws bad_input, with the netlist's file and line, for a circuit that is not passive by its
/// elements alone, or has no two terminals.
void check_passive_operator(const NetworkOperator& held_by);

using Operator = std::variant<FreeOperator, ClampedOperator, MassSpringDamper, NetworkOperator>;

/// The device's network with an operator at its port, ready to be analysed.
///
/// Inputs: `command` (effort asked for, opposing none: positive drives the port forward) and
/// `external_effort` applied at the port from outside, in parallel to the operator.
struct DeviceNetwork {
  Network network;
  int command = 0;
  int external_effort = 1;
  NodeId port;         ///< mechanical node that the operator holds
  NodeId motor_shaft;  ///< differs from port behind a compliant transmission
  SensorLocation sensor = SensorLocation::port;
  NodeId sensed;               ///< whose across is the sensed velocity, behind any filter
  std::vector<NodeId> filter;  ///< nodes of the sensor's filter, the sensed one last
  ElementId operator_ammeter;  ///< effort from the operator into the device
  DriveTaps drive;
  double gain = 1;          ///< of the amplifier, per unit of command [A/N.m, V/N.m, 1 …]
  bool collocated = true;   ///< the sensor sees the port's motion itself
  bool port_sensed = true;  ///< … or behind a filter: with the port held it sees nothing
  // Not of the network: the linear tools leave both out, build_moving_plant takes them in.
  std::optional<DryFriction> friction;  ///< at motor_shaft
  std::optional<HardStops> stops;       ///< at port
};

/// Builds the network. The command is scaled so that at DC, and with the winding at the reference
/// temperature, the blocked effort equals it, unless the device has a gain of its own; throws
/// bad_input where the drive passes no DC at all, where a wave is to be sensed without a drive that
/// has one or through a filter, where a filter makes no sense, and where friction or stops
/// contradict themselves.
DeviceNetwork build_device_network(const Device& device, const Operator& held_by);

/// The same with the amplifier's gain as it is, whatever effort comes of it.
DeviceNetwork build_device_network(const Device& device, const Operator& held_by, double gain);

/// The gain that build_device_network scales the command by: the device's own, if it has one.
double find_amplifier_gain(const Device& device);

/// The rate of what the controller samples: port or motor velocity [m/s, rad/s], behind the filter
/// where there is one, or the outgoing wave W = 2 V - U [V]. `equations` are those of the device's
/// own network.
LinearForm find_sensed_rate(const DeviceNetwork& device, const NetworkEquations& equations);

}  // namespace gyrator
