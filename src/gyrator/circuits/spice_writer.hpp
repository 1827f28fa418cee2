#pragma once

#include "gyrator/circuits/network.hpp"

#include <string>
#include <vector>

namespace gyrator {

/// Unit texts of the mechanical elements, for the netlist's comments.
struct SpiceMechanicalUnits {
  std::string inertia = "kg.m^2", damping = "N.m.s/rad", stiffness = "N.m/rad", velocity = "rad/s";
};

struct SpiceOptions {
  /// What each input of the network is: the text after its sources' two nodes, such as
  /// "DC 0 AC 1" or "PWL(0 0 1u 1)". Inputs beyond the list are "DC 0".
  std::vector<std::string> inputs;
  /// By element, the initial voltage (velocity) of capacitors and current (effort) of inductors,
  /// written as ic=; empty for none. Other elements' entries are not read.
  std::vector<double> initial;
  SpiceMechanicalUnits mechanical;
  /// Nodes that rest at zero at ngspice's operating point, as ours has the mechanics.
  std::vector<NodeId> held_at_rest;
  /// Put before every name, so that several networks can stand in one netlist.
  std::string prefix;
};

/// A network as SPICE lines, and the names that it has there.
struct SpiceNetlist {
  std::string lines;
  std::vector<std::string> nodes;  ///< by NodeId; ground is "0"
  /// By ElementId: the voltage source whose current i(…) is the element's through quantity; empty
  /// for an element that has none (resistor, capacitor …).
  std::vector<std::string> ammeters;
  /// By ElementId: the first SPICE device that stands for it, as for `alter`.
  std::vector<std::string> devices;
  /// ngspice's commands before a transient: let go of what was held at an operating point.
  std::string release;
};

/// Writes every element law as devices of SPICE3 and ngspice, exact to rounding:
/// velocity is voltage, effort is current.
///
/// Names are made legal and unique regardless of case ("damping.0.node" becomes n_damping_0_node);
/// a comment beside each gives its own name and unit. Numbers are the shortest that read back the
/// same, without suffixes.
///
///   Conductance        R = 1/G
///   Transformer        V (ammeter), E = ratio v_2, F = -ratio i at the second port
///   Gyrator            two G of opposite sign
///   MutualInductance   K with k = M / sqrt(L_1 L_2)
///   IdealOpAmp         G from v_+ - v_- into a node of its own, whose voltage drives the output
///                      by E. Kirchhoff's law at that node is v_+ - v_- = 0, exactly.
///   CCVS, CCCS         H, F; a control that is no voltage source gets an ammeter in series
///
///   Diode              D and its .model; N for V_e at ngspice's k T/q
///   clamps, limits     B with min() and max(); its slope is that of the piece
///   ThermalResistor    B, and the temperature's rise as the voltage of a node of its own
///   constant sources   V, I with DC
///   held nodes         1e15 H behind 1e-9 ohm to ground: a short at DC, nothing from 1e-3 Hz
///
/// Node voltages alone are the same unknowns as the descriptor's.
SpiceNetlist write_spice_netlist(const Network& network, const SpiceOptions& options = {});

}  // namespace gyrator
