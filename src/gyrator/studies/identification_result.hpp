#pragma once

#include "gyrator/identification/identification.hpp"
#include "gyrator/mechanics/device.hpp"
#include "gyrator/plots/plot.hpp"
#include "gyrator/studies/report_sections.hpp"

#include <optional>
#include <string>

#include <nlohmann/json.hpp>

namespace gyrator {

/// What was identified, how, and what is left of each measurement; command "identify", without the
/// keys of the device's session (plan, applied, state, journal) and the model.
nlohmann::json make_identification_result(const Identification& found, Motion motion,
                                          const std::string& name);

/// The same for a plan: the experiments that would be run.
nlohmann::json make_identification_plan_result(const std::vector<PlannedStep>& plan, Motion motion,
                                               const std::string& name);

/// The parameters and the plan as tables for people.
std::string describe_parameters(const nlohmann::json& result);
std::string describe_plan(const std::vector<PlannedStep>& plan);

/// What a model file needs besides.
struct IdentifiedModelOptions {
  Motion motion = Motion::rotary;
  std::string name = "Identified motor";
  std::string period = "1 ms";  ///< of the controller
};

/// A model file of what is identifiable, each value with its interval as tolerance where the format
/// has one ("1.5 ohm (1.49 ohm to 1.51 ohm)"): the base with these values replaced, or a new one
/// with a current amplifier. Throws numerical where there is no base for what could not be found
/// and a model cannot do without: resistance, torque constant, inertia.
nlohmann::json make_identified_model(const Identification& found,
                                     const std::optional<nlohmann::json>& base,
                                     const IdentifiedModelOptions& options);

/// Impedance, lag and friction, measured and fitted, each with its residuals.
Figure identification_figure(const nlohmann::json& result);

ReportSection identification_section(const nlohmann::json& result);
std::string identification_sentence(const nlohmann::json& result);

}  // namespace gyrator
