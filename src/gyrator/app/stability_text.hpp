#pragma once

#include "gyrator/studies/model_file.hpp"

#include <string>

namespace gyrator::app {

/// The result's stability edges in words, a line for each way to hold the port; empty if it has
/// none.
std::string describe_stability_edges(const Model& model, const nlohmann::json& result);

}  // namespace gyrator::app
