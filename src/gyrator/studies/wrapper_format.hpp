#pragma once

#include "gyrator/controllers/controller.hpp"
#include "gyrator/documents/document_spec.hpp"
#include "gyrator/studies/controller_format.hpp"
#include "gyrator/studies/motion_terms.hpp"

#include <string>
#include <vector>

#include <nlohmann/json.hpp>

namespace gyrator {

// The keys of what is wrapped around a law, and of the predictive wall.

/// To every law with a surface its list "contact_effects", and the kind "passivity" around all
/// laws.
std::vector<ObjectSpec> add_wrapper_specs(std::vector<ObjectSpec> laws, const MotionTerms& terms);

/// The law within a controller: the controller itself, or what "passivity" wraps.
const nlohmann::json& find_wrapped_law(const nlohmann::json& controller);
/// Its JSON path.
std::string find_law_place(const nlohmann::json& controller);

/// From the inside out. Read from a validated document.
std::vector<Wrapper> parse_wrappers(const nlohmann::json& controller,
                                    const ControllerSurroundings& surroundings);

/// Throws bad_input for a law that cannot be wrapped, and for an effect that this period (s) cannot
/// play.
void check_wrappers(const Controller& controller, const nlohmann::json& document, double period);

ObjectSpec make_predictive_wall_spec(const MotionTerms& terms);
Law parse_predictive_wall(const nlohmann::json& document);

}  // namespace gyrator
