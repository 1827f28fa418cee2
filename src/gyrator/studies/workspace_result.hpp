#pragma once

#include "gyrator/plots/plot.hpp"
#include "gyrator/studies/report_sections.hpp"
#include "gyrator/studies/workspace_file.hpp"

#include <string>

#include <nlohmann/json.hpp>

namespace gyrator {

/// What the joints' damping is worth at every pose, the worst of them, and whether it suffices
/// [8.31]; command "workspace". `verdict` is null without a task damping.
nlohmann::json make_workspace_result(const Workspace& workspace);

/// The largest isotropic task damping over the poses, and the factor of the wanted one.
Figure workspace_figure(const nlohmann::json& result);

ReportSection workspace_section(const nlohmann::json& result);
std::string workspace_sentence(const nlohmann::json& result);

}  // namespace gyrator
