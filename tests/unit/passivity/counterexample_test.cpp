#include "gyrator/passivity/counterexample.hpp"

#include "gyrator/cosim/sampled_plant.hpp"
#include "gyrator/passivity/verdict.hpp"

#include <gtest/gtest.h>

#include "support/passivity_closed_forms.hpp"

namespace gyrator {
namespace {

using namespace passivity_tests;

struct Broken {
  std::string name;
  KnownDevice known;
  Sampling sampling;
  double virtual_damping;
};

std::vector<Broken> make_broken() {
  const Rational T(1, 1000);
  return {{"rc motor", make_rc_motor(), {T, 0}, 1.5e-4},
          {"rc motor, late", make_rc_motor(), {T, Rational(7, 10000)}, 1e-4},
          {"slow amplifier", make_slow_rc_motor(300), {T, 0}, 1e-4},
          {"compliant, sensor at motor",
           make_compliant(2e-5, 2e-4, {0.8, 1e-4, 1e-5}, SensorLocation::motor),
           {T, 0},
           5e-5},
          {"P3, ten periods late", make_p3(), {T, Rational(1, 100)}, 0}};
}

PassivityModel at_share_of_limit(const Broken& broken, double share) {
  StiffnessLimits limits(broken.known.device, broken.sampling, DifferenceEstimator{},
                         FreeOperator{});
  const double K = limits.find(Criterion::exact_disk, broken.virtual_damping).stiffness;
  return {broken.known.device, VirtualWall{share * K, broken.virtual_damping}, broken.sampling, 0};
}

TEST(Counterexample, is_a_lossless_operator_with_which_the_exact_loop_diverges) {
  for (const Broken& broken : make_broken()) {
    const PassivityModel model = at_share_of_limit(broken, 1.1);
    const Verdict verdict = judge_passivity(model);
    ASSERT_TRUE(verdict.counterexample.has_value()) << broken.name;
    const MassSpringDamper& held_by = verdict.counterexample->held_by;
    EXPECT_EQ(held_by.damping, 0) << broken.name;
    EXPECT_GE(held_by.inertia, 0);
    EXPECT_GE(held_by.stiffness, 0);
    // The loop put together once more, here.
    const double period = model.sampling.period.to_double();
    const Plant plant = build_plant(build_device_network(model.device, held_by));
    const DominantPole pole =
        find_dominant_pole(build_loop_matrix(sample_plant(plant, model.sampling),
                                             make_contact_law(model.controller, period)),
                           period);
    EXPECT_GT(pole.magnitude, 1 + 1e-8) << broken.name;
    EXPECT_DOUBLE_EQ(pole.magnitude, verdict.counterexample->spectral_radius) << broken.name;
    EXPECT_DOUBLE_EQ(pole.frequency_hz, verdict.counterexample->frequency_hz) << broken.name;
  }
}

TEST(Counterexample, does_no_harm_below_the_limit) {
  for (const Broken& broken : make_broken()) {
    const Verdict verdict = judge_passivity(at_share_of_limit(broken, 1.1));
    ASSERT_TRUE(verdict.counterexample.has_value()) << broken.name;
    const PassivityModel below = at_share_of_limit(broken, 0.99);
    const double period = below.sampling.period.to_double();
    const Counterexample judged =
        judge_operator(below.device, below.sampling, make_contact_law(below.controller, period),
                       verdict.counterexample->held_by);
    EXPECT_LE(judged.spectral_radius, 1 + stability_tolerance) << broken.name;
  }
}

TEST(Counterexample, is_a_plain_inertia_for_the_rc_motor) {
  const Verdict verdict = judge_passivity(at_share_of_limit(make_broken().front(), 1.03));
  ASSERT_TRUE(verdict.counterexample.has_value());
  EXPECT_GT(verdict.counterexample->held_by.inertia, 0);
  EXPECT_EQ(verdict.counterexample->held_by.stiffness, 0);
  EXPECT_TRUE(verdict.counterexample->held_by.resonators.empty());
}

TEST(Counterexample, is_found_where_the_disk_binds_in_between_and_at_nyquist) {
  // There an inertia and a spring do not do: the aliases count, and each wants a reactance of its
  // own.
  RcParameters at_nyquist;
  at_nyquist.J = 1.4e-5;
  at_nyquist.b = 2.4e-4;
  at_nyquist.K_t = 0.03;
  at_nyquist.R_1 = 13;
  at_nyquist.C = 290e-6;
  RcParameters between = at_nyquist;
  between.J = 4e-6;
  between.C = 17e-6;
  const std::vector<Broken> all{
      {"Nyquist", make_rc_motor(at_nyquist), {Rational(1, 1000), 0}, 1.9e-4},
      {"in between", make_rc_motor(between), {Rational(1, 1000), Rational(13, 10000)}, 2e-4}};
  for (const Broken& broken : all) {
    const Verdict verdict = judge_passivity(at_share_of_limit(broken, 1.03));
    ASSERT_FALSE(verdict.passive) << broken.name;
    EXPECT_GT(verdict.worst_disk.omega * 1e-3, 0.2 * pi) << broken.name;
    EXPECT_TRUE(verdict.counterexample.has_value()) << broken.name;
  }
}

TEST(Counterexample, is_not_sought_for_a_loop_that_passes) {
  EXPECT_FALSE(
      judge_passivity(at_share_of_limit(make_broken().front(), 0.97)).counterexample.has_value());
}

TEST(Counterexample, is_found_where_the_free_loop_diverges_by_itself) {
  const Verdict verdict = judge_passivity({make_p3().device, VirtualWall{2000, 0}, {}, 0});
  ASSERT_TRUE(verdict.counterexample.has_value());
  EXPECT_GT(verdict.counterexample->spectral_radius, 1);
}

TEST(JudgedOperator, has_the_spectral_radius_and_frequency_of_a_known_pole) {
  // Undamped mass, no delay, spring alone: z^2 - (2 - a/2) z + (1 + a/2) = 0, a = K T^2/m, so
  // |z|^2 = 1 + a/2 while the poles are complex.
  const double m = 0.5;
  const double M = 1.5;
  const double K = 1e4;
  const double period = 1e-3;
  const double a = K * period * period / (m + M);
  const Counterexample judged =
      judge_operator(make_point_mass(m, 0).device, {}, make_gain(K), MassSpringDamper{M, 0, 0, {}});
  EXPECT_NEAR(judged.spectral_radius, std::sqrt(1 + a / 2), 1e-12);
  const double angle = std::acos((2 - a / 2) / 2 / std::sqrt(1 + a / 2));
  EXPECT_NEAR(judged.frequency_hz, angle / (2 * pi * period), 1e-8);
}

}  // namespace
}  // namespace gyrator
