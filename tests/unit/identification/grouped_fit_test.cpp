#include "gyrator/identification/grouped_fit.hpp"

#include "gyrator/core/error.hpp"
#include "gyrator/core/random_stream.hpp"

#include <cmath>
#include <vector>

#include <gtest/gtest.h>

namespace gyrator {
namespace {

constexpr int groups = 16, in_group = 12;

// y = 3 x - 2, with noise of each equation and an error that a whole group shares.
std::vector<Equation> make_equations(double noise, double shared, RandomStream& random) {
  std::vector<Equation> equations;
  for (int g = 0; g < groups; ++g) {
    const double error = shared * random.normal();
    for (int k = 0; k < in_group; ++k) {
      Equation equation;
      const double x = random.uniform() + g;
      equation.x = Eigen::Vector2d(x, 1);
      equation.y = 3 * x - 2 + error + noise * random.normal();
      equation.group = g;
      equations.push_back(equation);
    }
  }
  return equations;
}

TEST(GroupedFit, SolvesWhatHasNoError) {
  RandomStream random(1, 1);
  const GroupedFit fit = fit_grouped(make_equations(0, 0, random));
  EXPECT_NEAR(fit.values[0], 3, 1e-10);
  EXPECT_NEAR(fit.values[1], -2, 1e-10);
  EXPECT_LT(fit.at(0).deviation, 1e-9);
}

// 200 intervals of 90 %, 1.2 times as wide: as those of 95 %, 10 misses with a deviation of 3.
TEST(GroupedFit, IntervalsHoldWhereErrorsAreSharedInAGroup) {
  for (const double shared : {0.0, 0.3}) {
    RandomStream random(3, 1);
    int misses = 0;
    double bias = 0, deviation = 0;
    for (int repetition = 0; repetition < 200; ++repetition) {
      const GroupedFit fit = fit_grouped(make_equations(0.1, shared, random));
      const Interval interval = find_interval(fit.at(0), 0.90);
      misses += interval.low > 3 || interval.high < 3;
      bias += (fit.values[0] - 3) / 200;
      deviation += fit.at(0).deviation / 200;
    }
    EXPECT_GE(misses, 1) << shared;
    EXPECT_LE(misses, 22) << shared;
    EXPECT_LT(std::abs(bias), 4 * deviation / std::sqrt(200.0)) << shared;
  }
}

TEST(GroupedFit, FamiliesAreWeightedByTheirResiduals) {
  RandomStream random(4, 1);
  std::vector<Equation> equations;
  for (int k = 0; k < 400; ++k) {
    Equation equation;
    equation.x = Eigen::VectorXd::Ones(1);
    equation.family = k % 2;
    equation.y = 7 + (equation.family == 0 ? 0.01 : 1.0) * random.normal();
    equation.group = k / 20;
    equations.push_back(equation);
  }
  const GroupedFit fit = fit_grouped(equations);
  EXPECT_NEAR(fit.scale[1] / fit.scale[0], 100, 25);  // 200 residuals each: 7 % as deviation
  // As sure as the better family alone, 0.01/sqrt(200); equal weights: 50 times that.
  EXPECT_LT(fit.at(0).deviation, 2 * 0.01 / std::sqrt(200.0));
}

TEST(GroupedFit, AValueThatHangsOnOneGroupHasFewDegreesOfFreedom) {
  RandomStream random(5, 1);
  std::vector<Equation> equations = make_equations(0.1, 0, random);
  for (Equation& equation : equations) {
    Eigen::Vector3d x(equation.x[0], equation.x[1], 0);
    if (equation.group == 5) x[2] = random.uniform();
    equation.x = x;
  }
  const GroupedFit fit = fit_grouped(equations);
  EXPECT_LT(fit.degrees[2], 4);
  EXPECT_GT(fit.degrees[0], 5);
}

TEST(GroupedFit, RefusesTooFewGroupsOrEquations) {
  std::vector<Equation> equations(2);
  for (Equation& equation : equations) equation.x = Eigen::Vector2d(1, 2);
  EXPECT_THROW(fit_grouped(equations), Error);
  equations.resize(9, equations.front());
  EXPECT_THROW(fit_grouped(equations), Error);
}

}  // namespace
}  // namespace gyrator
