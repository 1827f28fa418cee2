#pragma once

#include "gyrator/cosim/gesture.hpp"
#include "gyrator/documents/document_spec.hpp"
#include "gyrator/mechanics/device.hpp"
#include "gyrator/studies/model_format.hpp"

#include <optional>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

namespace gyrator {

// The keys "operator" and "simulation/gesture" of a model file: their tables, and what they say.
// The documents parsed have been validated by the tables; `file` is the model's, relative to which
// paths stand.

std::vector<ObjectSpec> operator_specs(const MotionUnits& units, const char* inertia_name);
std::vector<ObjectSpec> gesture_specs(const MotionUnits& units);

/// Throws bad_input for a netlist that cannot be read or is not passive.
Operator parse_operator(const nlohmann::json& held_by, const std::string& file);

/// Throws bad_input for a recording that cannot be read, pulses that do not fit into their
/// repetition, and a gesture that the operator cannot make: any of a clamped one, a motion without
/// a spring or damper to act through.
std::optional<HandGesture> parse_gesture(const nlohmann::json& gesture, const Operator& held_by,
                                         const std::string& file);

}  // namespace gyrator
