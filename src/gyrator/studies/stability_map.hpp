#pragma once

#include "gyrator/studies/model_file.hpp"

#include <string_view>
#include <vector>

#include <nlohmann/json.hpp>

namespace gyrator {

/// What a sampled spring wall with encoder and dry friction does after being disturbed.
enum class StabilityRegion {
  passive,         ///< comes to rest after any kick
  locally_stable,  ///< comes to rest after a small kick, grows after a large one
  limit_cycle,     ///< neither rests nor grows
  unstable         ///< grows after every kick
};
std::string_view name_of(StabilityRegion region);

/// The plane of damping and friction, made dimensionless by the wall's stiffness K, the period T
/// and the encoder's quantum Delta:
///   beta = b/(K T)  [8.17],   sigma = f_c/(K Delta)  [8.18],   velocity xi' = v T/Delta  [8.21]
/// Per period sampling, delay t_d and quantization can make K (v T)^2 (1/2 + t_d/T) + K Delta |v
/// T|/2 of energy, damper and friction take b v^2 T + f_c |v| T, so that what they take is enough
/// where
///   (beta - beta_0) |xi'| + (sigma - 1/2) >= 0,   beta_0 = 1/2 + t_d/T             (plane-1)
/// at every velocity for beta >= beta_0 and sigma >= 1/2; up to a largest velocity for sigma > 1/2
/// alone (locally stable: sigma > 1/2 + xi'_max (beta_0 - beta)); above one for beta > beta_0 alone
/// (limit cycles).
/// These are worst cases. For a sinusoid of peak velocity xi' the mean of v^2 is pi/4 of the peak
/// times the mean of |v|, and a staircase passed quickly makes no energy, so that it dies out for
///   sigma > pi/4 xi' (beta_0 - beta)                                             (plane-2)
/// Source: Diolaiti, Niemeyer, Barbagli and Salisbury 2006, fig. 8.8.
StabilityRegion judge_stability_region(double beta, double sigma, double delay_in_periods,
                                       double largest_velocity);

struct StabilityMapRequest {
  std::vector<double> beta, sigma;
  double small_velocity = 0.25;  ///< of the small kick, xi'
  double large_velocity = 4;     ///< of the large one, xi'_max
  Rational duration{0};          ///< of each run [s]; 0: 60 periods of the free oscillation
  bool quiet = true;             ///< no progress bar
};

/// Simulated regions (`gyrator stability-map`) over the plane: the model's device with b = beta K T
/// and f_c = sigma K Delta in place of its own, its wall kept in contact, and the constant hand
/// effort K Delta/2 that puts the equilibrium on the edge between two quanta. Throws bad_input for
/// a model without a virtual wall, without stiffness or without an encoder quantum, with a
/// gesture, or with wrappers that are not linear.
nlohmann::json make_stability_map_result(const Model& model, const StabilityMapRequest& request);

}  // namespace gyrator
