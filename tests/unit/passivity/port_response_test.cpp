#include "gyrator/passivity/port_response.hpp"

#include "gyrator/circuits/descriptor.hpp"

#include <gtest/gtest.h>

#include "support/passivity_closed_forms.hpp"

namespace gyrator {
namespace {

using namespace passivity_tests;

std::vector<KnownDevice> make_devices() {
  return {
      make_p3(),
      make_rc_motor(),
      make_rc_motor({}, true),
      make_slow_rc_motor(300),
      make_voltage_driven_motor(0.5),
      make_wave_motor(),
      make_wave_motor({.R_c = 1.9}),
      make_high_pass(0.04, 0.8, {0.01, 2.0}),
      make_compliant(0.04, 0.8, {2e4, 0.3, 0.02}, SensorLocation::port),
      make_compliant(0.04, 0.8, {2e4, 0.3, 0.02}, SensorLocation::motor),
      behind_filter(make_rc_motor(), {200, 1}),
      behind_filter(make_p3(), {3e3, 2}),
      behind_filter(make_compliant(0.04, 0.8, {2e4, 0.3, 0.02}, SensorLocation::motor), {300, 2})};
}

std::vector<double> make_frequencies() {
  std::vector<double> hz;
  for (double f = 1e-3; f < 1e6; f *= 1.9) hz.push_back(f);
  return hz;
}

// Relative to the sizes that the elimination handles: the condition of an 8 by 8 system whose
// unknowns were balanced, about 1e3 roundings.
constexpr double agreement = 1e-12;

void expect_close(Complex found, Complex wanted, const std::string& what) {
  EXPECT_LE(std::abs(found - wanted), agreement * std::max(std::abs(wanted), 1e-3))
      << what << ' ' << found << wanted;
}

TEST(PortResponse, is_what_the_laws_written_down_by_hand_give) {
  int number = 0;
  for (const KnownDevice& known : make_devices()) {
    const auto responses = compute_port_response(known.device, make_frequencies());
    for (const PortResponse& r : responses) {
      const PortForm form = known.at(Complex(0, r.omega));
      const std::string where =
          "device " + std::to_string(number) + " at " + std::to_string(r.omega);
      expect_close(r.impedance, form.impedance, where + " Z");
      expect_close(r.actuation, form.actuation, where + " A");
      expect_close(r.sensor_path, form.sensor_path, where + " S");
      EXPECT_LE(std::abs(r.blocked_motion - form.blocked_motion),
                agreement * (std::abs(form.blocked_motion) + std::abs(form.sensor_path)))
          << where << " M";
    }
    ++number;
  }
}

TEST(PortResponse, comes_the_same_from_the_reduced_state_space) {
  for (const KnownDevice& known : make_devices()) {
    PortModel model(known.device);
    for (const PortResponse& r : compute_port_response(known.device, make_frequencies())) {
      const PortResponse fast = model.at(r.omega);
      expect_close(fast.impedance, r.impedance, "Z");
      expect_close(fast.actuation, r.actuation, "A");
      // Behind a filter S is the ratio of two velocities, far below the port's own.
      const double size = std::max(std::abs(r.sensor_path), known.device.sensor_filter ? 1.0 : 0.0);
      EXPECT_LE(std::abs(fast.sensor_path - r.sensor_path), agreement * std::max(size, 1e-3))
          << "S";
    }
  }
}

TEST(PortResponse, keeps_the_digits_of_a_damping_beside_a_reactance_a_million_times_larger) {
  // The criteria divide by Re Z; far above the resonance it is 1e-12 and less of |Z|.
  for (const KnownDevice& known : make_devices()) {
    PortModel model(known.device);
    for (const double hz : make_frequencies()) {
      const double damping = known.at(Complex(0, 2 * pi * hz)).impedance.real();
      EXPECT_NEAR(model.at(2 * pi * hz).impedance.real(), damping, agreement * damping) << hz;
    }
  }
}

TEST(PortResponse, agrees_with_the_admittances_of_the_free_device) {
  // Y_pp = 1/Z, Y_pu = A/Z, Y_sp = S/Z, Y_su = M + S A/Z, each solved with the port left free.
  const KnownDevice known = make_compliant(0.04, 0.8, {2e4, 0.3, 0.02}, SensorLocation::motor);
  const DeviceNetwork network = build_device_network(known.device, FreeOperator{});
  const NetworkEquations equations(network.network);
  for (const PortResponse& r : compute_port_response(known.device, make_frequencies())) {
    const Eigen::MatrixXcd x = solve_descriptor(equations.descriptor(), Complex(0, r.omega));
    const Eigen::RowVectorXcd port = equations.across(network.port).x * x;
    const Eigen::RowVectorXcd sensed = find_sensed_rate(network, equations).x * x;
    expect_close(1.0 / r.impedance, port(network.external_effort), "Y_pp");
    expect_close(r.actuation / r.impedance, port(network.command), "Y_pu");
    expect_close(r.sensor_path / r.impedance, sensed(network.external_effort), "Y_sp");
    expect_close(r.blocked_motion + r.sensor_path * r.actuation / r.impedance,
                 sensed(network.command), "Y_su");
  }
}

TEST(PortResponse, poles_are_those_with_the_port_free_and_clamped) {
  // Free: the two inertias on their spring and the whole drifting; clamped: the motor's inertia
  // alone.
  const double m = 0.04;
  const double load = 0.02;
  const double k = 2e4;
  const PortModel model(make_compliant(m, 0, {k, 0, load}, SensorLocation::port).device);
  for (const double wanted : {std::sqrt(k * (1 / m + 1 / load)), std::sqrt(k / m)}) {
    double nearest = wanted;
    for (const auto& pole : model.poles()) {
      nearest = std::min(nearest, std::abs(pole - Complex(0, wanted)));
    }
    EXPECT_LT(nearest, 1e-9 * wanted) << wanted;
  }
}

}  // namespace
}  // namespace gyrator
