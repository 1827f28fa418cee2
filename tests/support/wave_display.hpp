#pragma once

#include "gyrator/controllers/controller.hpp"
#include "gyrator/mechanics/device.hpp"

#include "support/device_list.hpp"

namespace gyrator::testing {

inline constexpr double wave_impedance = 1e-3;  // b_w [N.m.s/rad]

/// The RE25 behind a wave drive of 1e-3 N.m.s/rad, with so much of its winding cancelled (and none
/// of the feedback's delay without a bandwidth).
inline Device make_wave_display(double cancelled = 0, std::optional<double> bandwidth_hz = {}) {
  Device device = make_re25();
  device.drive.amplifier = VoltageAmplifier{};
  device.drive.damping = {WaveDamping{wave_impedance}};
  if (cancelled > 0)
    device.drive.damping.push_back(
        ResistanceCancellation{cancelled * device.drive.motor->resistance, bandwidth_hz});
  device.sensor = SensorLocation::outgoing_wave;
  return device;
}

/// The digital end of that drive, scaled by what the network says.
inline WaveController make_wave_controller(const Device& device,
                                           const WaveEnvironment& environment) {
  const DeviceNetwork network = build_device_network(device, FreeOperator{});
  return {wave_impedance, device.drive.motor->torque_constant, network.drive.volts_per_command,
          environment};
}

}  // namespace gyrator::testing
