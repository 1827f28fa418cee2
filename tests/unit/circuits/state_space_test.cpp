#include "gyrator/circuits/state_space.hpp"

#include <algorithm>
#include <cmath>
#include <complex>
#include <random>
#include <vector>

#include <gtest/gtest.h>

namespace gyrator {
namespace {

using Eigen::MatrixXd;

// A matrix exponential by scaling and squaring loses a few roundings for each squaring.
constexpr double rounding = 2e-14;

MatrixXd scalar(double value) {
  return MatrixXd::Constant(1, 1, value);
}

MatrixXd draw(std::mt19937& generator, Eigen::Index rows, Eigen::Index columns) {
  std::uniform_real_distribution<double> uniform(-1, 1);
  return MatrixXd::NullaryExpr(rows, columns, [&] { return uniform(generator); });
}

// e^([A B; 0 0] h), through the function under test
MatrixXd propagate(const MatrixXd& A, const MatrixXd& B, double interval) {
  const HeldStep step = discretize_held(A, B, interval);
  MatrixXd whole = MatrixXd::Identity(A.rows() + B.cols(), A.rows() + B.cols());
  whole.topRows(A.rows()) << step.phi, step.gamma;
  return whole;
}

TEST(Balance, is_an_exact_similarity_by_powers_of_two) {
  std::mt19937 generator(1);
  const MatrixXd natural = draw(generator, 5, 5);
  Eigen::VectorXd units(5);
  units << 1, 1e6, 3e-5, 1e-9, 40;
  const MatrixXd A = units.asDiagonal() * natural * units.cwiseInverse().asDiagonal();
  MatrixXd balanced = A;
  const Eigen::VectorXd scale = balance(balanced);
  for (const double s : scale) {
    int exponent = 0;
    EXPECT_EQ(std::frexp(s, &exponent), 0.5) << s << " is no power of two";
  }
  EXPECT_EQ(scale.asDiagonal() * balanced * scale.cwiseInverse().asDiagonal(), A);
  EXPECT_LT(balanced.norm(), 2 * natural.norm()) << "A has " << A.norm();
}

TEST(Balance, gives_the_small_poles_of_a_badly_scaled_matrix) {
  // Poles of [a k; 1/k·c b] do not depend on k: (a + b)/2 ± sqrt((a - b)^2/4 + c).
  for (const double k : {1.0, 1e6, 1e12}) {
    MatrixXd A(2, 2);
    A << -1, k, 3 / k, -2;
    const Eigen::VectorXcd poles = compute_poles(A);
    const double split = std::sqrt(0.25 + 3);
    EXPECT_NEAR(poles.real().minCoeff(), -1.5 - split, rounding) << k;
    EXPECT_NEAR(poles.real().maxCoeff(), -1.5 + split, rounding) << k;
  }
  EXPECT_EQ(compute_poles(MatrixXd(0, 0)).size(), 0);
}

TEST(HeldStep, of_rc_and_rl_is_the_exponential) {
  constexpr double R = 4.7, C = 1e-4, L = 2e-3;
  for (const double h : {1e-6, 1e-4, 1e-3, 0.02}) {
    // dv/dt = (u - v)/(R C), di/dt = (u - R i)/L
    const HeldStep rc = discretize_held(scalar(-1 / (R * C)), scalar(1 / (R * C)), h);
    EXPECT_NEAR(rc.phi(0, 0), std::exp(-h / (R * C)), rounding);
    EXPECT_NEAR(rc.gamma(0, 0) / -std::expm1(-h / (R * C)), 1, rounding);
    const HeldStep rl = discretize_held(scalar(-R / L), scalar(1 / L), h);
    EXPECT_NEAR(rl.phi(0, 0), std::exp(-h * R / L), rounding);
    EXPECT_NEAR(rl.gamma(0, 0) * R / -std::expm1(-h * R / L), 1, rounding);
  }
}

TEST(HeldStep, of_mass_and_damper_carries_the_position_through_a_singular_matrix) {
  // x' = v, m v' = u - b v:  v = v0 e + u (1 - e)/b,  x = x0 + v0 tau (1 - e) + u (h - tau (1 -
  // e))/b with tau = m/b, e = exp(-h/tau); P3 of the reference cases.
  constexpr double m = 0.04, b = 0.8, tau = m / b;
  MatrixXd A(2, 2), B(2, 1);
  A << 0, 1, 0, -b / m;
  B << 0, 1 / m;
  for (const double h : {1e-3, 5e-3, 0.05, 1.0}) {
    const double lost = -std::expm1(-h / tau);
    const HeldStep step = discretize_held(A, B, h);
    EXPECT_NEAR(step.phi(0, 0), 1, rounding);
    EXPECT_NEAR(step.phi(1, 0), 0, rounding);
    EXPECT_NEAR(step.phi(1, 1), 1 - lost, rounding);
    EXPECT_NEAR(step.phi(0, 1) / (tau * lost), 1, rounding);
    EXPECT_NEAR(step.gamma(1, 0) * b / lost, 1, rounding);
    // h - tau(1 - e) cancels to (h/tau) h/2: the closed form itself knows it to eps tau/h.
    EXPECT_NEAR(step.gamma(0, 0) * b / (h - tau * lost), 1, rounding * (1 + tau / h)) << h;
  }
}

TEST(HeldStep, of_an_undriven_double_integrator_is_a_polynomial) {
  MatrixXd A(2, 2), B(2, 1);
  A << 0, 1, 0, 0;
  B << 0, 1 / 0.04;
  const HeldStep step = discretize_held(A, B, 0.3);
  EXPECT_NEAR(step.phi(0, 1), 0.3, rounding);
  EXPECT_NEAR(step.gamma(0, 0), 0.3 * 0.3 / 2 / 0.04, rounding * 2);
  EXPECT_NEAR(step.gamma(1, 0), 0.3 / 0.04, rounding * 10);
}

TEST(HeldStep, stays_accurate_over_an_interval_of_a_million_time_constants) {
  // Fast -a driven by slow -1:  x1 = u-response through a/(a - 1) (e^{-h} - e^{-ah}).
  constexpr double a = 1e7, h = 0.1;
  MatrixXd A(2, 2), B(2, 1);
  A << -a, a, 0, -1;
  B << 0, 1;
  const HeldStep step = discretize_held(A, B, h);
  // A norm of 1e6 takes about 20 squarings, each doubling the relative error.
  constexpr double squared = 1e-9;
  EXPECT_NEAR(step.phi(0, 1) / (a / (a - 1) * std::exp(-h)), 1, squared);
  EXPECT_NEAR(step.phi(1, 1) / std::exp(-h), 1, squared);
  EXPECT_NEAR(step.phi(0, 0), 0, squared);
  EXPECT_NEAR(step.gamma(1, 0) / -std::expm1(-h), 1, squared);
}

TEST(HeldStep, of_no_time_changes_nothing_and_two_halves_make_a_whole) {
  std::mt19937 generator(2);
  for (int trial = 0; trial < 10; ++trial) {
    const MatrixXd A = 3 * draw(generator, 4, 4), B = draw(generator, 4, 2);
    EXPECT_EQ(propagate(A, B, 0), MatrixXd::Identity(6, 6));
    const MatrixXd whole = propagate(A, B, 0.8);
    const MatrixXd parts = propagate(A, B, 0.5) * propagate(A, B, 0.3);
    EXPECT_LE((whole - parts).norm(), rounding * whole.norm());
  }
}

TEST(QuadraticForm, of_a_discharging_capacitor_is_the_energy_it_lost) {
  // Heat in R while C discharges: int v^2/R = C (v0^2 - v^2)/2.
  constexpr double R = 4.7, C = 1e-4;
  for (const double h : {1e-6, 1e-4, 1e-3, 0.1}) {
    MatrixXd form = MatrixXd::Zero(2, 2);
    form(0, 0) = 1 / R;
    const MatrixXd W =
        integrate_quadratic_forms(scalar(-1 / (R * C)), scalar(0), {form}, h).front();
    EXPECT_NEAR(W(0, 0) / (C / 2 * -std::expm1(-2 * h / (R * C))), 1, rounding) << h;
    EXPECT_NEAR(W(1, 1), 0, rounding);
  }
}

TEST(QuadraticForm, of_a_charged_capacitor_counts_the_held_source) {
  // From rest, v = u (1 - e): the source delivers int u (u - v)/R = C u^2 (1 - e).
  constexpr double R = 4.7, C = 1e-4, h = 3e-4;
  MatrixXd form(2, 2);
  form << 0, -0.5 / R, -0.5 / R, 1 / R;
  const MatrixXd W =
      integrate_quadratic_forms(scalar(-1 / (R * C)), scalar(1 / (R * C)), {form}, h).front();
  EXPECT_NEAR(W(1, 1) / (C * -std::expm1(-h / (R * C))), 1, rounding);
}

TEST(QuadraticForm, of_an_oscillator_over_many_turns) {
  // x'' = -w^2 x from x = 1: int x^2 = h/2 + sin(2 w h)/(4 w).
  constexpr double w = 2000, h = 0.05;
  MatrixXd A(2, 2);
  A << 0, 1, -w * w, 0;
  MatrixXd form = MatrixXd::Zero(3, 3);
  form(0, 0) = 1;
  const MatrixXd W = integrate_quadratic_forms(A, MatrixXd::Zero(2, 1), {form}, h).front();
  // The phase w h = 100 is doubled up from a short step: its error is eps times that, many times.
  EXPECT_NEAR(W(0, 0) / (h / 2 + std::sin(2 * w * h) / (4 * w)), 1, 1e-10);
}

TEST(QuadraticForm, of_a_stiff_system_is_its_integral_to_infinity) {
  // int e^{-2 a s} = 1/(2 a) long after the mode has died; and beside a slow one nothing is lost.
  constexpr double a = 1e7, slow = 2, h = 1e-2;
  MatrixXd A(2, 2);
  A << -a, 0, 0, -slow;
  MatrixXd form = MatrixXd::Zero(3, 3);
  form(0, 0) = 1;
  form(1, 1) = 1;
  form(2, 2) = 5;
  const MatrixXd W = integrate_quadratic_forms(A, MatrixXd::Zero(2, 1), {form}, h).front();
  EXPECT_NEAR(W(0, 0) * 2 * a, 1, rounding);
  // 18 doublings of the slow mode's step.
  EXPECT_NEAR(W(1, 1) / (-std::expm1(-2 * slow * h) / (2 * slow)), 1, 1e-10);
  EXPECT_NEAR(W(2, 2) / (5 * h), 1, 1e-10);
}

TEST(QuadraticForm, inverts_differentiation) {
  // d/dt z'Sz = z'(M'S + S M)z with M = [A B; 0 0]; so its integral is Z'SZ - S, for any A, B, S.
  std::mt19937 generator(3);
  for (int trial = 0; trial < 20; ++trial) {
    const Eigen::Index n = 1 + trial % 5;
    const double speed = std::pow(10.0, trial % 4);  // |A| h from below one to hundreds
    MatrixXd A = speed * draw(generator, n, n);
    A -= speed * 2.0 * static_cast<double>(n) * MatrixXd::Identity(n, n);  // stable
    const MatrixXd B = speed * draw(generator, n, 2);
    MatrixXd S = draw(generator, n + 2, n + 2);
    S = (S + S.transpose()).eval();
    MatrixXd M = MatrixXd::Zero(n + 2, n + 2);
    M.topRows(n) << A, B;
    const double h = 0.05;
    const MatrixXd Z = propagate(A, B, h);
    const MatrixXd expected = Z.transpose() * S * Z - S;
    const MatrixXd W = integrate_quadratic_forms(A, B, {M.transpose() * S + S * M}, h).front();
    // Twelve doublings at the fastest.
    EXPECT_LE((W - expected).norm(), 1e-11 * std::max(1.0, expected.norm())) << trial;
    EXPECT_LE((W - W.transpose()).norm(), rounding * W.norm()) << trial;
  }
}

TEST(QuadraticForm, several_at_once_are_each_by_itself) {
  std::mt19937 generator(9);
  const MatrixXd A = 40 * draw(generator, 3, 3), B = draw(generator, 3, 2);
  std::vector<MatrixXd> forms;
  for (int i = 0; i < 3; ++i) forms.push_back(draw(generator, 5, 5));
  const auto together = integrate_quadratic_forms(A, B, forms, 0.05);
  ASSERT_EQ(together.size(), forms.size());
  for (std::size_t i = 0; i < forms.size(); ++i) {
    EXPECT_EQ(together[i], integrate_quadratic_forms(A, B, {forms[i]}, 0.05).front()) << i;
  }
}

TEST(QuadraticForm, over_no_time_is_zero) {
  const auto W = integrate_quadratic_forms(scalar(-1), scalar(1), {MatrixXd::Ones(2, 2)}, 0);
  EXPECT_EQ(W, std::vector<MatrixXd>{MatrixXd::Zero(2, 2)});
}

}  // namespace
}  // namespace gyrator
