#include "gyrator/synthesis/design_search.hpp"

#include "gyrator/core/random_stream.hpp"

#include <cmath>
#include <complex>
#include <numbers>

#include <gtest/gtest.h>

#include "support/design_problems.hpp"

namespace gyrator {
namespace {

using nlohmann::json;

constexpr double K_t = 23.5e-3;
constexpr double R_m = 2.06;

json rc_spec() {
  return {{"schema", "gyrator/design/1"},
          {"model", "examples/compare/re25_none.json"},
          {"objective", {{"maximize", "stiffness"}, {"virtual_damping", 1e-4}}},
          {"topologies", {"rc"}},
          {"series", "E12"}};
}

DesignSpec parse(const json& document) {
  return parse_design_spec(document, "spec.json");
}

TEST(DesignProblem, FiguresOfAnRcAreTheClosedForms) {
  json document = rc_spec();
  document["operation"] = {{"speed", 50}, {"effort", 0.01}, {"frequency", 10}};
  document["constraints"] = {{"capacitor_voltage", {{"max", 100}}}};
  const DesignSpec spec = parse(document);
  const DesignProblem problem(spec, spec.options.front());
  const double C = 470e-6;
  const DesignFigures figures = problem.evaluate(std::vector<double>{4.7, C});
  ASSERT_TRUE(figures.stable);
  // Below its corner of 50 Hz the branch holds all of the back-EMF, at rest exactly; (f/f_c)^2 of
  // 1 mHz is 4e-10.
  EXPECT_NEAR(figures.apparent_inertia, K_t * K_t * C, 1e-6 * K_t * K_t * C);
  EXPECT_NEAR(figures.extremes.capacitor_voltage, K_t * 50 + R_m * 0.01 / K_t,
              1e-6 * figures.extremes.capacitor_voltage);
  EXPECT_GE(figures.extremes.amplifier_voltage, figures.extremes.capacitor_voltage * (1 - 1e-9));
  // The command's current at 1 mHz and above is that of the blocked effort.
  EXPECT_NEAR(figures.extremes.amplifier_current, 0.01 / K_t, 1e-4 * 0.01 / K_t);
  // Worst at 10 Hz: i = j w C e / (1 + j w C (R + R_m) - w^2 L C), and the command's share.
  const double w = 2 * std::numbers::pi * 10;
  const std::complex<double> s(0, w);
  const std::complex<double> loop = 1.0 + s * C * (4.7 + R_m) + s * s * C * 0.238e-3;
  const double by_speed = std::abs(s * C * K_t / loop) * 50;
  const double by_effort = std::abs(s * C * (R_m + s * 0.238e-3) / loop) * 0.01 / K_t;
  const double current = by_speed + by_effort;
  EXPECT_NEAR(figures.extremes.resistor_power, current * current * 4.7,
              1e-3 * current * current * 4.7);
}

TEST(DesignProblem, AConstraintHoldsOnOneSideOfItsLimitOnly) {
  const double inertia = K_t * K_t * 470e-6;
  for (const double factor : {0.999, 1.001}) {
    json document = rc_spec();
    document["constraints"] = {{"apparent_inertia", {{"max", factor * inertia}}}};
    const DesignSpec spec = parse(document);
    const DesignProblem problem(spec, spec.options.front());
    const DesignFigures figures = problem.evaluate(std::vector<double>{4.7, 470e-6});
    EXPECT_EQ(judge(spec, figures).feasible, factor > 1);
    EXPECT_NEAR(find_violation(spec.constraints.front(), figures),
                factor > 1 ? 0 : -std::log(factor), 1e-6);
    const DesignConstraint* free = spec.constraints.data();
    const DesignFigures freed =
        problem.evaluate(std::vector<double>{4.7, 470e-6}, LimitPrecision::on_grid, free);
    EXPECT_TRUE(judge(spec, freed, free).feasible);
  }
}

TEST(DesignProblem, TheWorstOverTheWindingsTemperaturesCounts) {
  json document = rc_spec();
  const std::vector<double> values{2, 470e-6};
  const DesignSpec cold = parse(document);
  document["winding_rise"] = {"-20 K", "60 K"};
  const DesignSpec wide = parse(document);
  const double own = DesignProblem(cold, cold.options.front()).evaluate(values).max_stiffness;
  const double worst = DesignProblem(wide, wide.options.front()).evaluate(values).max_stiffness;
  // Bound at rest, where K = (b + B)/(T/2 + R_m C + lag of the amplifier): the warm winding.
  const auto lag = [](double rise) {
    const double resistance = R_m * (1 + copper_temperature_coefficient * rise);
    return 0.5e-3 + resistance * 470e-6 + 1 / (2 * std::numbers::pi * 5000);
  };
  EXPECT_NEAR(worst / own, lag(0) / lag(60), 2e-3);
}

TEST(DesignProblem, ACancellationThatOscillatesWhenColdIsNoDesign) {
  json document = rc_spec();
  document["topologies"] = {"resistance_cancellation"};
  const DesignSpec warm = parse(document);
  document["winding_rise"] = {"-30 K", "0 K"};
  const DesignSpec cold = parse(document);
  const std::vector<double> values{0.9};
  EXPECT_TRUE(DesignProblem(warm, warm.options.front()).evaluate(values).stable);
  EXPECT_FALSE(DesignProblem(cold, cold.options.front()).evaluate(values).stable);
}

TEST(DesignSearch, NoPairOfAFineLatticeIsBetter) {
  for (std::uint64_t i = 0; i < 4; ++i) {
    const DesignSpec spec = testing::make_design_problem(i);
    const DesignProblem problem(spec, spec.options.front());
    const Candidate found = search_option(problem).best;
    ASSERT_TRUE(found.merit.feasible) << i;
    EXPECT_FALSE(found.merit < testing::try_all_pairs(problem, 60)) << i;
  }
}

// The series' best by trying all of it.
DesignMerit try_all(const DesignProblem& problem) {
  DesignMerit best{false, -HUGE_VAL};
  const auto lattice = problem.lattice();
  for (const double R : lattice[0]) {
    for (const double C : lattice[1]) {
      const DesignMerit merit = judge(problem.spec(), problem.evaluate(std::vector<double>{R, C}));
      if (best < merit) best = merit;
    }
  }
  return best;
}

TEST(DesignSearch, FindsTheBestOfAllPairsInTenProblems) {
  RandomStream random(8, 0);
  for (int i = 0; i < 10; ++i) {
    json document = rc_spec();
    document["model"] =
        i % 2 == 0 ? "examples/compare/re25_none.json" : "examples/compare/re35_none.json";
    const double R = std::pow(10, random.uniform() - 0.5);
    const double C = std::pow(10, random.uniform() - 4.5);
    document["objective"]["virtual_damping"] = std::pow(10, random.uniform() - 4.5);
    document["ranges"] = {{"rc.resistance", {R, 12 * R}}, {"rc.capacitance", {C, 12 * C}}};
    document["constraints"] = {
        {"apparent_inertia", {{"max", std::pow(10, 1.5 * random.uniform() - 7.5)}}}};
    document["seed"] = i + 1;
    const DesignSpec spec = parse(document);
    const DesignProblem problem(spec, spec.options.front());
    const DesignMerit best = try_all(problem);
    const OptionSearch found = search_option(problem);
    EXPECT_EQ(found.best.merit.feasible, best.feasible) << i;
    EXPECT_DOUBLE_EQ(found.best.merit.score, best.score) << i;
    EXPECT_FALSE(found.continuous.merit < found.best.merit) << i;
  }
}

}  // namespace
}  // namespace gyrator
