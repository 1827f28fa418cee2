#pragma once

#include "gyrator/studies/model_file.hpp"

#include <string>

namespace gyrator::app {

/// The result's operating point in words: up to which size each nonlinear element is what the
/// answer takes it for, a line each; empty for a linear model.
std::string describe_linear_range(const Model& model, const nlohmann::json& result);

}  // namespace gyrator::app
