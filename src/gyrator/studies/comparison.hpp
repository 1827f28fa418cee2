#pragma once

#include "gyrator/studies/model_file.hpp"

#include <vector>

#include <nlohmann/json.hpp>

namespace gyrator {

struct ComparisonRequest {
  std::vector<double> damping;   ///< virtual dampings B; empty: each design's own range
  int points = 61;               ///< of that range
  double temperature_step = 25;  ///< winding colder and warmer by this [K]
  bool quiet = true;             ///< no progress bar
};

/// Designs side by side (`gyrator compare`): largest passive stiffness over virtual damping by the
/// exact disk, and what the device feels like in free air: damping at 1 Hz and 100 Hz, apparent
/// inertia Im Z/w at 1 Hz; and what is left of stiffness and damping with the winding colder and
/// warmer. A held impedance is felt without its wall. All designs have the same motion; throws
/// bad_input naming the file that differs.
nlohmann::json make_comparison_result(const std::vector<Model>& models,
                                      const ComparisonRequest& request);

}  // namespace gyrator
