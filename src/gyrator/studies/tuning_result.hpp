#pragma once

#include "gyrator/plots/plot.hpp"
#include "gyrator/studies/model_file.hpp"
#include "gyrator/studies/report_sections.hpp"
#include "gyrator/tuning/tuning_run.hpp"

#include <string>

#include <nlohmann/json.hpp>

namespace gyrator {

/// What a tuning found and did; command "tune", without the keys of the device's session (plan,
/// applied, state, journal). `verdict` is "passive", "not_passive", or null where nothing was
/// measured to its end.
nlohmann::json make_tuning_result(const Model& identified, const TuningOptions& options,
                                  const TuningRun& run);

/// The same for a plan: what would be set, by the model alone.
nlohmann::json make_tuning_plan_result(const Model& identified, const TuningOptions& options,
                                       const TuningChoice& choice);

/// The identified model's file with the circuit that was set, and the winding as warm as it was.
nlohmann::json make_tuned_model(const Model& identified, const TuningChoice& choice);

/// Damping and actuation over frequency, measured and modelled; the steps; the ring-down.
Figure tuning_figure(const nlohmann::json& result);

ReportSection tuning_section(const nlohmann::json& result);
std::string tuning_sentence(const nlohmann::json& result);

}  // namespace gyrator
