// Designs against brute force: the best of 200 x 200 pairs (R_1, C), evenly spaced in their
// logarithms over the same ranges, for ten seeded problems of RE25 and RE35. Run from the
// repository's root: build/release/bench/design_study [first] [last] [side]

#include "gyrator/core/random_stream.hpp"
#include "gyrator/studies/parallel.hpp"
#include "gyrator/synthesis/design_search.hpp"

#include <chrono>
#include <cmath>
#include <cstdlib>
#include <mutex>

#include <fmt/core.h>

namespace gyrator {
namespace {

// Every other problem of RE25 and RE35; what bounds it besides the apparent inertia goes round.
DesignSpec make_problem(std::uint64_t index) {
  RandomStream random(2026, index);
  const double damping = std::pow(10, random.uniform() - 4.5);
  const bool small = index % 2 == 0;
  const double inertia = (small ? 1e-8 : 3e-8) * std::pow(10, random.uniform());
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
  if (index % 5 == 1)
    constraints["damping_below_5_hz"] = {{"max", own_damping * (1 + 0.005 * share)}};
  if (index % 5 == 2) {
    document["operation"] = {{"speed", 100}, {"effort", 0.02}};
    constraints["resistor_power"] = {{"max", 5e-3 * share}};
  }
  if (index % 5 == 3) document["winding_rise"] = {"-20 K", fmt::format("{} K", 100 * share)};
  if (index % 5 == 4)
    constraints["damping_below_5_hz"] = {{"max", own_damping * (1 + 0.02 * share)}};
  return parse_design_spec(document, "spec.json");
}

// The best of all pairs. A coarse lattice first: with a good one known, most others are seen to be
// no better by what is cheap to know of them.
DesignMerit try_all(const DesignProblem& problem, std::size_t side) {
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

// What keeps the design from being stiffer.
std::string name_binding(const DesignSpec& spec, const Candidate& found) {
  std::string text;
  for (const DesignConstraint& constraint : spec.constraints) {
    const double share = constraint.figure->value(found.figures) / constraint.limit;
    if (share > 0.999)
      text += fmt::format("{}{}", text.empty() ? "" : ", ", constraint.figure->name);
  }
  return text.empty() ? "none" : text;
}

double seconds_since(std::chrono::steady_clock::time_point start) {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

int run(std::size_t first, std::size_t last, std::size_t side) {
  int worse = 0;
  fmt::print(
      "| problem | R_1 | C | design K | lattice K | ratio | binds | design s | lattice s |\n"
      "| --- | --- | --- | --- | --- | --- | --- | --- | --- |\n");
  for (std::size_t i = first; i <= last; ++i) {
    const DesignSpec spec = make_problem(i);
    const DesignProblem problem(spec, spec.options.front());
    auto start = std::chrono::steady_clock::now();
    const Candidate best = search_option(problem).best;
    const DesignMerit found = best.merit;
    const double design_s = seconds_since(start);
    start = std::chrono::steady_clock::now();
    const DesignMerit all = try_all(problem, side);
    const bool is_worse = found < all;
    worse += is_worse ? 1 : 0;
    fmt::print("| {} {} | {} | {} | {} | {} | {:.5f}{} | {} | {:.1f} | {:.1f} |\n", i,
               spec.model.name.substr(0, 4), format_quantity(best.values[0], dimension::resistance),
               format_quantity(best.values[1], dimension::capacitance),
               format_quantity(found.score, dimension::rotary_stiffness),
               format_quantity(all.score, dimension::rotary_stiffness), found.score / all.score,
               is_worse ? " worse" : "", name_binding(spec, best), design_s, seconds_since(start));
    std::fflush(stdout);
  }
  return worse == 0 ? 0 : 1;
}

}  // namespace
}  // namespace gyrator

int main(int argc, char** argv) {
  const auto argument = [&](int i, unsigned long fallback) {
    return argc > i ? std::strtoul(argv[i], nullptr, 10) : fallback;
  };
  return gyrator::run(argument(1, 0), argument(2, 9), argument(3, 200));
}
