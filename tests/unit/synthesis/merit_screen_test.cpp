#include "gyrator/core/random_stream.hpp"
#include "gyrator/passivity/stiffness_limit.hpp"
#include "gyrator/synthesis/design_problem.hpp"
#include "gyrator/synthesis/pareto_front.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

#include <gtest/gtest.h>

namespace gyrator {
namespace {

using nlohmann::json;

DesignSpec parse(const json& more) {
  json document{{"schema", "gyrator/design/1"},
                {"model", "examples/compare/re25_none.json"},
                {"objective", {{"maximize", "stiffness"}, {"virtual_damping", 1e-4}}},
                {"topologies", {"rc"}},
                {"series", "E12"}};
  document.update(more);
  return parse_design_spec(document, "spec.json");
}

TEST(MeritScreen, NeverSkipsWhatIsBetterAndNeverReturnsWhatIsNot) {
  const DesignSpec spec = parse({{"constraints", {{"apparent_inertia", {{"max", 1e-6}}}}},
                                 {"winding_rise", {"0 K", "40 K"}}});
  const DesignProblem problem(spec, spec.options.front());
  RandomStream random(5, 0);
  int better = 0;
  for (int i = 0; i < 40; ++i) {
    const std::vector<double> values{std::pow(10, 2 * random.uniform() - 0.5),
                                     std::pow(10, 3 * random.uniform() - 5)};
    const DesignMerit least{random.uniform() < 0.8, 0.1 * random.uniform()};
    const DesignMerit merit = judge(spec, problem.evaluate(values));
    if (merit.feasible) {  // just below and just above its own
      EXPECT_TRUE(problem.find_merit_above({true, 0.999 * merit.score}, values)) << i;
      EXPECT_FALSE(problem.find_merit_above({true, 1.001 * merit.score}, values)) << i;
    }
    const auto found = problem.find_merit_above(least, values);
    ASSERT_EQ(found.has_value(), least < merit) << i;
    if (!found) continue;
    ++better;
    EXPECT_EQ(found->score, merit.score);
  }
  EXPECT_GT(better, 5);
  EXPECT_LT(better, 35);
}

TEST(MeritScreen, TheBoundOfALimitIsAboveItAndCloseEnoughToSkipBy) {
  // Where the limit has its lowest point between two of the frequencies that bound it, it is a
  // smooth minimum, passed within half their distance: 6 % at most here, nothing where it is at an
  // end.
  constexpr double loosest = 1.1;
  int walls = 0;
  const DesignSpec spec = parse(json::object());
  const DesignProblem problem(spec, spec.options.front());
  for (const double R : {0.5, 3.0, 30.0}) {
    for (const double C : {30e-6, 180e-6, 2e-3}) {
      const std::vector<double> values{R, C};
      const Device device = problem.make_device(values);
      StiffnessLimits limits(device, spec.model.sampling, problem.make_controller(device, values),
                             FreeOperator{}, GridDensity::coarse);
      for (const double B : {0.0, 1e-5, 1e-4, 3e-4}) {
        const double limit = limits.find_on_grid(B).stiffness;
        const double bound = limits.find_upper_bound(B);
        EXPECT_GE(bound, limit);
        EXPECT_TRUE(std::isfinite(bound));
        if (limit == 0) continue;  // no wall at all, by what the bound does not look at
        ++walls;
        EXPECT_LE(bound, loosest * limit) << R << " ohm, " << C << " F, " << B << " N.m.s/rad";
      }
    }
  }
  EXPECT_GT(walls, 15);
}

TEST(ParetoFront, HasTheBestResistorOfEveryCapacitorThatHelps) {
  const DesignSpec spec = parse({{"constraints", {{"apparent_inertia", {{"max", 6e-8}}}}},
                                 {"ranges", {{"rc.capacitance", {47e-6, 470e-6}}}}});
  const DesignProblem problem(spec, spec.options.front());
  const auto lattice = problem.lattice();
  const DesignConstraint* bound = spec.constraints.data();
  // By trying all of it.
  std::vector<Candidate> all;
  for (const double R : lattice[0]) {
    for (const double C : lattice[1]) {
      Candidate candidate{&problem.option(), {R, C}, {}, {}};
      candidate.figures = problem.evaluate(candidate.values, LimitPrecision::on_grid, bound);
      candidate.merit = judge(spec, candidate.figures);
      all.push_back(candidate);
    }
  }
  const auto best = find_pareto(spec, all);
  ASSERT_GE(best.size(), 5U);
  EXPECT_GT(best.back().figures.apparent_inertia, 6e-8) << "its own bound does not count here";
  const auto start = std::find_if(all.begin(), all.end(), [&](const Candidate& candidate) {
    return judge(spec, candidate.figures, bound).feasible;
  });
  ASSERT_TRUE(start != all.end());
  const auto found = find_pareto(spec, sweep_inertia(problem, {*start}));
  ASSERT_EQ(found.size(), best.size());
  for (std::size_t i = 0; i < best.size(); ++i) {
    EXPECT_EQ(found[i].figures.max_stiffness, best[i].figures.max_stiffness) << i;
  }
}

}  // namespace
}  // namespace gyrator
