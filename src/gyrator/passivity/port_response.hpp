#pragma once

#include "gyrator/circuits/hessenberg_response.hpp"
#include "gyrator/circuits/modal_response.hpp"
#include "gyrator/mechanics/device.hpp"

#include <complex>
#include <functional>
#include <optional>
#include <vector>

namespace gyrator {

/// The device at one frequency, seen with the port's velocity v_p imposed:
///   f_h = Z v_p - A u        v_s = S v_p + M u                                    (port-1)
/// Z impedance at the port; A actuation path, the blocked effort at the port per command (1 for
/// an ideal drive); S sensor path, sensed over port velocity (1 when they are the same); M what
/// the sensor still sees of the command with the port held (0 when they are the same). "Sensed" is
/// the rate of what the controller samples: a velocity, or a wave [V].
///
/// In the admittances of the equations sheet Z = 1/Y_pp, A = Y_pu/Y_pp, S = Y_sp/Y_pp and
/// M = Y_su - Y_sp Y_pu/Y_pp. This form needs no difference of large numbers in the passivity
/// criteria: coupled to an operator of impedance Σ the loop sees v_s/u = M + S A/(Z + Σ).
struct PortResponse {
  double omega = 0;  ///< [rad/s]
  std::complex<double> impedance, actuation, sensor_path, blocked_motion;
};

/// What was measured of a device in place of its model's response, at any frequency > 0 [rad/s].
using PortCorrection = std::function<void(PortResponse&)>;

/// Straight from the network's descriptor equations, point by point; for tables and as the check of
/// PortModel. Frequencies in Hz. Throws numerical where the network is singular.
std::vector<PortResponse> compute_port_response(const Device& device,
                                                const std::vector<double>& frequency_hz);

/// The device as it is with the port's velocity imposed, a state space of (port-1),
///   dx/dt = A x + B [u; v_p],   [f_h - m dv_p/dt; v_s] = C x + D [u; v_p]              (port-2)
/// with m the inertia that is rigid with the port: what is left of Z is proper, and its real part
/// no small difference of large numbers. Its poles are those of the device held still.
struct BlockedDevice {
  double inertia = 0;           ///< m [kg, kg.m^2]
  StateSpace system;            ///< one output where the sensor sees the port itself (S = 1, M = 0)
  bool sensed_at_port = false;  ///< behind a filter at the port, so that M = 0
};

/// The same response from the reduced state space, fast enough for sums over many aliases.
class PortModel {
 public:
  explicit PortModel(const Device& device);

  PortResponse at(double omega);

  /// What M tends to at high frequency: not zero where a wave is sensed, whose source is in it.
  double blocked_feedthrough() const { return blocked_feedthrough_; }

  /// Poles of the device with the port free and with it clamped [rad/s]: where its response varies.
  const Eigen::VectorXcd& poles() const { return poles_; }

  const BlockedDevice& blocked() const { return blocked_; }
  bool collocated() const { return blocked_.system.C.rows() == 1; }
  /// Whether M = 0: the sensor is at the port, behind a filter or not.
  bool sees_no_command() const { return collocated() || blocked_.sensed_at_port; }
  /// Its modes; none where they do not reproduce it.
  const std::optional<ModalResponse>& modes() const { return modes_; }

 private:
  BlockedDevice blocked_;
  HessenbergResponse response_;
  std::optional<ModalResponse> modes_;
  Eigen::VectorXcd poles_;
  double blocked_feedthrough_;
  Eigen::MatrixXcd entries_;
};

}  // namespace gyrator
