#include "gyrator/studies/tolerance_guarantee.hpp"

#include "gyrator/core/error.hpp"
#include "gyrator/passivity/held_limit.hpp"
#include "gyrator/studies/progress.hpp"
#include "gyrator/studies/result_parts.hpp"

#include <algorithm>
#include <numbers>

namespace gyrator {
namespace {

constexpr std::uint64_t progress_steps = 1U << 20U;

PartBox make_part_box(const DeviceBox& box) {
  PartBox parts;
  for (const Tolerance& t : box.tolerances()) {
    parts.center.push_back((t.low + t.high) / 2);
    parts.half.push_back((t.high - t.low) / 2);
  }
  return parts;
}

}  // namespace

BoxProof prove_tolerances(const Model& model, const BoxBudget& budget, bool quiet) {
  return naming_file(model, [&] {
    if (find_held_impedance(model.device)) {
      throw Error(ErrorCode::bad_input, "damping",
                  "held_impedance: no guarantee over a box of parts for an analog loop around the "
                  "position; leave out --guarantee and rely on the samples");
    }
    const DeviceBox box = model.device_box();
    require_tolerances(box);
    const DiscreteStateSpace law =
        make_contact_law(model.sampled_controller(), model.sampling.period.to_double());
    Progress progress("guarantee", progress_steps, quiet);
    std::uint64_t shown = 0;
    return prove_box([&](std::span<const double> values) { return box.at(values); },
                     make_part_box(box), model.sampling, law, budget,
                     [&](double done) {
                       const auto steps = static_cast<std::uint64_t>(done * progress_steps);
                       if (steps > shown) progress.advance(steps - shown);
                       shown = std::max(shown, steps);
                     });
  });
}

nlohmann::json make_guarantee_json(const Model& model, const BoxProof& proof) {
  nlohmann::json result = {{"verdict", name_of(proof.outcome)},
                           {"boxes", proof.boxes},
                           {"intervals", proof.intervals},
                           {"margin", finite_or_null(proof.margin)},
                           {"at", nullptr},
                           {"frequency_hz", nullptr},
                           {"reason", nullptr}};
  if (proof.outcome == BoxOutcome::passive) return result;
  result["frequency_hz"] = proof.omega / (2 * std::numbers::pi);
  if (!proof.reason.empty()) result["reason"] = proof.reason;
  result["at"] = nlohmann::json::object();
  const auto& tolerances = model.parts.tolerances;
  for (std::size_t i = 0; i < proof.at.size(); ++i) result["at"][tolerances[i].name] = proof.at[i];
  return result;
}

std::string_view name_of(BoxOutcome outcome) {
  switch (outcome) {
    case BoxOutcome::passive:
      return "passive";
    case BoxOutcome::not_passive:
      return "not_passive";
    case BoxOutcome::undecided:
      break;
  }
  return "undecided";
}

}  // namespace gyrator
