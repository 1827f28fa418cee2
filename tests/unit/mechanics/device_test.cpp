#include "gyrator/mechanics/device.hpp"

#include "gyrator/circuits/reduction.hpp"
#include "gyrator/core/error.hpp"
#include "gyrator/passivity/port_response.hpp"

#include <cmath>
#include <complex>
#include <numbers>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "support/device_list.hpp"

namespace gyrator {
namespace {

using Complex = std::complex<double>;
using testing::make_p3;
using testing::make_rc_display;

// Ten points a decade from 0.01 Hz to 100 kHz.
std::vector<double> sweep() {
  std::vector<double> frequencies;
  for (int i = 0; i <= 70; ++i) frequencies.push_back(0.01 * std::pow(10.0, i / 10.0));
  return frequencies;
}

// The descriptor mixes J s of 1e-6 to 10 with resistances; its LU costs three or four digits.
constexpr double tolerance = 1e-9;

void expect_near(Complex found, Complex expected, const PortResponse& at, const char* what) {
  EXPECT_LE(std::abs(found - expected), tolerance * std::abs(expected))
      << what << " at " << at.omega << " rad/s: " << found << ", expected " << expected;
}

TEST(Device, a_bare_inertia_and_damper_is_j_s_plus_b) {
  for (const PortResponse& r : compute_port_response(make_p3(), sweep())) {
    expect_near(r.impedance, Complex(0.8, 0.04 * r.omega), r, "Z");
    EXPECT_NEAR(r.impedance.real() / 0.8, 1, tolerance) << "damping beside 3e4 times the inertia";
    EXPECT_EQ(r.sensor_path, 1.0);
    EXPECT_EQ(r.blocked_motion, 0.0);
  }
}

TEST(Device, high_pass_damper_is_a_damper_in_series_with_its_inertia) {
  // Z = J s + b + 1/(1/b_h + 1/(m_2 s)): Re Z goes from b to b + b_h across b_h/m_2.
  constexpr double m_2 = 0.02, b_h = 2;
  Device device = make_p3();
  device.drive.damping.push_back(HighPassDamper{.inertia = m_2, .damping = b_h});
  for (const PortResponse& r : compute_port_response(device, sweep())) {
    const Complex s(0, r.omega);
    expect_near(r.impedance, 0.04 * s + 0.8 + b_h * m_2 * s / (b_h + m_2 * s), r, "Z");
    expect_near(r.actuation, 1, r, "A");
    const double ratio = r.omega * m_2 / b_h;
    EXPECT_NEAR(r.impedance.real() / (0.8 + b_h * ratio * ratio / (1 + ratio * ratio)), 1,
                tolerance);
  }
}

TEST(Device, compliant_transmission_divides_between_motor_and_load) {
  // With Z_m = J s + b at the motor and Z_t = c + k/s between: Z = J_l s + Z_m Z_t/(Z_m + Z_t),
  // A = Z_t/(Z_m + Z_t); a sensor at the motor sees S = A of the port and M = 1/(Z_m + Z_t).
  constexpr double J = 2e-5, b = 1e-4, k = 20, c = 1e-3, J_l = 1e-5;
  for (const SensorLocation sensor : {SensorLocation::port, SensorLocation::motor}) {
    Device device;
    device.mechanics.inertia = J;
    device.mechanics.damping = b;
    device.mechanics.transmission = Transmission{.stiffness = k, .damping = c, .load_inertia = J_l};
    device.sensor = sensor;
    for (const PortResponse& r : compute_port_response(device, sweep())) {
      const Complex s(0, r.omega);
      const Complex Z_m = J * s + b;
      const Complex Z_t = c + k / s;
      expect_near(r.impedance, J_l * s + Z_m * Z_t / (Z_m + Z_t), r, "Z");
      expect_near(r.actuation, Z_t / (Z_m + Z_t), r, "A");
      if (sensor == SensorLocation::motor) {
        expect_near(r.sensor_path, Z_t / (Z_m + Z_t), r, "S");
        // A difference of two mobilities 1/(J s) here, so known to rounding of those.
        const double known_to = tolerance / std::abs(Z_m + Z_t) + 1e-14 / std::abs(Z_m + J_l * s);
        EXPECT_LE(std::abs(r.blocked_motion - 1.0 / (Z_m + Z_t)), known_to) << r.omega;
      } else {
        EXPECT_EQ(r.sensor_path, 1.0);
        EXPECT_EQ(r.blocked_motion, 0.0);
      }
    }
  }
}

TEST(Device, a_motor_behind_a_transmission_brings_its_electrical_damping_along) {
  constexpr double k = 20, c = 1e-3, J_l = 1e-5;
  Device device = make_rc_display();
  const auto rigid = compute_port_response(device, sweep());
  device.mechanics.transmission = Transmission{.stiffness = k, .damping = c, .load_inertia = J_l};
  const auto compliant = compute_port_response(device, sweep());
  for (std::size_t i = 0; i < rigid.size(); ++i) {
    const PortResponse& r = compliant[i];
    const Complex s(0, r.omega);
    const Complex Z_m = rigid[i].impedance;
    const Complex Z_t = c + k / s;
    expect_near(r.impedance, J_l * s + Z_m * Z_t / (Z_m + Z_t), r, "Z");
    expect_near(r.actuation, rigid[i].actuation * Z_t / (Z_m + Z_t), r, "A");
  }
}

TEST(Device, a_hand_adds_its_impedance_at_the_port) {
  // v_p / f_external = 1/(Z + m_h s + d_h + k_h/s + hung resonators)
  const MassSpringDamper hand{.inertia = 0.1,
                              .damping = 5,
                              .stiffness = 300,
                              .resonators = {{.inertia = 0.02, .stiffness = 900}}};
  const DeviceNetwork device = build_device_network(make_p3(), hand);
  const NetworkEquations equations(device.network);
  const LinearForm port = equations.across(device.port);
  for (const double hz : sweep()) {
    const Complex s(0, 2 * std::numbers::pi * hz);
    const Complex hung = 1.0 / (1.0 / (0.02 * s) + s / 900.0);
    const Complex Z = 0.04 * s + 0.8 + 0.1 * s + 5.0 + 300.0 / s + hung;
    const Eigen::MatrixXcd x = solve_descriptor(equations.descriptor(), s);
    const Complex external = (port.x * x)(device.external_effort);
    const Complex command = (port.x * x)(device.command);
    EXPECT_LE(std::abs(external * Z - 1.0), tolerance) << hz;
    EXPECT_LE(std::abs(command * Z - 1.0), tolerance) << hz << ": A = 1 here";
  }
}

TEST(Device, a_steady_command_of_any_drive_is_felt_in_full_at_the_held_port) {
  // Blocked effort at DC by the reduced state space, C (-A)^-1 B + D, of the clamped network.
  for (auto& [name, device] : testing::make_device_list()) {
    // The scale was set with the winding at the reference temperature.
    if (device.drive.motor) device.drive.motor->temperature_rise = 0;
    const DeviceNetwork clamped = build_device_network(device, ClampedOperator{});
    const NetworkEquations equations(clamped.network);
    const Reduction r = reduce(equations.descriptor());
    const ReducedForm effort = r.reduce(equations.through(clamped.operator_ammeter));
    double felt = effort.input(clamped.command);
    if (r.A.rows() > 0) {
      felt += effort.state.dot(-r.A.fullPivLu().solve(r.B.col(clamped.command)));
    }
    // The ammeter counts what the operator gives: it holds against the device.
    EXPECT_NEAR(felt, -1, tolerance) << name;
  }
}

std::string refusal(const Device& device) {
  try {
    build_device_network(device, FreeOperator{});
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::bad_input);
    return error.place() + ": " + error.message();
  }
  return "accepted";
}

TEST(Device, a_sensor_filter_that_makes_no_sense_is_refused) {
  Device device = make_rc_display();
  device.sensor_filter = SensorFilter{.cutoff_hz = 0};
  EXPECT_EQ(refusal(device), "sensor/filter/cutoff: 0 Hz: must be above 0 Hz");
  device.sensor_filter = SensorFilter{.cutoff_hz = 100, .order = 3};
  EXPECT_EQ(refusal(device), "sensor/filter/order: 3: must be 1 or 2");
  device.sensor_filter = SensorFilter{.cutoff_hz = 100, .order = 2};
  EXPECT_EQ(refusal(device), "accepted");
  device.sensor = SensorLocation::outgoing_wave;
  EXPECT_NE(refusal(device).find("sensor/filter: a controller of kind"), std::string::npos);
}

TEST(Device, a_drive_that_passes_no_steady_effort_cannot_be_scaled_and_is_refused) {
  Device no_torque = make_rc_display();
  no_torque.drive.motor->torque_constant = 0;
  EXPECT_NE(refusal(no_torque).find("amplifier: no steady effort"), std::string::npos);

  // A branch that takes all of the current: K_t R/(R_m + R) of 3e-17 is refused, of 3e-8 scaled up.
  Device shorted = make_rc_display();
  shorted.drive.damping = {ResistorDamping{1e-15}};
  EXPECT_NE(refusal(shorted).find("shorts the motor"), std::string::npos);
  shorted.drive.damping = {ResistorDamping{1e-6}};
  EXPECT_EQ(refusal(shorted), "accepted");
  const PortResponse r = compute_port_response(shorted, {0.01}).front();
  // A = (R_m + R)/(R_m + R + L s), 2e-5 of lag at 0.01 Hz.
  EXPECT_LE(std::abs(r.actuation - 1.5 / Complex(1.5, 0.5e-3 * r.omega)), tolerance);
}

}  // namespace
}  // namespace gyrator
