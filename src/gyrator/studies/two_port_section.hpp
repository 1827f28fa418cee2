#pragma once

#include "gyrator/studies/report_sections.hpp"

#include <string>

#include <nlohmann/json.hpp>

namespace gyrator {

/// What the report says of a twoport result: every condition of every two-port.
ReportSection two_port_section(const nlohmann::json& result);

/// Whether it is absolutely stable, in one sentence.
std::string two_port_sentence(const nlohmann::json& result);

}  // namespace gyrator
