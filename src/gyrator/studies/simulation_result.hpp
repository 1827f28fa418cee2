#pragma once

#include "gyrator/studies/model_file.hpp"

#include <optional>

#include <nlohmann/json.hpp>

namespace gyrator {

struct SimulationRequest {
  std::optional<EngineKind> engine;  ///< none: exact for a linear model, cvode for any other
  EngineOptions engine_options;
  std::optional<Rational> duration, trace_step;
  bool quiet = true;  ///< no progress bar
  /// A failure on the way comes back in TimeRun::failure, with the run up to there.
  bool keep_failed = false;
};

/// The run itself (for CSV). Throws bad_input for a recorded gesture that ends before the run;
/// numerical, naming the element, where the numbers of the run cannot be trusted: overflow, or an
/// energy ledger that does not close.
TimeRun run_simulation(const Model& model, const SimulationRequest& request);

/// The run as a result; long traces are thinned for it. A run that failed is not classified.
nlohmann::json make_simulation_result(const Model& model, const TimeRun& run);

}  // namespace gyrator
