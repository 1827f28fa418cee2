#pragma once

#include "gyrator/circuits/energy_forms.hpp"
#include "gyrator/circuits/port_loop.hpp"
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

/// What a plant with nonlinear elements or constant sources is for large signals:
///   dξ/dt = A ξ + B U,   y = C ξ + D U,   U = [u; contacts; w(y); 1]            (nl-1)
/// with the laws cut out of the network as ports (port-1); contacts, where there are any, the
/// effort of friction on the shaft, that of the stops on the port and the port's signed deflection
/// of a stop (for the ledger; it moves nothing); and of each warming winding
///   dh/dt = (R(h) i² - h/R_th) / C_th                                           (thermal-1)
/// as one more state h at the end of ξ.
struct NonlinearPart {
  Eigen::MatrixXd A, B, C, D;
  std::vector<NonlinearPort> ports;
  struct Thermal {
    Eigen::Index port = 0, state = 0;
    ThermalResistor law;
  };
  std::vector<Thermal> thermal;
  struct Contacts {
    std::optional<DryFriction> friction;
    std::optional<HardStops> stops;
    Signal shaft_velocity;
  };
  std::optional<Contacts> contacts;
  Eigen::VectorXd at_rest;  ///< y at the operating point
  std::string named_by;     ///< element that makes it nonlinear, for messages

  // Where U has what.
  static constexpr Eigen::Index friction_input = 2, stop_input = 3, deflection_input = 4;
  Eigen::Index first_port() const { return contacts ? 5 : 2; }
  auto port_columns(const Eigen::MatrixXd& of) const {
    return of.middleCols(first_port(), static_cast<Eigen::Index>(ports.size()));
  }
  /// What each mode of bends and contacts makes affine: no diode, no winding that warms.
  bool is_piecewise_linear() const;
};

/// The continuous plant as an ordinary state space with named ports and signals.
///
///   dξ/dt = A ξ + B u,   ξ = [reduced network state; positions],  u = [command; external effort]
///
/// Positions are integrals of velocities; `sensor_position` is what the controller samples: a
/// position [m, rad], or for a wave drive the integral of the outgoing wave [V.s], zero at the
/// start. A filtered position starts where the filter stands that has followed the initial velocity
/// for long: find_lag() times that velocity behind. One that the network holds already (the
/// deflection of the operator's spring) is read from it instead of being integrated a second time,
/// so that the loop has no spurious eigenvalue at one.
///
/// With a nonlinear part, A and B are its tangent at the operating point, and signals and energies
/// are functions of ξ and U.
struct Plant {
  Eigen::MatrixXd A, B;
  Signal port_position, port_velocity, sensor_position, port_effort;
  std::vector<Signal> others;  ///< motor current, terminal voltage where they have no impulse
  EnergyForms energy;          ///< in terms of [ξ; u]
  Eigen::MatrixXd
      rest;  ///< initial ξ from (position, velocity) of all inertias, at rest electrically
  std::optional<NonlinearPart> nonlinear;
  Eigen::VectorXd bias;  ///< ξ at the operating point; empty for a linear plant

  Eigen::Index states() const { return A.rows(); }
  /// Length of u, or of U.
  Eigen::Index inputs() const { return nonlinear ? nonlinear->B.cols() : B.cols(); }
  Eigen::VectorXd initial_state(double position, double velocity) const {
    Eigen::VectorXd xi = rest * Eigen::Vector2d(position, velocity);
    if (bias.size() > 0) xi += bias;
    return xi;
  }
};

/// Name of `sensor_position` where it is no position.
inline constexpr const char* wave_integral_name = "wave_integral";

/// The plant of the linear tools: small deviations from the operating point. Throws numerical
/// (naming elements) for a singular network, and where the sensed position would jump with the
/// command.
Plant build_plant(const DeviceNetwork& device);

/// The plant as it moves, whatever the size: with its nonlinear part where the network is not
/// linear, and with friction and stops. Throws as build_plant(), and where a law or an energy would
/// need the derivative of a limited quantity (a saturated voltage source across a bare capacitor).
Plant build_moving_plant(const DeviceNetwork& device);

}  // namespace gyrator
