#include "gyrator/two_port/coupled_devices.hpp"

#include "gyrator/core/error.hpp"

#include <cmath>

#include <gtest/gtest.h>

#include "support/passivity_closed_forms.hpp"

namespace gyrator {
namespace {

using namespace passivity_tests;

constexpr double K = 300, B = 0.5, b = 0.8, m = 0.04;

ComputedPath continuous() {
  ComputedPath path;
  path.period = path.step = 0;
  return path;
}

CoupledDevices make_equal(const DeviceCoupling& coupling, double damping = b) {
  const Device device = make_point_mass(m, damping).device;
  return {device, continuous(), device, continuous(), coupling};
}

TEST(CoupledDevices, without_delay_are_two_masses_on_one_spring_and_damper) {
  CoupledDevices devices = make_equal({{K, B}});
  for (const double omega : {0.2, 30.0, 900.0}) {
    const Complex s(0, omega), C = B + K / s, Z = m * s + b;
    const ImpedanceMatrix z = devices.impedance_at(omega);
    EXPECT_NEAR(std::abs(z.z11 / (Z + C) - 1.0), 0, 1e-12);
    EXPECT_NEAR(std::abs(z.z12 / C + 1.0), 0, 1e-12);
    EXPECT_NEAR(std::abs(z.z21 / C + 1.0), 0, 1e-12);
    EXPECT_NEAR(std::abs(z.z22 / (Z + C) - 1.0), 0, 1e-12);
    // Felt with the other end clamped: mass, damper and coupling.
    EXPECT_NEAR(std::abs(devices.at(omega).transmitted_when_clamped() / (Z + C) - 1.0), 0, 1e-9);
  }
}

TEST(CoupledDevices, without_delay_are_absolutely_stable_in_continuous_time_also_undamped) {
  EXPECT_TRUE(make_equal({{K, B}}).judge(1e4).absolutely_stable);
  EXPECT_TRUE(make_equal({{K, 0}}, 1e-3).judge(1e4).absolutely_stable);
  EXPECT_TRUE(make_equal({{K, B}}, 0).judge(1e4).absolutely_stable);
}

TEST(CoupledDevices, with_delay_have_the_third_condition_in_closed_form) {
  const double t = 0.02;
  CoupledDevices devices = make_equal({{K, B}, t, t});
  for (const double omega : {0.2, 30.0, 157.0, 900.0}) {
    const double late = B * std::cos(omega * t) - K / omega * std::sin(omega * t);
    const double expected = 2 * (std::pow(b + B, 2) - late * late);
    const ImpedanceMatrix z = devices.impedance_at(omega);
    const double third = compute_llewellyn_margins(devices.at(omega)).third * std::norm(z.z22);
    EXPECT_NEAR(third, expected, 1e-9 * (std::norm(z.z22) + std::abs(expected))) << omega;
  }
}

TEST(CoupledDevices, are_stable_up_to_the_delay_that_the_dampers_pay_for) {
  // B = 0: K t |sin wt/(wt)| <= b at every frequency, worst towards zero.
  const double t = b / K;
  EXPECT_TRUE(make_equal({{K, 0}, 0.99 * t, 0.99 * t}).judge(1e4).absolutely_stable);
  const TwoPortVerdict late = make_equal({{K, 0}, 1.01 * t, 1.01 * t}).judge(1e4);
  EXPECT_FALSE(late.absolutely_stable);
  ASSERT_EQ(late.conditions[2].violated.size(), 1);
  EXPECT_LT(late.ratio_frequency_hz, 0.2);
  EXPECT_LT(late.ratio, 1);
  // sin x/x = 1/1.01 at x^2 = 6 (1 - 1/1.01), to 1 %.
  const double edge = std::sqrt(6 * (1 - 1 / 1.01)) / (2 * pi * 1.01 * t);
  EXPECT_NEAR(late.conditions[2].violated[0].to_hz / edge, 1, 0.01);
}

TEST(CoupledDevices, sampled_finely_are_the_continuous_ones) {
  const Device device = make_point_mass(m, b).device;
  ComputedPath path;
  path.period = path.step = path.tick = 1e-7;
  for (const CouplingPlace place : {CouplingPlace::both_ends, CouplingPlace::slave}) {
    const DeviceCoupling coupling{{K, B}, 3e-3, 5e-3, place};
    CoupledDevices sampled(device, path, device, path, coupling);
    CoupledDevices ideal = make_equal(coupling);
    const HybridMatrix a = sampled.at(50), c = ideal.at(50);  // w T = 5e-6
    EXPECT_NEAR(std::abs(a.h11 / c.h11 - 1.0), 0, 1e-4);
    EXPECT_NEAR(std::abs(a.h12 / c.h12 - 1.0), 0, 1e-4);
    EXPECT_NEAR(std::abs(a.h21 / c.h21 - 1.0), 0, 1e-4);
    EXPECT_NEAR(std::abs(a.h22 / c.h22 - 1.0), 0, 1e-4);
  }
}

TEST(CoupledDevices, computed_at_the_slave_send_its_effort_back) {
  const double there = 3e-3, back = 5e-3, omega = 50;
  CoupledDevices devices = make_equal({{K, B}, there, back, CouplingPlace::slave});
  const Complex s(0, omega), C = B + K / s, Z = m * s + b;
  const ImpedanceMatrix z = devices.impedance_at(omega);
  EXPECT_NEAR(std::abs(z.z11 / (Z + C * std::exp(-s * (there + back))) - 1.0), 0, 1e-12);
  EXPECT_NEAR(std::abs(z.z12 / (C * std::exp(-s * back)) + 1.0), 0, 1e-12);
  EXPECT_NEAR(std::abs(z.z21 / (C * std::exp(-s * there)) + 1.0), 0, 1e-12);
  EXPECT_NEAR(std::abs(z.z22 / (Z + C) - 1.0), 0, 1e-12);
}

TEST(CoupledDevices, sense_and_act_through_their_own_paths) {
  const KnownDevice motor = make_rc_motor();
  ComputedPath path;
  path.sensing = Sensing::position;
  path.delay = 0.5e-3;
  CoupledDevices devices(motor.device, path, motor.device, path, {{0.2, 1e-3}});
  const double omega = 40, T = 1e-3;
  const Complex s(0, omega), z = std::exp(s * T), G = (1.0 - 1.0 / z) / (s * T);
  const PortForm form = motor.at(s);
  const Complex C = 1e-3 + 0.2 * T * z / (z - 1.0);
  const Complex expected = form.impedance + form.actuation * G * std::exp(-0.5e-3 * s) * C * G;
  EXPECT_NEAR(std::abs(devices.impedance_at(omega).z11 / expected - 1.0), 0, 1e-9);
}

TEST(CoupledDevices, refuse_two_periods) {
  const Device device = make_p3().device;
  ComputedPath slow;
  slow.period = slow.step = 2e-3;
  EXPECT_THROW(CoupledDevices(device, {}, device, slow, {}), Error);
}

}  // namespace
}  // namespace gyrator
