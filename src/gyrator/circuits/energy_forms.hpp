#pragma once

#include "gyrator/circuits/descriptor.hpp"
#include "gyrator/circuits/reduction.hpp"

#include <optional>

#include <Eigen/Dense>

namespace gyrator {

/// Every power of the network as a quadratic form of z = [w; u] (reduced state and inputs), for
/// the energy ledger:                                                             (led-1)
///   stored       z' S z   energy in the device's inductors, capacitors, masses, springs [J]
///   dissipated   z' D z   heat in its resistors and dampers [W]
///   source       z' P z   power that its sources deliver [W]
///   operator     z' H z   power that flows in through the operator's ammeter [W]
/// A nonlinear element's heat is v i as well, with its port's input among u; what an amplifier's
/// limits (Role::supply) take back is subtracted from what its sources deliver.
/// By Tellegen's theorem  z'Pz + z'Hz = d/dt z'Sz + z'Dz; what an integrator leaves of it is
/// the ledger's residual.
struct EnergyForms {
  Eigen::MatrixXd stored, dissipated, source, operator_work;
  /// Work done by the sources when u jumps (impulses at index 2), a form of [w; u_before; u_after].
  Eigen::MatrixXd source_jump;
};

/// `operator_ammeter` carries the effort from the operator into the device, measured from its
/// node on the operator's side; none means that no operator is attached.
EnergyForms build_energy_forms(const NetworkEquations& equations, const Reduction& reduction,
                               std::optional<ElementId> operator_ammeter);

}  // namespace gyrator
