#pragma once

#include "gyrator/studies/model_file.hpp"

#include <optional>
#include <string>

namespace gyrator {

/// "operating_point" of a result: at which point a linear answer holds, and how far around it each
/// nonlinear element keeps its slope within 1 %. Null for a linear model.
nlohmann::json make_operating_point_fields(const Model& model);

/// The first element that makes the model nonlinear as it is simulated; none if nothing does.
std::optional<std::string> find_nonlinear_element(const Model& model);

}  // namespace gyrator
