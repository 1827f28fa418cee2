#pragma once

#include "gyrator/circuits/spice_element_line.hpp"

namespace gyrator {

/// Reads a diode, "D1 anode cathode MODEL [area] [m=] [off]": the exponential of its `.model` at
/// 27 degC,
///   i = Is (exp(v/(N V_t)) - 1),   V_t = k T/q,                                   (diode-1)
/// Rs in series as an element of its own. Throws bad_input naming whatever else of the model would
/// change the circuit (capacitance, storage, breakdown, injection), and an unknown model.
void read_spice_diode(SpiceElementLine& line);

}  // namespace gyrator
