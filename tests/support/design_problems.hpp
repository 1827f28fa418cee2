#pragma once

#include "gyrator/core/random_stream.hpp"
#include "gyrator/studies/parallel.hpp"
#include "gyrator/synthesis/design_problem.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <mutex>
#include <vector>

#include <fmt/core.h>

// Problems for `design` with an RC branch, and their solution by trying all.

namespace gyrator::testing {

/// Every other problem of RE25 and RE35; what bounds it besides the apparent inertia goes round.
/// Files are relative to the repository's root.
inline DesignSpec make_design_problem(std::uint64_t index) {
  RandomStream random(2026, index);
  const double damping = std::pow(10, random.uniform() - 4.5);
  const bool small = index % 2 == 0;
  // Near what the best branch without such a bound has, so that it binds in about half of them.
  const double inertia = 1.1e-3 * damping * (0.6 + 0.8 * random.uniform());
  nlohmann::json document{
      {"schema", "gyrator/design/1"},
      {"model", small ? "examples/compare/re25_none.json" : "examples/compare/re35_none.json"},
      {"objective", {{"maximize", "stiffness"}, {"virtual_damping", damping}}},
      {"topologies", {"rc"}},
      {"series", "none"},
      {"ranges", {{"rc.resistance", {0.1, 100}}, {"rc.capacitance", {1e-6, 1e-2}}}},
      {"constraints", {{"apparent_inertia", {{"max", inertia}}}}},
      {"seed", index + 1}};
  auto& constraints = document["constraints"];
  const double share = 0.2 + 0.6 * random.uniform();
  const double own_damping = small ? 1.2e-6 : 6.33e-6;
  if (index % 5 == 1 || index % 5 == 4)
    constraints["damping_below_5_hz"] = {{"max", own_damping + 2e-8 + 3e-8 * share}};
  if (index % 5 == 2) {
    document["operation"] = {{"speed", 100}, {"effort", 0.02}};
    constraints["resistor_power"] = {{"max", 5e-3 * share}};
  }
  if (index % 5 == 3) document["winding_rise"] = {"-20 K", fmt::format("{} K", 100 * share)};
  return parse_design_spec(document, "spec.json");
}

/// The best of side x side pairs, evenly spaced in their logarithms over the ranges. A coarse
/// lattice first: with a good one known, most others are seen to be no better by what is cheap to
/// know of them (find_merit_above).
inline DesignMerit try_all_pairs(const DesignProblem& problem, std::size_t side) {
  DesignMerit best{false, -HUGE_VAL};
  std::mutex guard;
  const auto value = [&](std::size_t variable, std::size_t i) {
    const auto [low, high] = problem.option().values[variable].range;
    return low * std::pow(high / low, static_cast<double>(i) / static_cast<double>(side - 1));
  };
  const auto try_one = [&](std::size_t i, std::size_t j) {
    const std::vector<double> values{value(0, i), value(1, j)};
    DesignMerit known;
    {
      const std::scoped_lock lock(guard);
      known = best;
    }
    const auto merit = problem.find_merit_above(known, values);
    if (!merit) return;
    const std::scoped_lock lock(guard);
    best = std::max(best, *merit);
  };
  constexpr std::size_t step = 8;
  const std::size_t coarse = (side + step - 1) / step;
  run_parallel(coarse * coarse, 0,
               [&](std::size_t i) { try_one(i / coarse * step, i % coarse * step); });
  run_parallel(side * side, 0, [&](std::size_t i) { try_one(i / side, i % side); });
  return best;
}

}  // namespace gyrator::testing
