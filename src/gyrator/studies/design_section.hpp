#pragma once

#include "gyrator/plots/plot.hpp"
#include "gyrator/studies/report_sections.hpp"

#include <string>

#include <nlohmann/json.hpp>

namespace gyrator {

// What pictures and the report say of a `design` result. Each throws bad_input, naming the key,
// where one is missing or of the wrong kind.

/// Stiffness over apparent inertia, the front of each topology with the designs on it; and K over B
/// of every design with its rated wall.
Figure design_figure(const nlohmann::json& result);

/// The designs, the first one's bill of materials, and how much of each constraint is left; where
/// there is none, what would have to give.
ReportSection design_section(const nlohmann::json& result);

/// The best design, or what binds, in one sentence.
std::string design_sentence(const nlohmann::json& result);

}  // namespace gyrator
