#include "gyrator/controllers/discrete_state_space.hpp"

#include <cmath>
#include <complex>
#include <random>
#include <vector>

#include <gtest/gtest.h>

namespace gyrator {
namespace {

using Complex = std::complex<double>;

constexpr double rounding = 1e-13;  // some tens of operations on numbers of about one

// A stable law of n states with poles inside 0.9.
DiscreteStateSpace draw_law(std::mt19937& generator, Eigen::Index n) {
  std::uniform_real_distribution<double> uniform(-1, 1);
  const auto draw = [&](Eigen::Index rows, Eigen::Index columns) {
    return Eigen::MatrixXd(
        Eigen::MatrixXd::NullaryExpr(rows, columns, [&] { return uniform(generator); }));
  };
  DiscreteStateSpace law;
  law.A = draw(n, n);
  if (n > 0) law.A *= 0.9 / law.A.norm();
  law.B = draw(n, 1);
  law.C = draw(1, n);
  law.D = uniform(generator);
  return law;
}

std::vector<double> run(const DiscreteStateSpace& law, const std::vector<double>& input) {
  DiscreteLawState state(law);
  std::vector<double> output;
  for (const double y : input) output.push_back(state.step(law, y));
  return output;
}

TEST(DiscreteStateSpace, response_is_the_transform_of_the_impulse_response) {
  // H(z) = sum h_k z^-k; after 400 samples a pole of 0.9 has left e^-42.
  std::mt19937 generator(6);
  for (Eigen::Index n = 0; n < 5; ++n) {
    const DiscreteStateSpace law = draw_law(generator, n);
    std::vector<double> impulse(400, 0.0);
    impulse[0] = 1;
    const std::vector<double> h = run(law, impulse);
    for (const double angle : {0.0, 0.3, 1.7, 3.14159}) {
      const Complex z = std::polar(1.0, angle);
      Complex sum = 0;
      for (std::size_t k = h.size(); k-- > 0;) sum = sum / z + h[k];
      EXPECT_LE(std::abs(law.response(z) - sum), rounding) << n << " states at " << angle;
    }
  }
}

TEST(DiscreteStateSpace, sum_and_multiple_of_laws_respond_as_such) {
  std::mt19937 generator(7);
  const DiscreteStateSpace a = draw_law(generator, 2), b = draw_law(generator, 3);
  const DiscreteStateSpace sum = in_parallel(scaled(a, -2.5), in_parallel(b, make_gain(4)));
  EXPECT_EQ(sum.states(), 5);
  for (const double angle : {0.0, 0.4, 2.0}) {
    const Complex z = std::polar(1.0, angle);
    const Complex expected = -2.5 * a.response(z) + b.response(z) + 4.0;
    EXPECT_LE(std::abs(sum.response(z) - expected), rounding) << angle;
  }
  std::vector<double> input;
  for (int k = 0; k < 50; ++k) input.push_back(std::sin(0.7 * k * k));
  const auto out = run(sum, input), out_a = run(a, input), out_b = run(b, input);
  for (std::size_t k = 0; k < input.size(); ++k) {
    ASSERT_NEAR(out[k], -2.5 * out_a[k] + out_b[k] + 4 * input[k], rounding) << k;
  }
}

TEST(DiscreteStateSpace, settled_state_stays_where_it_is) {
  std::mt19937 generator(8);
  for (Eigen::Index n = 0; n < 4; ++n) {
    const DiscreteStateSpace law = draw_law(generator, n);
    DiscreteLawState state(law);
    state.settle(law, -3);
    const double expected = -3 * law.response(1).real();
    for (int k = 0; k < 5; ++k) EXPECT_NEAR(state.step(law, -3), expected, rounding) << n;
  }
}

TEST(DiscreteStateSpace, a_gain_has_no_state) {
  EXPECT_EQ(make_gain(7).states(), 0);
  EXPECT_EQ(make_gain(7).response({0.2, 0.9}), 7.0);
  EXPECT_EQ(run(make_gain(7), {1, -2}), (std::vector<double>{7, -14}));
}

}  // namespace
}  // namespace gyrator
