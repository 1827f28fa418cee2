#pragma once

#include "gyrator/synthesis/design_search.hpp"

#include <nlohmann/json.hpp>

namespace gyrator {

/// The model file of a candidate: its parts with their tolerances, its controller with a wall of
/// `stiffness` at the lowest of the virtual dampings, and the winding's temperatures.
nlohmann::json make_rated_model(const DesignSpec& spec, const Candidate& candidate,
                                double stiffness);

}  // namespace gyrator
