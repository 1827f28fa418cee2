#pragma once

#include "gyrator/core/random_stream.hpp"
#include "gyrator/studies/model_file.hpp"

#include <cstdint>
#include <span>
#include <string_view>
#include <vector>

namespace gyrator {

/// The stiffness and damping of the model's wall, sampled or held. Throws bad_input for a controller
/// that has no wall whose stiffness could be limited.
WallValues require_wall(const Model& model);

/// What becomes of the model's wall on one device of the box.
enum class WallOutcome {
  passive,
  too_stiff,        ///< its K is above the limit
  no_stiffness,     ///< not even K = 0 is passive at its B
  device_active,    ///< the device supplies energy by itself, Re Z < 0 somewhere
  device_unstable,  ///< the device oscillates by itself
};
std::string_view name_of(WallOutcome outcome);

struct LimitSample {
  double max_stiffness = 0;  ///< by the exact disk at the model's B [N.m/rad, N/m]; 0: none
  double worst_frequency_hz = 0;
  WallOutcome outcome = WallOutcome::passive;
};

/// How a sample's limit is found.
enum class LimitSearch {
  proved,  ///< between the grid's frequencies too
  on_grid  ///< for a great many samples
};

/// The passive limit of a model's wall for any device of its box. From many threads at once.
class LimitSampler {
 public:
  /// Throws bad_input for a model without tolerances, or whose controller has no wall to limit.
  explicit LimitSampler(const Model& model);

  LimitSample at(std::span<const double> values, LimitSearch search = LimitSearch::proved) const;

  const DeviceBox& box() const { return box_; }
  const WallValues& wall() const { return wall_; }

 private:
  bool is_passive_above_limit(const Device& device) const;

  DeviceBox box_;
  WallValues wall_;
  Controller controller_;
  Sampling sampling_;
  double quantum_;
};

enum class SampleDistribution {
  uniform,  ///< over the whole range
  normal    ///< low and high are 3 standard deviations from the nominal value, and are the ends
};
std::string_view name_of(SampleDistribution distribution);

/// The values of sample `index`: of a stream of random numbers of its own, so that they do not
/// depend on who computes which sample. Parts are independent of one another.
///   uniform: p = low + u (high - low), u in [0, 1)                                  (tol-3)
///   normal:  p = nominal + z s, z standard normal within ± 3, s = (high - nominal)/3 for z >= 0,
///            (nominal - low)/3 for z < 0                                            (tol-4)
std::vector<double> draw_values(const std::vector<Tolerance>& tolerances, std::uint64_t seed,
                                std::uint64_t index, SampleDistribution distribution);

}  // namespace gyrator
