// The RC-damped rotary display of the equations sheet, section 5: where the textbook is unsafe.

#include "gyrator/cosim/simulation.hpp"
#include "gyrator/mechanics/actuation_roots.hpp"
#include "gyrator/passivity/verdict.hpp"

#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>
#include <string>

#include <gtest/gtest.h>

#include "../support/mentions.hpp"

namespace gyrator {
namespace {

using std::numbers::pi;
using Complex = std::complex<double>;
using passivity_tests::mentions;

constexpr double J = 2e-5;      // kg.m^2
constexpr double b = 1e-4;      // N.m.s/rad
constexpr double K_t = 0.05;    // N.m/A
constexpr double R_m = 1.5;     // ohm
constexpr double L_m = 0.5e-3;  // H
constexpr double R_1 = 5;       // ohm
constexpr double C = 2200e-6;   // F
constexpr double T = 1e-3;      // s
constexpr double B = 1.5e-4;    // N.m.s/rad

Device make_display(const Amplifier& amplifier = CurrentAmplifier{}) {
  Device device;
  device.drive.motor = Motor{K_t, R_m, L_m};
  device.drive.amplifier = amplifier;
  device.drive.damping = {RcDamping{R_1, C}};
  device.mechanics.inertia = J;
  device.mechanics.damping = b;
  return device;
}

StiffnessLimit find_limit(const Device& device, Criterion criterion) {
  return StiffnessLimits(device, {}, DifferenceEstimator{}, FreeOperator{}).find(criterion, B);
}

Verdict judge(const Device& device, double stiffness) {
  return judge_passivity({device, VirtualWall{stiffness, B}, {}, 0});
}

const CriterionResult& find_criterion(const Verdict& verdict, const std::string& name) {
  return *std::find_if(verdict.criteria.begin(), verdict.criteria.end(),
                       [&](const CriterionResult& c) { return c.name == name; });
}

TEST(RcExample, textbook_allows_half_a_newton_meter_per_radian) {
  // (b + B) 2/T, at zero frequency where the capacitor blocks.
  const StiffnessLimit limit = find_limit(make_display(), Criterion::frequency_dependent);
  EXPECT_NEAR(limit.stiffness, 0.500, 1e-6);
  EXPECT_LT(limit.worst_frequency_hz, 0.01);
}

TEST(RcExample, exact_disk_allows_an_eighth_of_that) {
  const StiffnessLimit limit = find_limit(make_display(), Criterion::exact_disk);
  EXPECT_NEAR(limit.stiffness, 0.0658, 0.005 * 0.0658);
  EXPECT_LT(limit.worst_frequency_hz, 0.01);
}

TEST(RcExample, exact_disk_with_an_ideal_drive_is_bound_by_the_aliases_at_nyquist) {
  const StiffnessLimit limit = find_limit(make_display(IdealDrive{}), Criterion::exact_disk);
  EXPECT_NEAR(limit.stiffness, 0.468, 0.005 * 0.468);
  EXPECT_NEAR(limit.worst_frequency_hz, 500, 1e-6);
}

TEST(RcExample, limit_at_zero_frequency_is_the_damping_over_half_a_period_and_the_lag) {
  // For w -> 0 the command lags by T/2 + R_m C, A = 1 - s R_m C, and (disk-3) becomes
  //   D = b + B - K (T/2 + R_m C) - K^2 sum_{n>0} (|A_n| - Re A_n)/(Re Z_n (n w_s)^2),
  // the last from the base term's product with each pair of aliases, which alone does not vanish.
  const double lag = T / 2 + R_m * C;
  const double w_s = 2 * pi / T;
  double aliases = 0;
  for (int n = 1000; n >= 1; --n) {
    const Complex s(0, n * w_s);
    const Complex branch = R_1 + 1.0 / (C * s);
    const Complex winding = R_m + L_m * s + branch;
    const double damping = b + std::real(K_t * K_t / winding);
    const Complex A = branch / winding;
    aliases += (std::abs(A) - A.real()) / (damping * std::norm(s));
  }
  const double plain = (b + B) / lag;
  const double root = 2 * (b + B) / (lag + std::sqrt(lag * lag + 4 * aliases * (b + B)));
  const double limit = find_limit(make_display(), Criterion::exact_disk).stiffness;
  EXPECT_NEAR(plain, 0.0657895, 5e-8);
  EXPECT_NEAR(limit, plain, 5e-4 * plain);
  // The thousand aliases leave 1e-6 of their sum, itself 3e-4 of the whole; the grid's first point
  // is (1e-4)^2 away from zero.
  EXPECT_NEAR(limit, root, 2e-8 * root);
}

TEST(RcExample, textbook_criteria_do_not_apply_and_say_why) {
  const Verdict verdict = judge(make_display(), 0.2);
  EXPECT_FALSE(verdict.passive);
  const CriterionResult& frequency_dependent = find_criterion(verdict, "frequency_dependent");
  EXPECT_TRUE(frequency_dependent.holds);
  EXPECT_FALSE(frequency_dependent.applies);
  EXPECT_TRUE(mentions(frequency_dependent.reason, "A is not 1"));
  EXPECT_TRUE(mentions(frequency_dependent.reason, "0.0033 s"));  // R_m C
  EXPECT_TRUE(mentions(frequency_dependent.reason, "falls with frequency"));
  const CriterionResult& spring_damper = find_criterion(verdict, "spring_damper");
  EXPECT_FALSE(spring_damper.applies);
  EXPECT_TRUE(mentions(spring_damper.reason, "A is not 1"));
  EXPECT_TRUE(mentions(spring_damper.reason, "depends on frequency"));
  EXPECT_TRUE(mentions(verdict.explanation, "would call it passive, but does not apply"));
}

TEST(RcExample, textbook_with_an_ideal_drive_does_not_apply_for_the_falling_damping_alone) {
  const CriterionResult& textbook =
      find_criterion(judge(make_display(IdealDrive{}), 0.45), "frequency_dependent");
  EXPECT_FALSE(textbook.applies);
  EXPECT_TRUE(mentions(textbook.reason, "falls with frequency"));
  EXPECT_FALSE(mentions(textbook.reason, "A is not 1"));
}

// A run long enough for the sixth of it that classification compares to grow by `growth`.
TimeRun run(const MassSpringDamper& held_by, double stiffness, double spectral_radius) {
  const double growth = 0.1;
  const double samples = 6 * growth / std::abs(spectral_radius - 1);
  SimulationOptions options;
  options.duration = Rational(static_cast<std::int64_t>(samples), 1000);
  options.initial_velocity = 1;
  options.engine_options.ledger = false;
  const Plant plant = build_plant(build_device_network(make_display(), held_by));
  return simulate(plant, {}, VirtualWall{stiffness, B}, {}, options);
}

TEST(RcExample, just_above_the_limit_an_inertia_held_by_the_operator_makes_the_run_diverge) {
  const double K = find_limit(make_display(), Criterion::exact_disk).stiffness;
  const Verdict above = judge(make_display(), 1.03 * K);
  EXPECT_FALSE(above.passive);
  ASSERT_TRUE(above.counterexample.has_value());
  const MassSpringDamper& held_by = above.counterexample->held_by;
  EXPECT_GT(held_by.inertia, 0);
  EXPECT_EQ(held_by.damping, 0);
  ASSERT_GT(above.counterexample->spectral_radius, 1 + 1e-7);
  const TimeRun growing = run(held_by, 1.03 * K, above.counterexample->spectral_radius);
  EXPECT_EQ(growing.classification.outcome, Outcome::diverges);
  EXPECT_NEAR(growing.classification.frequency_hz, above.counterexample->frequency_hz,
              0.01 * above.counterexample->frequency_hz);
}

TEST(RcExample, the_inertia_of_the_equations_sheet_does_it_too_and_below_the_limit_it_does_not) {
  // "a plain inertia of 3.6e-3 kg.m^2 held by the operator indeed makes the loop diverge just above
  // it"
  const double K = find_limit(make_display(), Criterion::exact_disk).stiffness;
  const MassSpringDamper held_by{3.6e-3, 0, 0, {}};
  const auto radius = [&](double stiffness) {
    return judge_operator(make_display(), {}, make_wall_law({stiffness, B}, T), held_by)
        .spectral_radius;
  };
  EXPECT_GT(radius(1.03 * K), 1);
  EXPECT_LT(radius(0.97 * K), 1);
  EXPECT_EQ(run(held_by, 1.03 * K, radius(1.03 * K)).classification.outcome, Outcome::diverges);
  EXPECT_EQ(run(held_by, 0.97 * K, radius(0.97 * K)).classification.outcome, Outcome::settles);
}

TEST(RcExample, just_below_the_limit_every_passive_operator_is_safe) {
  const double K = find_limit(make_display(), Criterion::exact_disk).stiffness;
  const Verdict below = judge(make_display(), 0.97 * K);
  EXPECT_TRUE(below.passive);
  EXPECT_FALSE(below.counterexample.has_value());
}

Controller emphasized(const Device& device, double stiffness) {
  const ActuationRoots roots = find_actuation_roots(device);
  return {VirtualWall{stiffness, B}, {make_pre_emphasis(roots.poles, roots.zeros, pi / T, T)}};
}

TEST(RcExample, pre_emphasis_gives_back_what_the_lagging_command_took) {
  const Device device = make_display();
  StiffnessLimits limits(device, {}, emphasized(device, 0), FreeOperator{});
  const double K = limits.find(Criterion::exact_disk, B).stiffness;
  // The ideal command path allows 0.468, bound at Nyquist; the textbook (b + B) 2/T = 0.5 at DC.
  EXPECT_GT(K, 0.468);
  EXPECT_LT(K, 0.5);
  const Verdict below = judge_passivity({device, emphasized(device, 0.99 * K), {}, 0});
  EXPECT_TRUE(below.passive);
  const Verdict above = judge_passivity({device, emphasized(device, 1.03 * K), {}, 0});
  EXPECT_FALSE(above.passive);
  ASSERT_TRUE(above.counterexample.has_value());
  EXPECT_GT(above.counterexample->spectral_radius, 1);
}

TEST(RcExample, with_pre_emphasis_the_old_counterexample_no_longer_diverges) {
  const Device device = make_display();
  const MassSpringDamper held_by{3.6e-3, 0, 0, {}};
  for (const double K : {0.1, 0.2, 0.4}) {
    const Controller controller = emphasized(device, K);
    EXPECT_LT(judge_operator(device, {}, make_contact_law(controller, T), held_by).spectral_radius,
              1)
        << K;
    SimulationOptions options;
    options.duration = Rational(20);
    options.initial_velocity = 1;
    const Plant plant = build_plant(build_device_network(device, held_by));
    EXPECT_EQ(simulate(plant, {}, controller, {}, options).classification.outcome, Outcome::settles)
        << K;
    EXPECT_EQ(simulate(plant, {}, VirtualWall{K, B}, {}, options).classification.outcome,
              Outcome::diverges)
        << K;
  }
}

}  // namespace
}  // namespace gyrator
