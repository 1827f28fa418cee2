#include "gyrator/two_port/two_port.hpp"

#include <cmath>
#include <limits>
#include <random>

#include <gtest/gtest.h>

#include "support/passivity_closed_forms.hpp"

namespace gyrator {
namespace {

using namespace passivity_tests;

// The least damping that an operator can feel behind h over all lossless environments, which are
// the extreme ones: Z_te of a passive environment lies in the disk that they span.
double find_least_felt(const HybridMatrix& h) {
  double least = std::numeric_limits<double>::infinity();
  constexpr int points = 20000;
  for (int i = 0; i < points; ++i) {
    const double angle = pi * (i + 0.5) / points - pi / 2;
    least = std::min(least, h.transmitted({0, std::tan(angle)}).real());
  }
  return least;
}

TEST(HybridMatrix, transmits_by_the_papers_formula_and_tends_to_the_clamped_one) {
  const HybridMatrix h{{0.3, 2}, {0.9, -0.2}, {-1.1, 0.1}, {0.4, 0.7}};
  const Complex z(0.5, -3);
  const Complex determinant = h.h11 * h.h22 - h.h12 * h.h21;
  EXPECT_NEAR(std::abs(h.transmitted(z) - (h.h11 + determinant * z) / (1.0 + h.h22 * z)), 0, 1e-14);
  EXPECT_NEAR(std::abs(h.transmitted(1e12) - h.transmitted_when_clamped()), 0, 1e-11);
  EXPECT_EQ(h.transmitted(0), h.h11);
}

TEST(ImpedanceMatrix, and_its_hybrid_form_hold_the_same_equations) {
  const ImpedanceMatrix z{{0.3, 2}, {0.9, -0.2}, {-1.1, 0.1}, {0.4, 0.7}};
  const HybridMatrix h = z.to_hybrid();
  const Complex v_1(0.3, 1), v_2(-0.7, 0.2);
  const Complex f_1 = z.z11 * v_1 + z.z12 * v_2;
  const Complex f_e = -(z.z21 * v_1 + z.z22 * v_2);
  EXPECT_NEAR(std::abs(h.h11 * v_1 + h.h12 * f_e - f_1), 0, 1e-14);
  EXPECT_NEAR(std::abs(h.h21 * v_1 + h.h22 * f_e + v_2), 0, 1e-14);
  // The third condition differs by a positive factor alone.
  const LlewellynMargins hybrid = compute_llewellyn_margins(h);
  const Complex p = z.z12 * z.z21;
  const double impedance = 2 * z.z11.real() * z.z22.real() - std::abs(p) - p.real();
  EXPECT_NEAR(hybrid.third * std::norm(z.z22), impedance, 1e-14);
}

TEST(Llewellyn, holds_exactly_where_no_passive_environment_makes_the_felt_damping_negative) {
  std::mt19937 random(7);
  std::normal_distribution<double> normal;
  const auto number = [&] { return Complex(normal(random), normal(random)); };
  int stable = 0, unstable = 0;
  for (int i = 0; i < 400; ++i) {
    HybridMatrix h{number(), number(), number(), number()};
    h.h11 += 1.0;  // about half of them stable
    h.h22 = {std::abs(h.h22.real()), h.h22.imag()};
    const LlewellynMargins m = compute_llewellyn_margins(h);
    if (std::abs(m.third) < 1e-3 || std::abs(m.first) < 1e-3) continue;  // too near to tell
    const bool holds = m.first >= 0 && m.third >= 0;
    const double least = find_least_felt(h);
    EXPECT_EQ(holds, least >= 0) << i << " " << m.third;
    // The environments step round the circle of Z_te by at most `turn`, half of it to its extreme:
    // with Y_e = jB, |d arg|/d angle = 2 g (1 + B^2)/|h22 + jB|^2 <= 2 g + 2 (1 + (Im h22)^2)/g.
    const double g = h.h22.real();
    const double turn = pi / 20000 * (2 * g + 2 * (1 + h.h22.imag() * h.h22.imag()) / g);
    if (turn > 0.1) continue;
    const double radius = std::abs(h.h12 * h.h21) / (2 * g);
    EXPECT_LE(m.felt, least + 1e-9 * radius) << i;
    EXPECT_NEAR(m.felt, least, radius * turn * turn / 8 + 1e-9 * (radius + 1)) << i;
    (holds ? stable : unstable)++;
  }
  EXPECT_GT(stable, 50);
  EXPECT_GT(unstable, 50);
}

TEST(Llewellyn, ratio_is_one_where_the_third_margin_is_zero_and_infinite_for_a_one_way_port) {
  // h12 = 1, h21 = -e^(-jx): |p| + Re p = 1 - cos x, also where that is far below rounding of 1.
  for (const double x : {1e-6, 0.1, 2.0}) {
    const double asked = 2 * std::pow(std::sin(x / 2), 2);
    const HybridMatrix h{asked, 1, -std::polar(1.0, -x), 0.5};
    EXPECT_NEAR(compute_llewellyn_margins(h).ratio, 1, 1e-9) << x;
    EXPECT_NEAR(compute_llewellyn_margins(h).third / asked, 0, 1e-9) << x;
  }
  EXPECT_EQ(compute_llewellyn_margins({1, 0, -1, 1}).ratio,
            std::numeric_limits<double>::infinity());
}

TEST(TwoPortVerdict, names_the_band_in_which_a_condition_is_violated) {
  // Re h22 = 2 + cos w - 1.5, below zero for w from 2 pi/3 to 4 pi/3.
  const auto port = [](double omega) { return HybridMatrix{1, 0, 0, 0.5 + std::cos(omega)}; };
  std::vector<double> grid;
  for (double omega = 0.01; omega < 6; omega += 0.05) grid.push_back(omega);
  const TwoPortVerdict verdict = judge_two_port(port, grid);
  EXPECT_FALSE(verdict.absolutely_stable);
  EXPECT_TRUE(verdict.conditions[0].holds);
  const ConditionResult& second = verdict.conditions[1];
  ASSERT_EQ(second.violated.size(), 1);
  EXPECT_NEAR(second.violated[0].from_hz, 1.0 / 3, 2e-6);
  EXPECT_NEAR(second.violated[0].to_hz, 2.0 / 3, 2e-6);
  EXPECT_NEAR(second.margin, -0.5, 1e-12);
  EXPECT_NEAR(second.worst_frequency_hz, 0.5, 1e-6);
}

TEST(TwoPortVerdict, finds_a_violation_that_lies_between_the_points_of_the_grid) {
  const auto port = [](double omega) {
    return HybridMatrix{std::pow(omega - 1.04, 2) - 1e-6, 0, 0, 1};
  };
  const TwoPortVerdict verdict = judge_two_port(port, {0.5, 0.9, 1, 1.1, 1.3, 2});
  EXPECT_FALSE(verdict.conditions[0].holds);
  EXPECT_NEAR(verdict.conditions[0].margin, -1e-6, 1e-12);
}

TEST(TwoPortVerdict, is_no_when_what_is_computed_is_unstable_by_itself) {
  const auto port = [](double) { return HybridMatrix{1, 0, 0, 1}; };
  EXPECT_TRUE(judge_two_port(port, {1, 2}, 1).absolutely_stable);
  EXPECT_FALSE(judge_two_port(port, {1, 2}, 1.001).absolutely_stable);
}

}  // namespace
}  // namespace gyrator
