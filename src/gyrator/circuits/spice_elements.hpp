#pragma once

#include "gyrator/circuits/spice_builder.hpp"

namespace gyrator {

/// Reads one element's line into the builder, by its first letter: the table of letters is in
/// spice_elements.cpp. Throws bad_input, naming the line and the letters that are read.
void read_spice_element(const SpiceCard& card, SpiceInstance& instance, SpiceBuilder& builder);

}  // namespace gyrator
