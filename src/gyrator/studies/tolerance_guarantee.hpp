#pragma once

#include "gyrator/robustness/box_proof.hpp"
#include "gyrator/studies/model_file.hpp"

#include <string_view>

#include <nlohmann/json.hpp>

namespace gyrator {

/// The model's wall with every choice of parts within their tolerances: a proof, a choice that is
/// not passive, or neither within the budget. Throws bad_input for a model without tolerances, a
/// held impedance, and as prove_box().
BoxProof prove_tolerances(const Model& model, const BoxBudget& budget, bool quiet = true);

/// {verdict, boxes, intervals, margin, at {name: value}, frequency_hz, reason}
nlohmann::json make_guarantee_json(const Model& model, const BoxProof& proof);

std::string_view name_of(BoxOutcome outcome);

}  // namespace gyrator
