#pragma once

#include "gyrator/circuits/spice_subcircuit.hpp"

namespace gyrator {

/// Checks of the graph that need no equations: whatever the values are, a circuit that fails one
/// has no unique solution.
///
///  - a pin that touches nothing, a node reached by one terminal only (unless its name begins with
///    "unconnected-", KiCad's mark of intent), a node that is only listened to;
///  - a part without any path to the pins or ground, or with none but through current sources of
///    which none is steered from within the part;
///  - a loop of ideal voltage sources, shorts and op-amp outputs: its current is undetermined;
///  - couplings of inductors whose energy could be negative (beside k = 0.9, 0.9, -0.9 of three).
///
/// Throws bad_input at file and line of an element, naming nodes and elements.
void check_spice_structure(const SpiceCircuit& circuit);

/// The loops again with the second pin at ground, and with a source across the first.
void check_spice_port(const SpiceCircuit& circuit);

}  // namespace gyrator
