#pragma once

#include "gyrator/lanes/lane_runs.hpp"
#include "gyrator/studies/model_file.hpp"

#include <optional>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

namespace gyrator {

/// What the hand does to the wall in each cell of the map.
enum class MapGesture {
  model,  ///< what the model's simulation says: start, efforts, gesture
  hit,    ///< a half sine of 10 ms that gives the port's inertia alone the velocity below
  hold    ///< an effort that rises within 10 ms and stays, half the peak of the hit
};

struct TimeMapRequest {
  std::vector<double> damping;       ///< virtual dampings B, rising [N.s/m, N.m.s/rad]
  std::vector<double> stiffness;     ///< K of the rows, rising [N/m, N.m/rad]; empty: chosen
  int rows = 64;                     ///< where they are chosen
  std::vector<MapGesture> gestures;  ///< empty: the model's if it moves anything, else hit and hold
  std::optional<Rational> duration;  ///< of each run [s]; the model's by default
  int threads = 0;
  bool quiet = true;
};

/// The K-B map by co-simulated gestures with the model's operator: every cell a run of the model's
/// wall with K and B in place of its own, classified as in cosim/classification.hpp; of several
/// gestures the worst. Along the border, between the last row that settles and the first that does
/// not, K is bisected to a thousandth of a cell.
///
/// Linear plants under a wall with a linear velocity go through the lanes, all others cell by cell
/// through the engine that suits the plant. Returns the boundary, {"criterion": "time", "damping",
/// "max_stiffness", "feasible", "worst_frequency_hz"}, with the cells in "map". Throws bad_input
/// for a controller that is no virtual wall, numerical and interrupted.
nlohmann::json make_time_boundary(const Model& model, const TimeMapRequest& request);

}  // namespace gyrator
