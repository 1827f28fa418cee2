#pragma once

#include "gyrator/synthesis/design_problem.hpp"

#include <functional>
#include <vector>

namespace gyrator {

/// Values for one option, and what they are worth.
struct Candidate {
  const DesignOption* option = nullptr;
  std::vector<double> values;
  DesignFigures figures;
  DesignMerit merit;
};

struct OptionSearch {
  Candidate best;                     ///< of the lattice; of any values where there is no series
  Candidate continuous;               ///< best of any values
  std::vector<Candidate> on_lattice;  ///< all that can be had and was looked at
  std::vector<Candidate> seen;        ///< all
};

/// Steps of a search that its progress counts, for one option; an estimate.
std::size_t count_search_steps(const DesignProblem& problem);

/// Searches one option in the logarithms of its values, by the limit at the grid's frequencies:
///   1. a jittered grid over the ranges                                        on all cores
///   2. controlled random search with local mutation (NLopt, CRS2) over them
///   3. Subplex (NLopt, SBPLX) from the best so far, then a mesh around it that is halved until its
///      steps are 1e-4: the best often lies where a constraint ends, where others stop short
///   4. the lattice of values that can be had, climbed from the neighbours of the best ones, by
///      their own merit: what is best there need not be the rounded best
/// Random numbers come from the spec's seed alone; the result does not depend on the cores.
/// `free` as in judge().
OptionSearch search_option(const DesignProblem& problem, const DesignConstraint* free = nullptr,
                           const std::function<void(std::size_t)>& advance = {});

}  // namespace gyrator
