#pragma once

#include "gyrator/passivity/environment_activity.hpp"
#include "gyrator/plots/plot.hpp"
#include "gyrator/studies/model_file.hpp"
#include "gyrator/studies/report_sections.hpp"

#include <optional>
#include <string>

#include <nlohmann/json.hpp>

namespace gyrator {

/// Reads the columns `position` and `effort` (SI units). Throws bad_input with file, line and
/// column, also where the position does not increase.
EnvironmentProfile load_environment_profile(const std::string& path);

/// Whether a nonlinear profile, sampled and held as the model's controller is, is passive on the
/// model's device (activity-1), [8.29], [8.30]; command "environment".
nlohmann::json make_environment_result(const EnvironmentProfile& profile, const std::string& path,
                                       const Model& model, std::optional<double> coupling_damping);

/// The profile with its steepest slopes, and the dampings compared.
Figure environment_figure(const nlohmann::json& result);

ReportSection environment_section(const nlohmann::json& result);
std::string environment_sentence(const nlohmann::json& result);

}  // namespace gyrator
