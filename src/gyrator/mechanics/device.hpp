#pragma once

#include "gyrator/circuits/descriptor.hpp"
#include "gyrator/circuits/drive.hpp"

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

/// A damper from the operator port to a floating inertia [fig. 8.19b]: Re Z tends to 0 at low
/// and to `damping` at high frequency.
struct HighPassDamper {
  double inertia = 0;  ///< [kg.m^2 or kg]
  double damping = 0;  ///< [N.m.s/rad or N.s/m]
};

struct Mechanics {
  double inertia = 0;           ///< of motor and all that is rigid with it [kg.m^2 or kg]
  double damping = 0;           ///< viscous, to ground, at the motor [N.m.s/rad or N.s/m]
  double coulomb_friction = 0;  ///< [N.m or N]
  std::optional<Transmission> transmission;
  std::optional<HighPassDamper> high_pass_damper;
};

enum class SensorLocation { port, motor };

/// Everything continuous: drive, mechanics and where the position is sensed.
struct Device {
  Motion motion = Motion::rotary;
  Drive drive;
  Mechanics mechanics;
  SensorLocation sensor = SensorLocation::port;
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

using Operator = std::variant<FreeOperator, ClampedOperator, MassSpringDamper>;

/// The device's network with an operator at its port, ready to be analysed.
///
/// Inputs: `command` (effort asked for, opposing none: positive drives the port forward) and
/// `external_effort` applied at the port from outside, in parallel to the operator.
struct DeviceNetwork {
  Network network;
  int command = 0;
  int external_effort = 1;
  NodeId port;                 ///< mechanical node that the operator holds
  NodeId motor_shaft;          ///< differs from port behind a compliant transmission
  NodeId sensed;               ///< port or motor_shaft
  ElementId operator_ammeter;  ///< effort from the operator into the device
  DriveTaps drive;
  bool collocated = true;  ///< the sensor sees the port's motion itself
};

/// Builds the network. The command is scaled so that at DC the blocked effort equals it; throws
/// bad_input where the drive passes no DC at all.
DeviceNetwork build_device_network(const Device& device, const Operator& held_by);

}  // namespace gyrator
