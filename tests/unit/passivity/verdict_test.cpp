#include "gyrator/passivity/verdict.hpp"

#include "gyrator/core/error.hpp"

#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

#include "support/mentions.hpp"
#include "support/passivity_closed_forms.hpp"

namespace gyrator {
namespace {

using namespace passivity_tests;

const CriterionResult& find_criterion(const Verdict& verdict, const std::string& name) {
  const auto it = std::find_if(verdict.criteria.begin(), verdict.criteria.end(),
                               [&](const CriterionResult& c) { return c.name == name; });
  if (it == verdict.criteria.end()) throw std::runtime_error("no criterion " + name);
  return *it;
}

Device make_active_device() {
  // A loop around the winding's current makes the branch's capacitor look like a negative
  // resistance below w^2 = w_b/(C (R_m + R_1)) = (755 rad/s)^2.
  RcParameters p;
  p.R_1 = 0;
  Device device = make_rc_motor(p).device;
  device.drive.amplifier = CurrentAmplifier{300, CurrentSense::motor};
  return device;
}

TEST(Verdict, is_the_exact_disks_and_stands_on_both_sides_of_its_limit) {
  for (const KnownDevice& known :
       {make_rc_motor(), make_rc_motor({}, true), make_slow_rc_motor(300)}) {
    StiffnessLimits limits(known.device, {}, DifferenceEstimator{}, FreeOperator{});
    const double K = limits.find(Criterion::exact_disk, 1e-4).stiffness;
    const Verdict below =
        judge_passivity({known.device, VirtualWall{0.999 * K, 1e-4}, {}, 0}, false);
    const Verdict above =
        judge_passivity({known.device, VirtualWall{1.001 * K, 1e-4}, {}, 0}, false);
    EXPECT_TRUE(below.passive);
    EXPECT_FALSE(above.passive);
    EXPECT_GT(find_criterion(below, "exact_disk").margin, 0);
    EXPECT_LT(find_criterion(above, "exact_disk").margin, 0);
    EXPECT_DOUBLE_EQ(*find_criterion(above, "exact_disk").max_stiffness, K);
    EXPECT_FALSE(below.extra_damping.has_value());
    EXPECT_FALSE(below.counterexample.has_value());
    EXPECT_TRUE(mentions(below.explanation, "No passive operator"));
    EXPECT_TRUE(mentions(above.explanation, "Some passive operator"));
  }
}

TEST(Verdict, judges_a_unilateral_wall_as_the_wall_that_it_is_in_contact) {
  VirtualWall wall{0.06, 1.5e-4};
  const Verdict bilateral = judge_passivity({make_rc_motor().device, wall, {}, 0}, false);
  wall.unilateral = true;
  const Verdict unilateral = judge_passivity({make_rc_motor().device, wall, {}, 0}, false);
  EXPECT_EQ(unilateral.passive, bilateral.passive);
  EXPECT_EQ(find_criterion(unilateral, "exact_disk").margin,
            find_criterion(bilateral, "exact_disk").margin);
}

TEST(Verdict, finds_every_passive_device_passive_without_a_controller) {
  // The last one's damping vanishes at high frequency, where its disk has no bound; with H = 0
  // there is nothing to multiply it.
  for (const KnownDevice& known :
       {make_p3(), make_rc_motor(),
        make_compliant(0.04, 0.8, {2e4, 0, 0.02}, SensorLocation::port)}) {
    const Verdict verdict = judge_passivity({known.device, NoController{}, {}, 0}, false);
    EXPECT_TRUE(verdict.passive) << verdict.explanation;
    EXPECT_GT(find_criterion(verdict, "exact_disk").margin, 0);
  }
}

TEST(Verdict, names_the_frequency_at_which_an_active_device_supplies_energy) {
  const Verdict verdict = judge_passivity({make_active_device(), VirtualWall{0.01, 0}, {}, 0});
  EXPECT_FALSE(verdict.device_passive);
  EXPECT_FALSE(verdict.passive);
  EXPECT_LT(verdict.least_damping, 0);
  EXPECT_TRUE(mentions(find_criterion(verdict, "exact_disk").reason, "supplies energy"));
  EXPECT_TRUE(mentions(verdict.explanation, "supplies energy"));
  EXPECT_EQ(*find_criterion(verdict, "exact_disk").max_stiffness, 0);
  // Straight from the network: it is the lowest to what its neighbours on a 2 % grid differ by.
  std::vector<double> hz;
  for (double f = 1; f < 1e5; f *= 1.02) hz.push_back(f);
  double lowest = 0;
  for (const PortResponse& r : compute_port_response(make_active_device(), hz)) {
    lowest = std::min(lowest, r.impedance.real());
  }
  EXPECT_NEAR(verdict.least_damping, lowest, 0.02 * std::abs(lowest));
  EXPECT_NEAR(compute_port_response(make_active_device(), {verdict.least_damping_frequency_hz})[0]
                  .impedance.real(),
              verdict.least_damping, 1e-9 * std::abs(lowest));
}

TEST(Verdict, gives_an_active_device_the_margin_that_it_lacks_with_a_wall_as_well) {
  // Two lags turn back-EMF feedback round: of d, 1/(sqrt(r) (2 + sqrt(r))) at most, r the square of
  // the lags' sum over their product.
  constexpr double amplifier_hz = 20e3, low_pass_hz = 1e3, b = 1e-4;
  const double root = (amplifier_hz + low_pass_hz) / std::sqrt(amplifier_hz * low_pass_hz);
  for (const double share : {0.98, 1.02}) {
    const double d = share * b * root * (2 + root);
    Device device = make_rc_motor().device;
    device.mechanics.damping = b;
    device.drive.amplifier = CurrentAmplifier{amplifier_hz};
    device.drive.damping = {BackEmfDamping{d, 1.5, 0.5e-3, low_pass_hz, {}}};
    const Verdict verdict =
        judge_passivity({device, VirtualWall{1e-3, 0}, {Rational(1, 1000), 0}, 0}, false);
    EXPECT_EQ(verdict.device_passive, share < 1);
    if (share < 1) continue;
    const auto exact = std::find_if(verdict.criteria.begin(), verdict.criteria.end(),
                                    [](const auto& c) { return c.name == "exact_disk"; });
    EXPECT_NEAR(exact->margin / (-0.02 * b), 1, 0.05);  // the grid's aliases come close to its dip
    EXPECT_EQ(exact->margin, verdict.least_damping);
    // u = x p - 1 = sqrt(r) at the dip: x = (1 + root) w_a w_l.
    const double dip_hz = std::sqrt((1 + root) * amplifier_hz * low_pass_hz);
    EXPECT_NEAR(*exact->worst_frequency_hz / dip_hz, 1, 0.1);
  }
}

TEST(Verdict, takes_a_device_for_passive_once_a_damper_outweighs_what_it_supplies) {
  const Verdict active = judge_passivity({make_active_device(), NoController{}, {}, 0}, false);
  for (const double share : {0.9, 1.1}) {
    Device damped = make_active_device();
    damped.mechanics.damping += share * std::abs(active.least_damping);
    EXPECT_EQ(judge_passivity({damped, NoController{}, {}, 0}, false).device_passive, share > 1);
  }
}

TEST(Verdict, has_no_bound_where_the_damping_vanishes_faster_than_the_command_path) {
  // Behind a lossless transmission Re Z falls as w^-4, S A as w^-2 with the sensor at the port (no
  // bound) and as w^-4 with the sensor at the motor (bounded).
  const Transmission lossless{2e4, 0, 0.02};
  const Device at_port = make_compliant(0.04, 0.8, lossless, SensorLocation::port).device;
  const Verdict unbounded = judge_passivity({at_port, VirtualWall{10, 0}, {}, 0}, false);
  EXPECT_FALSE(unbounded.passive);
  EXPECT_TRUE(unbounded.device_passive);
  EXPECT_TRUE(std::isinf(unbounded.worst_disk.radius));
  EXPECT_TRUE(
      mentions(find_criterion(unbounded, "exact_disk").reason, "vanishes at high frequency"));

  const Device at_motor = make_compliant(0.04, 0.8, lossless, SensorLocation::motor).device;
  const Verdict bounded = judge_passivity({at_motor, VirtualWall{10, 0}, {}, 0}, false);
  EXPECT_TRUE(bounded.passive);
  EXPECT_TRUE(std::isfinite(bounded.worst_disk.radius));

  const Verdict undamped =
      judge_passivity({make_point_mass(1, 0).device, VirtualWall{10, 1}, {}, 0}, false);
  EXPECT_FALSE(undamped.passive);
  EXPECT_TRUE(std::isinf(undamped.worst_disk.radius));
}

TEST(Verdict, says_so_when_the_loop_is_unstable_with_nothing_attached) {
  // Case 7: P3 at 1 ms is unstable by itself above 1605.351 N/m.
  const Verdict stable = judge_passivity({make_p3().device, VirtualWall{1605, 0}, {}, 0}, false);
  const Verdict unstable = judge_passivity({make_p3().device, VirtualWall{1606, 0}, {}, 0}, false);
  EXPECT_LT(stable.loops.front().uncoupled_spectral_radius, 1);
  EXPECT_GT(unstable.loops.front().uncoupled_spectral_radius, 1);
  EXPECT_FALSE(stable.passive);
  EXPECT_FALSE(unstable.passive);
  EXPECT_TRUE(mentions(unstable.explanation, "nothing attached"));
}

TEST(Verdict, says_when_the_textbook_would_have_let_it_pass) {
  const Verdict verdict =
      judge_passivity({make_rc_motor().device, VirtualWall{0.2, 1.5e-4}, {}, 0}, false);
  EXPECT_FALSE(verdict.passive);
  EXPECT_TRUE(find_criterion(verdict, "frequency_dependent").holds);
  EXPECT_FALSE(find_criterion(verdict, "frequency_dependent").applies);
  EXPECT_TRUE(mentions(verdict.explanation, "does not apply here"));
}

TEST(Verdict, says_when_the_textbook_is_too_strict) {
  // A delay that is not whole: [8.46] counts its loss in full at every frequency.
  const Sampling half{Rational(1, 1000), Rational(1, 2000)};
  const Verdict verdict =
      judge_passivity({make_p3().device, VirtualWall{800, 0.4}, half, 0}, false);
  EXPECT_TRUE(verdict.passive);
  EXPECT_FALSE(find_criterion(verdict, "frequency_dependent").holds);
  EXPECT_TRUE(mentions(verdict.explanation, "too strict"));
}

TEST(Verdict, refuses_a_device_that_is_unstable_alone) {
  // The same amplifier loop beyond its Routh limit, w_b < R_m/L_m = 3000 rad/s.
  Device device = make_active_device();
  device.drive.amplifier = CurrentAmplifier{3000, CurrentSense::motor};
  try {
    judge_passivity({device, VirtualWall{0.01, 0}, {}, 0});
    FAIL() << "no error";
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::numerical);
    EXPECT_TRUE(mentions(error.message(), "unstable"));
  }
}

TEST(Verdict, curves_add_up_and_are_given_up_to_nyquist) {
  const Verdict verdict =
      judge_passivity({make_rc_motor().device, VirtualWall{0.05, 1.5e-4}, {}, 0}, false);
  const DampingCurves& c = verdict.curves;
  ASSERT_GT(c.frequency_hz.size(), 100U);
  for (std::size_t i = 0; i < c.frequency_hz.size(); ++i) {
    EXPECT_DOUBLE_EQ(c.total[i], c.physical[i] + c.virtual_damping[i]);
    const double physical =
        make_rc_motor().at(Complex(0, 2 * pi * c.frequency_hz[i])).impedance.real();
    EXPECT_NEAR(c.physical[i], physical, 1e-12 * physical);
  }
  EXPECT_NEAR(c.frequency_hz.back(), 500, 1e-9);
  // The worst margin is no larger than any point of its curve.
  EXPECT_LE(find_criterion(verdict, "exact_disk").margin,
            *std::min_element(c.exact.begin(), c.exact.end()));
}

}  // namespace
}  // namespace gyrator
