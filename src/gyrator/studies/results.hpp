#pragma once

#include "gyrator/passivity/verdict.hpp"
#include "gyrator/studies/model_file.hpp"
#include "gyrator/studies/simulation_result.hpp"
#include "gyrator/studies/spice_check.hpp"
#include "gyrator/studies/time_map.hpp"

#include <optional>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

namespace gyrator {

// The answers of the commands as JSON (docs/results.md): what --json prints, -o keeps, the figures
// draw and the report shows. Every one has command, program, model_name, model and units.

/// Z, A and Re Z over frequency, straight from the network's equations.
nlohmann::json make_impedance_result(const Model& model, const std::vector<double>& frequency_hz);

struct PassivityRequest {
  bool search_counterexample = true;
  bool simulate_counterexample = false;
};
struct PassivityAnswer {
  Verdict verdict;
  nlohmann::json result;
};
/// Verdict, criteria, damping curves, the disk at the worst frequency, the proof in figures, the
/// operator that breaks the loop and, if asked for, the run that shows it.
PassivityAnswer answer_passivity(const Model& model, const PassivityRequest& request);
nlohmann::json make_passivity_result(const Model& model, const PassivityRequest& request);

struct ZwidthRequest {
  std::vector<double> damping;  ///< virtual dampings B [N.s/m, N.m.s/rad]
  std::vector<Criterion> criteria;
  bool quiet = true;                   ///< no progress bar
  std::optional<TimeMapRequest> time;  ///< one more boundary, by co-simulation
};
/// Largest stiffness over virtual damping, one boundary per criterion.
nlohmann::json make_zwidth_result(const Model& model, const ZwidthRequest& request);

/// Virtual dampings that show the whole boundary: from -b to where the exact disk's limit ends.
std::vector<double> choose_damping_range(const Model& model, int points);

/// The netlist, with ngspice's deviations where it has been checked.
nlohmann::json make_spice_result(const Model& model, const SpiceDeck& deck,
                                 const std::optional<std::vector<SpiceDeviation>>& check);

}  // namespace gyrator
