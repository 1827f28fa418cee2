#pragma once

#include "gyrator/synthesis/design_study.hpp"

#include <string>

#include <nlohmann/json.hpp>

namespace gyrator {

/// The study as JSON (docs/design.md).
nlohmann::json make_design_result(const DesignSpec& spec, const DesignStudy& study);

/// The same for people.
std::string describe_design(const DesignSpec& spec, const nlohmann::json& result);

}  // namespace gyrator
