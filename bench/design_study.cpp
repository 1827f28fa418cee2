// Designs against brute force: the best of 200 x 200 pairs (R_1, C), evenly spaced in their
// logarithms over the same ranges, for ten seeded problems of RE25 and RE35. Run from the
// repository's root: build/release/bench/design_study [problems] [side]

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

DesignSpec make_problem(std::uint64_t index) {
  RandomStream random(2026, index);
  const double damping = std::pow(10, random.uniform() - 4.5);
  const double inertia = std::pow(10, 2 * random.uniform() - 8);
  const nlohmann::json document{
      {"schema", "gyrator/design/1"},
      {"model",
       index % 2 == 0 ? "examples/compare/re25_none.json" : "examples/compare/re35_none.json"},
      {"objective", {{"maximize", "stiffness"}, {"virtual_damping", damping}}},
      {"topologies", {"rc"}},
      {"series", "none"},
      {"ranges", {{"rc.resistance", {0.1, 100}}, {"rc.capacitance", {1e-6, 1e-2}}}},
      {"constraints", {{"apparent_inertia", {{"max", inertia}}}}},
      {"seed", index + 1}};
  return parse_design_spec(document, "spec.json");
}

DesignMerit try_all(const DesignProblem& problem, std::size_t side) {
  DesignMerit best{false, -HUGE_VAL};
  std::mutex guard;
  const auto value = [&](std::size_t variable, std::size_t i) {
    const auto [low, high] = problem.option().values[variable].range;
    return low * std::pow(high / low, static_cast<double>(i) / static_cast<double>(side - 1));
  };
  run_parallel(side * side, 0, [&](std::size_t i) {
    const std::vector<double> values{value(0, i / side), value(1, i % side)};
    const DesignMerit merit = judge(problem.spec(), problem.evaluate(values));
    const std::scoped_lock lock(guard);
    if (best < merit) best = merit;
  });
  return best;
}

double seconds_since(std::chrono::steady_clock::time_point start) {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

int run(std::size_t problems, std::size_t side) {
  int worse = 0;
  fmt::print("{:>8} {:>14} {:>14} {:>10} {:>9} {:>9}\n", "problem", "design", "lattice", "ratio",
             "design s", "lattice s");
  for (std::size_t i = 0; i < problems; ++i) {
    const DesignSpec spec = make_problem(i);
    const DesignProblem problem(spec, spec.options.front());
    auto start = std::chrono::steady_clock::now();
    const DesignMerit found = search_option(problem).best.merit;
    const double design_s = seconds_since(start);
    start = std::chrono::steady_clock::now();
    const DesignMerit all = try_all(problem, side);
    const bool is_worse = found < all;
    worse += is_worse ? 1 : 0;
    fmt::print("{:>8} {:>14.6g} {:>14.6g} {:>10.6f} {:>9.2f} {:>9.2f}{}\n", i, found.score,
               all.score, found.score / all.score, design_s, seconds_since(start),
               is_worse ? "  <- worse" : "");
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
  return gyrator::run(argument(1, 10), argument(2, 200));
}
