#pragma once

#include "gyrator/circuits/spice_subcircuit.hpp"

#include <optional>
#include <variant>

namespace gyrator {

// What damps the device, in any mixture. Each is a handful of network elements (damping.cpp); its
// closed form is in the tests. K_t torque constant [N.m/A, N/A], R_m, L_m of the winding, i the
// motor's current, v the velocity at the operator port, v_y the sensor's.

// Circuits across the motor terminals.

/// A resistor across the motor terminals [ohm].
struct ResistorDamping {
  double resistance = 0;
};
/// R_1 [ohm] in series with C [F] across the motor terminals [8.48]. R_1 may be zero.
struct RcDamping {
  double resistance = 0;
  double capacitance = 0;
};

/// Any circuit with two terminals, from a SPICE file (docs/netlist.md); its second pin is the
/// terminals' ground.
struct NetlistDamping {
  SpiceCircuit circuit;
};

/// A bidirectional suppressor across the motor terminals: its leakage up to `voltage` [V], beyond
/// it the excess through `resistance` [ohm] as well.
struct ClampDamping {
  static constexpr double leakage = 1e-6;  ///< [S], a few microamperes as of a real one
  double voltage = 0;
  double resistance = 0.1;
};

// In series with the motor.

/// A voltage that raises with the motor's own current, so that R_m appears as R_m - R_c:
///   v_c = R_c F(s) i,   F = 1/(1 + s/w_b)                                        (cancel-1)
/// A pole at w_b acts as the inductance R_c/w_b on top of L_m, at low frequency. Stable alone
/// only while R_m - R_c (all losses of the loop counted) stays positive. [8.6.4]
struct ResistanceCancellation {
  double resistance = 0;               ///< R_c [ohm]
  std::optional<double> bandwidth_hz;  ///< -3 dB frequency of the feedback; none: ideal
};

/// A wave-variable drive: so much resistance between a voltage amplifier's output and the motor
/// that the whole source resistance R_w presents the wave impedance to the shaft,
///   b_w = K_t^2 / R_w     [N.m.s/rad, N.s/m]; at most one                          (wave-1)
/// The source U = V + R_w i is the wave that comes in, W = V - R_w i = 2 V - U the one that goes
/// out; the power into the motor is V i = (U^2 - W^2)/(4 R_w). Diolaiti and Niemeyer 2006,
/// fig. 8.27.
struct WaveDamping {
  double impedance = 0;  ///< b_w
};

// Feedback to the command.

/// Active electrical damping: the back-EMF is estimated at the motor's terminals,
///   e = V - R i - L di/dt      (R, L the estimates)
///   command = -(d/K_t) F(s) e                                                    (bemf-1)
/// which adds the damping d within the band of F, and where the winding's resistance is not R the
/// error term (R_m - R) i. F is a first-order low-pass, a high-pass, both or none. [8.6.4]
struct BackEmfDamping {
  double damping = 0;              ///< d [N.m.s/rad, N.s/m]
  double resistance_estimate = 0;  ///< [ohm]
  double inductance_estimate = 0;  ///< [H]
  std::optional<double> low_pass_hz, high_pass_hz;
};

/// The wall as an analog loop around the position sensor, whose gains and centre a computer holds
/// from sample to sample (Kawai and Yoshikawa 2002; figs 8.23, 8.24):
///   command = -F(s) (k y + d v_y)                                                (held-1)
/// The centre is position zero. F is a first-order low-pass, if any.
struct HeldImpedance {
  double stiffness = 0;  ///< k [N.m/rad, N/m]
  double damping = 0;    ///< d [N.m.s/rad, N.s/m]
  std::optional<double> bandwidth_hz;
};

/// A viscous damper at the port whose effort is measured and, low-passed, added to the command, so
/// that it is not felt at low frequency (Colgate and Brown 1994; 8.6.3):
///   Z gains d (1 - A/(1 + s/w_c))                                                (sensed-1)
struct TorqueSensedDamper {
  double damping = 0;    ///< d [N.m.s/rad, N.s/m]
  double cutoff_hz = 0;  ///< of the low-pass in the cancellation
};

// Mechanical dampers at the port.

/// Magnet and conducting disk, or any viscous damper that can be switched off (Gosline et al.
/// 2006).
struct EddyCurrentBrake {
  double damping = 0;  ///< [N.m.s/rad, N.s/m]
  bool on = true;
};

/// A friction brake at the port, controlled to imitate a damper up to its holding effort, f = b v
/// and at most f_c (An and Kwon 2006; 8.6.3).                                   (friction-1)
struct FrictionBrake {
  double damping = 0;  ///< b [N.m.s/rad, N.s/m]
  double effort = 0;   ///< f_c [N.m, N]
};

/// A damper to a floating inertia [fig. 8.19b]: Re Z tends to 0 at low and to `damping` at high
/// frequency.
struct HighPassDamper {
  double inertia = 0;  ///< [kg.m^2 or kg]
  double damping = 0;  ///< [N.m.s/rad or N.s/m]
};

/// The closed list.
using Damping = std::variant<ResistorDamping, RcDamping, NetlistDamping, ResistanceCancellation,
                             BackEmfDamping, HeldImpedance, TorqueSensedDamper, EddyCurrentBrake,
                             HighPassDamper, WaveDamping, ClampDamping, FrictionBrake>;

}  // namespace gyrator
