#pragma once

#include "gyrator/core/statistics.hpp"
#include "gyrator/studies/limit_sampler.hpp"
#include "gyrator/studies/worst_limit.hpp"

#include <cstdint>
#include <optional>
#include <vector>

#include <nlohmann/json.hpp>

namespace gyrator {

/// What one part does to the limit, the others nominal.
struct PartEffect {
  std::size_t part = 0;  ///< index among the tolerances
  /// Limit with the part at either end of its range.
  double at_low = 0, at_high = 0;
  /// Relative change of the limit per relative change of the part, by central differences:
  ///   e = (dK_max/dp) p/K_max; none for p = 0                                       (tol-5)
  std::optional<double> elasticity;
  /// Relative change of the limit over half the range, linearised:
  ///   S = (dK_max/dp) (high - low)/(2 K_max)                                        (tol-6)
  std::optional<double> sensitivity;
  double rank_correlation = 0;  ///< Spearman's, of part and limit over all samples (stat-3)
};

struct ToleranceRequest {
  std::size_t samples = 10000;
  std::uint64_t seed = 1;
  SampleDistribution distribution = SampleDistribution::uniform;
  int threads = 0;    ///< 0: all
  bool quiet = true;  ///< no progress bar
};

struct ToleranceStudy {
  LimitSample nominal;
  WorstLimit worst;
  std::vector<BoxPoint> samples;    ///< by index
  std::vector<PartEffect> effects;  ///< the strongest first
};

/// Robustness of the model's wall against the tolerances of its parts. The same whatever the
/// number of threads. Throws as LimitSampler, and where the nominal device is unstable alone.
ToleranceStudy run_tolerance_study(const Model& model, const ToleranceRequest& request);

/// The study as JSON (docs/results.md).
nlohmann::json make_tolerance_result(const Model& model, const ToleranceRequest& request,
                                     const ToleranceStudy& study);

/// Whether the wall is passive in every sample and at the worst point.
bool is_robust(const ToleranceStudy& study);

}  // namespace gyrator
