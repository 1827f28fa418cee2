// Designs against brute force: the best of 200 x 200 pairs (R_1, C), evenly spaced in their
// logarithms over the same ranges, for ten seeded problems of RE25 and RE35. Run from the
// repository's root: build/release/bench/design_study [first] [last] [side]

#include "gyrator/synthesis/design_search.hpp"

#include <chrono>
#include <cmath>
#include <cstdlib>

#include <fmt/core.h>

#include "support/design_problems.hpp"

namespace gyrator {
namespace {

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
    const DesignSpec spec = testing::make_design_problem(i);
    const DesignProblem problem(spec, spec.options.front());
    auto start = std::chrono::steady_clock::now();
    const Candidate best = search_option(problem).best;
    const DesignMerit found = best.merit;
    const double design_s = seconds_since(start);
    start = std::chrono::steady_clock::now();
    const DesignMerit all = testing::try_all_pairs(problem, side);
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
