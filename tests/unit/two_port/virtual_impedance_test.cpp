#include "gyrator/two_port/virtual_impedance.hpp"

#include <array>
#include <cmath>

#include <gtest/gtest.h>

#include "support/passivity_closed_forms.hpp"

namespace gyrator {
namespace {

using namespace passivity_tests;

constexpr double T = 0.03;
constexpr std::array schemes{Integration::explicit_euler, Integration::semi_implicit,
                             Integration::implicit};

TEST(VirtualElements, are_the_z_transforms_of_their_scheme) {
  for (const double omega : {0.5, 20.0, pi / T}) {
    const Complex z = std::polar(1.0, omega * T);
    const VirtualElements forward(omega, T, Integration::explicit_euler);
    EXPECT_NEAR(std::abs(forward.mass(2) - 2.0 * (z - 1.0) / T), 0, 1e-12);
    EXPECT_NEAR(std::abs(forward.spring(300) * (z - 1.0) / (300.0 * T) - 1.0), 0, 1e-12);
    for (const auto scheme : {Integration::semi_implicit, Integration::implicit}) {
      const VirtualElements backward(omega, T, scheme);
      EXPECT_NEAR(std::abs(backward.mass(2) - 2.0 * (z - 1.0) / (T * z)), 0, 1e-12);
      EXPECT_NEAR(std::abs(backward.spring(300) * (z - 1.0) / (300.0 * T * z) - 1.0), 0, 1e-12);
      EXPECT_NEAR(
          std::abs(backward.body(2, {300, 0.5}) - (backward.mass(2) + 0.5 + backward.spring(300))),
          0, 1e-12);
    }
  }
}

TEST(VirtualElements, have_negative_real_parts_in_explicit_steps_and_positive_ones_otherwise) {
  for (const double omega : {0.5, 20.0, 90.0}) {
    const VirtualElements forward(omega, T, Integration::explicit_euler);
    EXPECT_NEAR(forward.mass(2).real(), -2 * (1 - std::cos(omega * T)) / T, 1e-12);
    EXPECT_NEAR(forward.spring(300).real(), -300 * T / 2, 1e-12);
    const VirtualElements backward(omega, T, Integration::implicit);
    EXPECT_NEAR(backward.mass(2).real(), 2 * (1 - std::cos(omega * T)) / T, 1e-12);
    EXPECT_NEAR(backward.spring(300).real(), 300 * T / 2, 1e-12);
  }
}

TEST(VirtualElements, tend_to_the_continuous_ones_with_the_step) {
  const VirtualElements continuous(20, 0, Integration::semi_implicit);
  EXPECT_EQ(continuous.mass(2), Complex(0, 40));
  EXPECT_NEAR(std::abs(continuous.spring(300) - Complex(0, -15)), 0, 1e-12);
  for (const auto scheme : schemes) {
    const VirtualElements fine(20, 1e-8, scheme);  // off by w h/2 = 1e-7
    EXPECT_NEAR(std::abs(fine.body(2, {300, 1}) / continuous.body(2, {300, 1}) - 1.0), 0, 1e-6);
  }
}

TEST(VirtualRadius, is_that_of_the_steps_which_move_the_body) {
  for (const auto scheme : schemes) {
    for (const double inertia : {1e-4, 0.05, 2.0}) {
      ChainModel chain;
      chain.inertia[0] = inertia;
      chain.links[0].law = {300, 0.06};
      chain.integration = scheme;
      const Eigen::MatrixXd A = make_chain_law(chain, T).A.topLeftCorner(2, 2);
      const double expected = A.eigenvalues().cwiseAbs().maxCoeff();
      EXPECT_NEAR(compute_virtual_radius(inertia, {300, 0.06}, T, scheme) / expected, 1, 1e-9);
    }
  }
}

TEST(VirtualRadius, of_a_semi_implicit_body_passes_one_at_the_known_step) {
  // k h^2 = 4 m - 2 c h
  const double m = 1e-4, c = 0.06, k = 300;
  const double h = (-c + std::sqrt(c * c + 4 * k * m)) / k;
  const auto radius = [&](double step) {
    return compute_virtual_radius(m, {k, c}, step, Integration::semi_implicit);
  };
  EXPECT_LT(radius(0.99 * h), 1);
  EXPECT_GT(radius(1.01 * h), 1);
}

TEST(VirtualRadius, of_spring_and_damper_alone) {
  EXPECT_DOUBLE_EQ(compute_virtual_radius(0, {300, 3}, 1e-3, Integration::implicit), 3 / 3.3);
  EXPECT_DOUBLE_EQ(compute_virtual_radius(0, {300, 0.1}, 1e-3, Integration::explicit_euler), 2);
}

}  // namespace
}  // namespace gyrator
