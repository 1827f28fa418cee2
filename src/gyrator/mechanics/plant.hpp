#pragma once

#include "gyrator/circuits/energy_forms.hpp"
#include "gyrator/circuits/state_space.hpp"
#include "gyrator/mechanics/device.hpp"

#include <optional>
#include <string>
#include <vector>

namespace gyrator {

/// A signal of the plant, row_state ξ + row_input u.
struct Signal {
  std::string name;
  Eigen::RowVectorXd state, input;

  double value(const Eigen::VectorXd& xi, const Eigen::VectorXd& u) const {
    return state.dot(xi) + input.dot(u);
  }
};

/// The continuous plant as an ordinary state space with named ports and signals.
///
///   dξ/dt = A ξ + B u,   ξ = [reduced network state; positions],  u = [command; external effort]
///
/// Positions are integrals of velocities; `sensor_position` is what the controller samples: a
/// position [m, rad], or for a wave drive the integral of the outgoing wave [V.s], zero at the
/// start. One that the network holds already (the deflection of the operator's spring) is read from
/// it instead of being integrated a second time, so that the loop has no spurious eigenvalue at
/// one.
struct Plant {
  Eigen::MatrixXd A, B;
  Signal port_position, port_velocity, sensor_position, port_effort;
  std::vector<Signal> others;  ///< motor current, terminal voltage where they have no impulse
  EnergyForms energy;          ///< in terms of [ξ; u]
  Eigen::MatrixXd
      rest;  ///< initial ξ from (position, velocity) of all inertias, at rest electrically

  Eigen::Index states() const { return A.rows(); }
  Eigen::VectorXd initial_state(double position, double velocity) const {
    return rest * Eigen::Vector2d(position, velocity);
  }
};

/// Name of `sensor_position` where it is no position.
inline constexpr const char* wave_integral_name = "wave_integral";

/// Throws numerical (naming elements) for a singular network, and where the sensed position
/// would jump with the command.
Plant build_plant(const DeviceNetwork& device);

}  // namespace gyrator
