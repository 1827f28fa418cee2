#pragma once

#include "gyrator/studies/schematic_terms.hpp"

namespace gyrator {

/// The position sensor's block: its name, filter, step and offset.
BlockText describe_sensor(const Sensor& sensor, const std::optional<SensorFilter>& filter,
                          const SchematicTerms& terms);

/// What the computer samples and computes: a block for the law, one for each wrapper around it, for
/// the delay and for the hold.
ComputerParts describe_computer(const Model& model, const SchematicTerms& terms);

}  // namespace gyrator
