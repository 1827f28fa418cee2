#include "gyrator/passivity/criteria.hpp"

#include <gtest/gtest.h>

#include "support/passivity_closed_forms.hpp"
#include "support/mentions.hpp"

namespace gyrator {
namespace {

using namespace passivity_tests;

const Sampling prompt{Rational(1, 1000), Rational(0)};
const Sampling one_late{Rational(1, 1000), Rational(1, 1000)};
const Sampling part_late{Rational(1, 1000), Rational(1, 4000)};

Assumptions test(const KnownDevice& known, const Sampling& sampling = prompt) {
  PortModel model(known.device);
  return test_assumptions(known.device, sampling, model);
}

TEST(Assumptions, all_hold_for_a_point_mass_under_an_ideal_drive) {
  const Assumptions a = test(make_p3());
  EXPECT_TRUE(a.constant_damping);
  EXPECT_TRUE(a.non_decreasing_damping);
  EXPECT_TRUE(a.ideal_drive);
  EXPECT_TRUE(a.collocated);
  EXPECT_TRUE(a.no_delay);
  EXPECT_TRUE(a.whole_delay);
  EXPECT_EQ(a.lag_s, 0);
}

TEST(Assumptions, tell_a_whole_delay_from_a_fractional_one) {
  EXPECT_FALSE(test(make_p3(), one_late).no_delay);
  EXPECT_TRUE(test(make_p3(), one_late).whole_delay);
  EXPECT_FALSE(test(make_p3(), part_late).no_delay);
  EXPECT_FALSE(test(make_p3(), part_late).whole_delay);
}

TEST(Assumptions, a_high_pass_damper_only_rises_with_frequency) {
  const Assumptions a = test(make_high_pass(0.04, 0.8, {0.01, 2}));
  EXPECT_FALSE(a.constant_damping);
  EXPECT_TRUE(a.non_decreasing_damping);
}

TEST(Assumptions, the_rc_motors_damping_rises_and_then_falls_where_the_winding_takes_over) {
  const Assumptions a = test(make_rc_motor({}, true));
  EXPECT_FALSE(a.constant_damping);
  EXPECT_FALSE(a.non_decreasing_damping);
  EXPECT_TRUE(a.ideal_drive);
  // |Z_w|^2 is least where L_m w = 1/(C w): 1/(2 pi sqrt(L_m C)) = 151.7 Hz; told on a 5 % grid
  // after a fall by 1e-6.
  EXPECT_NEAR(a.falling_from_hz, 151.7, 0.06 * 151.7);
}

TEST(Assumptions, the_current_sources_path_lags_by_the_resistance_times_the_capacitance) {
  // A = (R_1 + 1/(C s))/(R_m + L_m s + R_1 + 1/(C s)) -> 1 - s R_m C.
  const Assumptions a = test(make_rc_motor());
  EXPECT_FALSE(a.ideal_drive);
  EXPECT_NEAR(a.lag_s, 1.5 * 2200e-6, 1e-6 * a.lag_s);
}

TEST(Assumptions, a_sensor_behind_the_transmission_is_not_at_the_port) {
  const Transmission t{2e4, 0.3, 0.02};
  EXPECT_FALSE(test(make_compliant(0.04, 0.8, t, SensorLocation::motor)).collocated);
  EXPECT_TRUE(test(make_compliant(0.04, 0.8, t, SensorLocation::port)).collocated);
}

TEST(Assumptions, a_slow_amplifier_is_no_ideal_drive) {
  KnownDevice known = make_p3();
  known.device.drive.motor = Motor{0.05, 1.5, 0.5e-3};
  known.device.drive.amplifier = CurrentAmplifier{};
  EXPECT_TRUE(test(known).ideal_drive);
  known.device.drive.amplifier = CurrentAmplifier{2000};
  EXPECT_FALSE(test(known).ideal_drive);
  EXPECT_NEAR(test(known).lag_s, 1 / (2 * pi * 2000), 1e-6 * test(known).lag_s);
}

std::vector<CriterionResult> judge(const PassivityModel& model) {
  StiffnessLimits limits(model.device, model.sampling, DifferenceEstimator{}, FreeOperator{});
  return judge_textbook(
      model, test_assumptions(model.device, model.sampling, limits.disk().model()), limits);
}

CriterionResult judge(const PassivityModel& model, const std::string& name) {
  for (const CriterionResult& c : judge(model)) {
    if (c.name == name) return c;
  }
  ADD_FAILURE() << "no criterion " << name;
  return {};
}

TEST(SpringDamperCriterion, holds_up_to_its_limit_and_leaves_what_its_inequality_leaves) {
  const CriterionResult below =
      judge({make_p3().device, VirtualWall{799, 0.4}, prompt, 0}, "spring_damper");
  const CriterionResult above =
      judge({make_p3().device, VirtualWall{801, 0.4}, prompt, 0}, "spring_damper");
  EXPECT_TRUE(below.applies);
  EXPECT_TRUE(below.holds);
  EXPECT_FALSE(above.holds);
  EXPECT_NEAR(below.margin, 0.5e-3, 1e-12);
  EXPECT_NEAR(above.margin, -0.5e-3, 1e-12);
  EXPECT_NEAR(*below.max_stiffness, 800, 1e-9);
  EXPECT_NEAR(*below.worst_frequency_hz, 500, 1e-9);
}

TEST(SpringDamperCriterion, counts_a_negative_virtual_damping_by_its_size) {
  const CriterionResult c =
      judge({make_p3().device, VirtualWall{400, -0.4}, prompt, 0}, "spring_damper");
  EXPECT_NEAR(c.margin, 0.8 - 0.2 - 0.4, 1e-12);
  EXPECT_NEAR(*c.max_stiffness, 800, 1e-9);
}

TEST(SpringDamperCriterion, does_not_apply_with_a_delay_a_filter_a_varying_damping_or_a_circuit) {
  const auto reason = [](const Device& device, const VirtualWall& wall, const Sampling& sampling) {
    const CriterionResult c = judge({device, wall, sampling, 0}, "spring_damper");
    EXPECT_FALSE(c.applies);
    return c.reason;
  };
  const VirtualWall wall{100, 0.1};
  EXPECT_TRUE(mentions(reason(make_p3().device, wall, one_late), "delay"));
  EXPECT_TRUE(mentions(reason(make_high_pass(0.04, 0.8, {0.01, 2}).device, wall, prompt),
                       "depends on frequency"));
  EXPECT_TRUE(mentions(reason(make_rc_motor().device, wall, prompt), "A is not 1"));
  EXPECT_TRUE(
      mentions(reason(make_p3().device, {100, 0.1, FilteredDifferenceEstimator{100}}, prompt),
               "backward difference"));
  EXPECT_TRUE(mentions(reason(make_p3().device, {100, 0.1, DifferenceEstimator{3}}, prompt),
                       "backward difference"));
  const Device compliant =
      make_compliant(0.04, 0.8, {2e4, 0.3, 0.02}, SensorLocation::motor).device;
  EXPECT_TRUE(mentions(reason(compliant, wall, prompt), "sensor is not at the port"));
}

TEST(SpringDamperCriterion, does_not_mind_the_estimator_of_a_wall_without_damping) {
  EXPECT_TRUE(
      judge({make_p3().device, VirtualWall{100, 0, FilteredDifferenceEstimator{100}}, prompt, 0},
            "spring_damper")
          .applies);
}

TEST(FrequencyDependentCriterion, applies_to_a_rising_damping_and_to_a_whole_delay) {
  const VirtualWall wall{100, 0.1};
  EXPECT_TRUE(
      judge({make_high_pass(0.04, 0.8, {0.01, 2}).device, wall, prompt, 0}, "frequency_dependent")
          .applies);
  EXPECT_TRUE(judge({make_p3().device, wall, one_late, 0}, "frequency_dependent").applies);
}

TEST(FrequencyDependentCriterion,
     does_not_apply_to_a_falling_damping_a_circuit_or_a_fractional_delay) {
  const auto reason = [](const Device& device, const Sampling& sampling) {
    const CriterionResult c =
        judge({device, VirtualWall{0.05, 1e-4}, sampling, 0}, "frequency_dependent");
    EXPECT_FALSE(c.applies);
    return c.reason;
  };
  EXPECT_TRUE(mentions(reason(make_rc_motor({}, true).device, prompt), "falls with frequency"));
  EXPECT_TRUE(mentions(reason(make_rc_motor().device, prompt), "A is not 1"));
  EXPECT_TRUE(mentions(reason(make_p3().device, part_late), "whole number of periods"));
}

TEST(FrequencyDependentCriterion, margin_is_the_least_sum_of_physical_and_virtual_damping) {
  // P3 with K and B: b - K T/2 + B cos(wT), least at Nyquist for B > 0 and towards zero for B < 0.
  const CriterionResult positive =
      judge({make_p3().device, VirtualWall{400, 0.4}, prompt, 0}, "frequency_dependent");
  EXPECT_NEAR(positive.margin, 0.8 - 0.2 - 0.4, 1e-9);
  EXPECT_NEAR(*positive.worst_frequency_hz, 500, 1e-3);
  const CriterionResult negative =
      judge({make_p3().device, VirtualWall{400, -0.4}, prompt, 0}, "frequency_dependent");
  EXPECT_NEAR(negative.margin, 0.8 - 0.2 - 0.4, 1e-9);
  EXPECT_LT(*negative.worst_frequency_hz, 1);
}

TEST(FrequencyDependentCriterion, alone_is_given_without_a_wall) {
  const auto results = judge({make_p3().device, NoController{}, prompt, 0});
  ASSERT_EQ(results.size(), 1U);
  EXPECT_EQ(results[0].name, "frequency_dependent");
  EXPECT_TRUE(results[0].holds);
  EXPECT_FALSE(results[0].max_stiffness.has_value());
}

// Case 11: K <= min(2 b/T, 2 f_c/quantum)                                          [8.5]
PassivityModel make_quantized(double stiffness, double coulomb, double quantum) {
  PassivityModel model{make_p3().device, VirtualWall{stiffness, 0}, prompt, quantum};
  model.device.mechanics.coulomb_friction = coulomb;
  return model;
}

TEST(QuantizedCoulombCriterion, is_bound_by_damping_or_by_friction_whichever_is_less) {
  for (const double stiffness : {799.0, 801.0}) {  // 2 f_c/quantum = 800 N/m
    const CriterionResult c = judge(make_quantized(stiffness, 0.004, 1e-5), "quantized_coulomb");
    EXPECT_TRUE(c.applies) << c.reason;
    EXPECT_NEAR(*c.max_stiffness, 800, 1e-9);
    EXPECT_EQ(c.holds, stiffness < 800);
    EXPECT_EQ(c.margin > 0, stiffness < 800);
  }
  for (const double stiffness : {1599.0, 1601.0}) {  // 2 b/T = 1600 N/m
    const CriterionResult c = judge(make_quantized(stiffness, 0.04, 1e-5), "quantized_coulomb");
    EXPECT_NEAR(*c.max_stiffness, 1600, 1e-9);
    EXPECT_EQ(c.holds, stiffness < 1600);
  }
}

TEST(QuantizedCoulombCriterion,
     allows_nothing_without_friction_and_does_not_apply_without_a_quantum) {
  EXPECT_EQ(*judge(make_quantized(1, 0, 1e-5), "quantized_coulomb").max_stiffness, 0);
  const CriterionResult c = judge(make_quantized(1, 0.004, 0), "quantized_coulomb");
  EXPECT_FALSE(c.applies);
  EXPECT_TRUE(mentions(c.reason, "quantum"));
}

TEST(QuantizedCoulombCriterion, does_not_apply_with_virtual_damping_or_a_delay) {
  PassivityModel model = make_quantized(100, 0.004, 1e-5);
  model.controller = VirtualWall{100, 0.1};
  EXPECT_TRUE(mentions(judge(model, "quantized_coulomb").reason, "virtual damping"));
  model.controller = VirtualWall{100, 0};
  model.sampling = one_late;
  const CriterionResult late = judge(model, "quantized_coulomb");
  EXPECT_FALSE(late.applies);
  EXPECT_TRUE(mentions(late.reason, "delay"));
}

}  // namespace
}  // namespace gyrator
