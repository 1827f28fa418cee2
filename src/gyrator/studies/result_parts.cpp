#include "gyrator/studies/result_parts.hpp"

#include "gyrator/version.hpp"

#include <cmath>

#include <fmt/core.h>

namespace gyrator {

using nlohmann::json;

json start_result(const char* command, const Model& model) {
  return {{"schema", "gyrator/result/1"},
          {"command", command},
          {"program", fmt::format("gyrator {}", version)},
          {"model_name", model.name},
          {"model", model.source},
          {"units", unit_names(model.device.motion)}};
}

json finite_or_null(double value) {
  return std::isfinite(value) ? json(value) : json(nullptr);
}

}  // namespace gyrator
