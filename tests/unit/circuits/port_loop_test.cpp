#include "gyrator/circuits/port_loop.hpp"

#include <cmath>
#include <random>
#include <string>
#include <vector>

#include <gtest/gtest.h>

namespace gyrator {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

NonlinearPort port_of(const ElementLaw& law) {
  return make_port({"part", Role::device, {1}, ground, law});
}

// A source behind a conductance g feeds the law: g (e - v) = law(v), as the loop y = q + F w(y)
// with the companion c inside, v = (g e - w)/(g + c).
PortLoop make_loop(const ElementLaw& law, double g) {
  const NonlinearPort port = port_of(law);
  return {{port}, MatrixXd::Constant(1, 1, -1 / (g + port.companion))};
}
double q_of(const ElementLaw& law, double g, double e) {
  return g * e / (g + port_of(law).companion);
}

// The same by bisection: g (e - v) - law(v) - leak v falls with v.
double find_by_bisection(const ElementLaw& law, double g, double e) {
  const NonlinearPort port = port_of(law);
  double low = -std::abs(e);
  double high = std::abs(e);
  for (int i = 0; i < 200; ++i) {
    const double v = (low + high) / 2;
    const double left_over = g * (e - v) - evaluate_law(law, v).value - port.leak * v;
    (left_over > 0 ? low : high) = v;
  }
  return (low + high) / 2;
}

TEST(PortLoop, finds_the_only_solution_of_every_passive_law_behind_any_resistance) {
  const std::vector<ElementLaw> laws{Diode{}, Diode{2e-9, 0.045}, VoltageClamp{24, 0.1},
                                     SaturatingConductance{3, 0.2}};
  for (const ElementLaw& law : laws) {
    for (const double g : {1e-6, 1e-3, 1.0, 1e3}) {
      PortLoop loop = make_loop(law, g);
      // Warm from wherever the last one ended, over all sizes and signs.
      for (const double e : {0.0, 0.3, 1e3, -1e3, 5.0, -0.01, 24.1, -30.0, 0.7}) {
        ASSERT_EQ(loop.solve(VectorXd::Constant(1, q_of(law, g, e))), -1)
            << law.index() << ", " << g << " S, " << e << " V";
        const double expected = find_by_bisection(law, g, e);
        // The companion's part in the sum cancels: rounding grows by companion / (g + slope).
        const double growth = port_of(law).companion / g + 1;
        EXPECT_NEAR(loop.arguments()(0), expected,
                    1e-14 * growth * std::abs(e) + 1e-12 * std::abs(expected) + 1e-15)
            << law.index() << ", " << g << " S, " << e << " V";
      }
    }
  }
}

TEST(PortLoop, solves_many_coupled_ports) {
  // A resistive ladder with a law at each node: F is minus the inverse of its conductances.
  std::mt19937 generator(7);
  std::uniform_real_distribution<double> drawn(-1, 1);
  const std::vector<ElementLaw> laws{Diode{}, VoltageClamp{0.5, 1e-3},
                                     SaturatingConductance{0.5, 0.01}, Diode{1e-9, 0.05}};
  const auto n = static_cast<Eigen::Index>(laws.size());
  std::vector<NonlinearPort> ports;
  MatrixXd Y = MatrixXd::Zero(n, n);
  for (Eigen::Index k = 0; k < n; ++k) {
    ports.push_back(port_of(laws[static_cast<std::size_t>(k)]));
    Y(k, k) += 1e-3;
    if (k + 1 < n) {
      Y(k, k) += 0.1;
      Y(k + 1, k + 1) += 0.1;
      Y(k, k + 1) -= 0.1;
      Y(k + 1, k) -= 0.1;
    }
  }
  MatrixXd with_companions = Y;
  for (Eigen::Index k = 0; k < n; ++k)
    with_companions(k, k) += ports[static_cast<std::size_t>(k)].companion;
  const MatrixXd Z = with_companions.inverse();
  PortLoop loop(ports, -Z);
  for (int run = 0; run < 200; ++run) {
    VectorXd current(n);
    for (Eigen::Index k = 0; k < n; ++k)
      current(k) = std::pow(10, 3 * drawn(generator)) * drawn(generator);
    ASSERT_EQ(loop.solve(Z * current), -1);
    // Kirchhoff at every node.
    VectorXd left_over = current - Y * loop.arguments();
    for (Eigen::Index k = 0; k < n; ++k) {
      const NonlinearPort& port = ports[static_cast<std::size_t>(k)];
      const double y = loop.arguments()(k);
      left_over(k) -= evaluate_law(port.law, y).value + port.leak * y;
    }
    // Companions of up to 32 S cancel against 0.1 S.
    EXPECT_LE(left_over.norm(), 1e-11 * current.norm()) << run;
  }
}

TEST(PortLoop, names_the_port_where_there_is_no_solution) {
  // i = 1 A into a brake that holds 0.2 A at most and nothing else: only its leak would take the
  // rest.
  const NonlinearPort port = port_of(SaturatingConductance{3, 0.2});
  NonlinearPort tight = port;
  tight.leak = 0;
  PortLoop loop({tight}, MatrixXd::Constant(1, 1, -1 / tight.companion));
  EXPECT_EQ(loop.solve(VectorXd::Constant(1, 1 / tight.companion)), 0);
}

}  // namespace
}  // namespace gyrator
