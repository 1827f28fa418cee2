#pragma once

#include "gyrator/synthesis/design_search.hpp"

#include <functional>
#include <vector>

namespace gyrator {

/// Front of one option over the lattice of values that can be had: for 40 bounds on the apparent
/// inertia, from the lightest that was found to the stiffest without such a bound, the stiffest
/// within it, climbed from the one before. All that was looked at on the way.
std::vector<Candidate> sweep_inertia(const DesignProblem& problem,
                                     const std::vector<Candidate>& found,
                                     const std::function<void(std::size_t)>& advance = {});

/// Steps that its progress counts; an estimate.
inline constexpr std::size_t sweep_steps = 400;

/// Those of the candidates that no other beats in both stiffness and apparent inertia, the lightest
/// first, at most 40. All constraints are kept but the bound on the apparent inertia.
std::vector<Candidate> find_pareto(const DesignSpec& spec, std::vector<Candidate> candidates);

}  // namespace gyrator
