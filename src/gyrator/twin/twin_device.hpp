#pragma once

#include "gyrator/amplifiers/experiment.hpp"
#include "gyrator/circuits/drive.hpp"
#include "gyrator/mechanics/device.hpp"

#include <cstdint>

namespace gyrator {

/// Standard deviations of what is added to each sample; `command` to what the amplifier puts out.
struct TwinNoise {
  double command = 0;   ///< [A or V]
  double current = 0;   ///< [A]
  double voltage = 0;   ///< [V]
  double velocity = 0;  ///< [rad/s, m/s]
  double position = 0;  ///< before the encoder's step [rad, m]
};

/// Everything of a simulated amplifier with its motor that a user cannot set over the link.
///
/// The amplifier's two limits are where its settings of that name start. A bandwidth that the
/// device leaves out is `default_bandwidth_hz`: no real amplifier is ideal.
struct TwinDevice {
  static constexpr double default_bandwidth_hz = 2000;
  static constexpr double default_current_limit = 3;   ///< [A]
  static constexpr double default_voltage_limit = 24;  ///< [V]

  Device device;
  double delay = 0;  ///< of every command [s]
  TwinNoise noise;
  double position_quantum = 0;  ///< of the encoder [rad, m]; 0 for none
  double current_step = 0;      ///< of the captured current [A]
  double voltage_step = 0;      ///< of the captured voltage [V]
  double velocity_step = 0;     ///< [rad/s, m/s]
  std::uint64_t seed = 1;

  WindingThermal thermal{8, 3};           ///< [K/W], [J/K]
  double reference_temperature = 298.15;  ///< at which the motor has its resistance [K]
  double ambient = 298.15;                ///< [K]
  double winding_rise = 0;                ///< above the ambient, at the start [K]
  double velocity_limit = 1000;           ///< beyond it the overspeed fault [rad/s, m/s]
};

/// What can be set, by its well-known name. Start values are those of the device: an RC branch,
/// resistance cancellation and back-EMF damping in `Drive::damping` are where these settings start.
struct TwinSettings {
  bool enable = false;
  DriveMode drive_mode = DriveMode::current;
  double current_limit = 0;            ///< [A]
  double voltage_limit = 0;            ///< [V]
  double temperature_limit = 393.15;   ///< [K]
  double velocity_limit = 0;           ///< [rad/s, m/s]
  double cancellation_resistance = 0;  ///< [ohm]
  double damping_resistance = 10;      ///< R_1 [ohm]
  double damping_capacitance = 0;      ///< C [F]; 0: the resistor alone
  bool damping_connected = false;
  double back_emf_damping = 0;     ///< d [N.m.s/rad, N.s/m]
  double back_emf_resistance = 0;  ///< the estimate of the winding [ohm]
  double watchdog_period = 0;      ///< [s]; 0: none

  friend bool operator==(const TwinSettings&, const TwinSettings&) = default;
};

/// Throws bad_input, with the place in the model's terms, for a device that no amplifier with a
/// motor is: an ideal drive, no motor, wave or held-parameter drives, numbers out of range.
void check_twin_device(const TwinDevice& twin);

TwinSettings find_initial_settings(const TwinDevice& twin);

/// The device as it stands with these settings and a winding of `resistance` [ohm], for
/// build_device_network with gain 1: its command is in A in current mode and in V in voltage mode.
///
/// Disabled, the output stage is off: the terminals are open but for the damping branch, which is a
/// current amplifier whose command is zero; cancellation and back-EMF damping are off with it.
/// The voltage limit is a pair of supply rails in current mode and bounds the command in voltage
/// mode; where resistance is cancelled in current mode, which rails would distort, it is left to
/// the overvoltage fault. Cancellation where check_drive() refuses it, in current mode with nothing
/// across the motor, has no effect. Back-EMF damping d is scaled to the output by the motor's own
/// constants, d/K_t [A/V] or d (R_m + R_out)/K_t per volt of estimate [V/V].
Device make_plant_device(const TwinDevice& twin, const TwinSettings& settings, double resistance);

}  // namespace gyrator
