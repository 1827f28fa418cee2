#pragma once

#include "gyrator/controllers/controller.hpp"
#include "gyrator/documents/document_spec.hpp"
#include "gyrator/studies/motion_terms.hpp"

#include <optional>
#include <vector>

#include <nlohmann/json.hpp>

namespace gyrator {

/// The kinds of the key "controller" that simulate an environment: virtual_coupling, direct, proxy,
/// equivalent_impedance.
std::vector<ObjectSpec> make_environment_specs(const MotionTerms& terms);

/// From a validated document; none for another kind. `slow_period` of the sampling is the update's
/// period where it has none of its own.
std::optional<Law> parse_environment(const nlohmann::json& document, const Rational& period,
                                     const std::optional<Rational>& slow_period);

/// Throws bad_input, with keys as place, for an update that the loop's period does not allow, and
/// for a slow_period that no environment takes.
void check_environment(const Controller& controller, const Rational& period,
                       const std::optional<Rational>& slow_period);

/// The update of a law that has one.
const SlowUpdate* find_update(const Law& law);

}  // namespace gyrator
