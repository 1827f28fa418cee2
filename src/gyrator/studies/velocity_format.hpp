#pragma once

#include "gyrator/controllers/velocity_estimator.hpp"
#include "gyrator/documents/document_spec.hpp"
#include "gyrator/studies/motion_terms.hpp"

#include <vector>

#include <nlohmann/json.hpp>

namespace gyrator {

/// The kinds of velocity estimators in model files, in the units of a motion.
std::vector<ObjectSpec> velocity_specs(const MotionUnits& units);

/// The estimator that a validated object of one of these kinds stands for. `quantum`: the sensor's
/// step [m, rad], the noise of an adaptive window unless it is given; without either the noise is
/// 0, which check_velocity_estimator refuses.
VelocityEstimator parse_velocity_estimator(const nlohmann::json& object, double quantum);

}  // namespace gyrator
