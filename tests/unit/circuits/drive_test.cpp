#include "gyrator/circuits/drive.hpp"

#include "gyrator/core/error.hpp"
#include "gyrator/mechanics/plant.hpp"
#include "gyrator/passivity/port_response.hpp"

#include <cmath>
#include <complex>
#include <functional>
#include <numbers>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "support/device_list.hpp"

namespace gyrator {
namespace {

using Complex = std::complex<double>;
using testing::make_rc_display;

constexpr double pi = std::numbers::pi;
constexpr double K_t = 0.05, R_m = 1.5, L_m = 0.5e-3, J = 2e-5, b = 1e-4;  // make_rc_display()
constexpr double R_1 = 5, C = 2200e-6;

// Ten points a decade from 0.01 Hz to 100 kHz.
std::vector<double> sweep() {
  std::vector<double> frequencies;
  for (int i = 0; i <= 70; ++i) frequencies.push_back(0.01 * std::pow(10.0, i / 10.0));
  return frequencies;
}

struct Expected {
  Complex electrical;  // part of Z that the drive adds to J s + b
  Complex actuation;   // A
};

// The descriptor mixes J s of 1e-6 to 10 with resistances; its LU costs three or four digits.
constexpr double tolerance = 1e-9;

void expect_response(const Drive& drive, const std::function<Expected(Complex)>& formula) {
  Device device = make_rc_display();
  device.drive = drive;
  for (const PortResponse& r : compute_port_response(device, sweep())) {
    const Complex s(0, r.omega);
    const Expected expected = formula(s);
    const Complex Z = J * s + b + expected.electrical;
    const std::string at = std::to_string(r.omega / (2 * pi)) + " Hz";
    EXPECT_LE(std::abs(r.impedance - Z), tolerance * std::abs(Z)) << at;
    // Passivity reads the damping alone, however small beside J w: it is known to rounding of that.
    EXPECT_LE(std::abs(r.impedance.real() - Z.real()),
              tolerance * std::abs(Z.real()) + 1e-14 * std::abs(Z))
        << at;
    EXPECT_LE(std::abs(r.actuation - expected.actuation), tolerance * std::abs(expected.actuation))
        << at;
    EXPECT_EQ(r.sensor_path, 1.0) << at;
    EXPECT_EQ(r.blocked_motion, 0.0) << at;
  }
}

Drive make_drive(const Amplifier& amplifier, std::vector<Damping> damping) {
  return {Motor{K_t, R_m, L_m}, amplifier, std::move(damping)};
}
Complex winding(Complex s) {
  return R_m + L_m * s;
}
Complex branch(Complex s, double resistance) {
  return resistance + 1.0 / (C * s);
}

TEST(Drive, ideal_effort_source_adds_nothing_and_delivers_the_command) {
  expect_response(Drive{}, [](Complex) { return Expected{0, 1}; });
}

TEST(Drive, current_source_leaves_an_undamped_motor_alone) {
  expect_response(make_drive(CurrentAmplifier{}, {}), [](Complex) { return Expected{0, 1}; });
}

TEST(Drive, rc_branch_under_a_current_source_is_equation_8_48) {
  for (const double resistance : {R_1, 0.0}) {
    expect_response(make_drive(CurrentAmplifier{}, {RcDamping{resistance, C}}), [&](Complex s) {
      const Complex loop = winding(s) + branch(s, resistance);
      return Expected{K_t * K_t / loop, branch(s, resistance) / loop};
    });
  }
}

TEST(Drive, rc_branch_has_the_plateau_corner_and_apparent_inertia_of_the_sheet) {
  // b_eq = K_t^2/(R_1 + R_m) above the corner 1/(2 pi C (R_1 + R_m)), inertia K_t^2 C below.
  const double corner_hz = 1 / (2 * pi * C * (R_1 + R_m));
  const auto responses =
      compute_port_response(make_rc_display(), {corner_hz / 1e3, corner_hz, 50 * corner_hz});
  const double plateau = K_t * K_t / (R_1 + R_m);
  const Complex below = (responses[0].impedance - b) / Complex(0, responses[0].omega) - J;
  EXPECT_NEAR(below.real() / (K_t * K_t * C), 1, 1e-5);  // next term is (f/corner)^2
  // At the corner half of the plateau, but for the inductance: w L = 5 % of R, and 0.2 % of that.
  EXPECT_NEAR((responses[1].impedance.real() - b) / plateau, 0.5, 0.01);
  // At 50 corners the winding's L w = 1.7 ohm against 6.5: Re 1/(1 + 0.27j) = 0.93.
  const double lag = L_m * responses[2].omega / (R_1 + R_m);
  EXPECT_NEAR((responses[2].impedance.real() - b) / plateau, 1 / (1 + lag * lag), 1e-2);
}

TEST(Drive, resistor_under_a_current_source_divides_the_current_and_the_command_is_scaled_back) {
  constexpr double R = 10;
  expect_response(make_drive(CurrentAmplifier{}, {ResistorDamping{R}}), [&](Complex s) {
    return Expected{K_t * K_t / (winding(s) + R), (R_m + R) / (winding(s) + R)};
  });
}

TEST(Drive, bandwidth_of_a_loop_around_its_own_output_lags_the_command_only) {
  constexpr double hz = 250;
  expect_response(
      make_drive(CurrentAmplifier{.bandwidth_hz = hz}, {RcDamping{R_1, C}}), [&](Complex s) {
        const Complex loop = winding(s) + branch(s, R_1);
        return Expected{K_t * K_t / loop, branch(s, R_1) / loop / (1.0 + s / (2 * pi * hz))};
      });
}

TEST(Drive, voltage_source_closes_the_back_emf_loop_through_the_winding) {
  expect_response(make_drive(VoltageAmplifier{}, {}), [&](Complex s) {
    return Expected{K_t * K_t / winding(s), R_m / winding(s)};
  });
}

TEST(Drive, voltage_source_with_bandwidth_and_output_resistance) {
  constexpr double R_o = 0.7, hz = 800;
  expect_response(
      make_drive(VoltageAmplifier{.bandwidth_hz = hz, .output_resistance = R_o}, {}),
      [&](Complex s) {
        const Complex loop = winding(s) + R_o;
        return Expected{K_t * K_t / loop, (R_m + R_o) / loop / (1.0 + s / (2 * pi * hz))};
      });
}

TEST(Drive, damping_behind_a_stiff_voltage_source_changes_nothing_at_the_shaft) {
  expect_response(make_drive(VoltageAmplifier{}, {ResistorDamping{10}, RcDamping{R_1, C}}),
                  [&](Complex s) {
                    return Expected{K_t * K_t / winding(s), R_m / winding(s)};
                  });
}

TEST(Drive, damping_under_a_soft_voltage_source_is_its_thevenin_equivalent) {
  constexpr double R_o = 3, R = 10;
  expect_response(
      make_drive(VoltageAmplifier{.bandwidth_hz = {}, .output_resistance = R_o},
                 {ResistorDamping{R}, RcDamping{R_1, C}}),
      [&](Complex s) {
        const Complex source = 1.0 / (1 / R_o + 1 / R + 1.0 / branch(s, R_1));
        const double at_dc = 1 / (1 / R_o + 1 / R);
        const Complex loop = winding(s) + source;
        // Open-circuit voltage per command, source/R_o, against its value at DC.
        return Expected{K_t * K_t / loop, (source / R_o) / (at_dc / R_o) * (R_m + at_dc) / loop};
      });
}

TEST(Drive, an_effort_source_beside_a_motor_leaves_the_branch_as_a_pure_damper) {
  expect_response(make_drive(IdealDrive{}, {RcDamping{R_1, C}}), [&](Complex s) {
    return Expected{K_t * K_t / (winding(s) + branch(s, R_1)), 1};
  });
}

TEST(Drive, ideal_loop_around_the_motor_current_removes_the_damping) {
  for (const Damping& damping :
       {Damping{RcDamping{R_1, C}}, Damping{RcDamping{0, C}}, Damping{ResistorDamping{10}}}) {
    expect_response(
        make_drive(CurrentAmplifier{.bandwidth_hz = {}, .sense = CurrentSense::motor}, {damping}),
        [](Complex) {
          return Expected{0, 1};
        });
  }
}

TEST(Drive, finite_loop_around_the_motor_current_removes_the_damping_within_its_bandwidth) {
  // i' = w_b (i_cmd - i_m) into the branch and the winding:
  //   Z_e = K_t^2 s / (s (Z_b + Z_w) + w_b Z_b),  A = w_b Z_b / (same)
  constexpr double hz = 100, w_b = 2 * pi * hz;
  const Drive drive = make_drive(CurrentAmplifier{.bandwidth_hz = hz, .sense = CurrentSense::motor},
                                 {RcDamping{R_1, C}});
  expect_response(drive, [&](Complex s) {
    const Complex Z_b = branch(s, R_1);
    const Complex loop = s * (Z_b + winding(s)) + w_b * Z_b;
    return Expected{K_t * K_t * s / loop, w_b * Z_b / loop};
  });

  // Both sides of the bandwidth: a decade and a half below, 1/30 of the plateau at most; far above,
  // what the same branch gives under a loop that senses the total.
  Device device = make_rc_display();
  const auto total = compute_port_response(device, {hz / 30, hz * 30});
  device.drive = drive;
  const auto motor = compute_port_response(device, {hz / 30, hz * 30});
  const auto damping = [](const PortResponse& r) { return r.impedance.real() - b; };
  EXPECT_LT(damping(motor[0]), damping(total[0]) / 30);
  EXPECT_NEAR(damping(motor[1]) / damping(total[1]), 1, 0.05);
}

TEST(Drive, a_current_loop_inside_the_rc_node_kills_the_damping_outside_it_delays_the_command) {
  // Inside (motor sensed) over outside (total sensed), one branch and one bandwidth w_b:
  //   Z_in/Z_out = s/(s + w_b Z_b/(Z_b + Z_w)),  A_in/A_out = (s + w_b)/(s + w_b A_0),
  // A_0 = Z_b/(Z_b + Z_w). Inside, damping is s/w_b of itself within the loop's bandwidth and the
  // command arrives; outside, damping is whole and the command lags by R_m C and 1/w_b.
  constexpr double hz = 500, w_b = 2 * pi * hz;
  Device outside = make_rc_display();
  outside.drive.amplifier = CurrentAmplifier{.bandwidth_hz = hz};
  Device inside = outside;
  inside.drive.amplifier = CurrentAmplifier{.bandwidth_hz = hz, .sense = CurrentSense::motor};
  const auto out = compute_port_response(outside, sweep());
  const auto in = compute_port_response(inside, sweep());
  for (std::size_t i = 0; i < out.size(); ++i) {
    const Complex s(0, out[i].omega);
    const Complex rigid = J * s + b;
    const Complex A_0 = branch(s, R_1) / (branch(s, R_1) + winding(s));
    const Complex share = s / (s + w_b * A_0);
    const double known_to =
        tolerance + 1e-13 * std::abs(rigid) / std::abs(out[i].impedance - rigid);
    EXPECT_LE(std::abs((in[i].impedance - rigid) / (out[i].impedance - rigid) - share),
              known_to * 2)
        << out[i].omega;
    EXPECT_LE(std::abs(in[i].actuation / out[i].actuation * (s + w_b * A_0) / (s + w_b) - 1.0),
              2 * tolerance)
        << out[i].omega;
  }

  // In numbers: damping at 50 and 10 Hz, a tenth and a 50th of the bandwidth, and the command's lag
  // at low frequency.
  const auto at = [](const Device& device, double f) {
    return compute_port_response(device, {f}).front();
  };
  const auto damping = [&](const Device& device, double f) {
    return at(device, f).impedance.real() - b;
  };
  EXPECT_NEAR(damping(outside, 50) / (K_t * K_t / (R_1 + R_m)), 0.962, 0.001);
  EXPECT_LT(damping(inside, 50) / damping(outside, 50), 0.04);
  EXPECT_LT(damping(inside, 10) / damping(outside, 10), 0.01);
  EXPECT_NEAR(damping(inside, 20 * hz) / damping(outside, 20 * hz), 1, 0.1);
  const auto lag = [&](const Device& device) {
    const PortResponse r = at(device, 0.1);
    return -std::arg(r.actuation) / r.omega;
  };
  EXPECT_NEAR(lag(outside) / (R_m * C + 1 / w_b), 1, 1e-3);  // 3.6 ms
  EXPECT_NEAR(lag(inside) / (1 / w_b), 1, 1e-3);             // 0.3 ms
}

TEST(Drive, a_circuit_without_a_motor_is_refused) {
  const auto place = [](const Drive& drive) {
    Device device = make_rc_display();
    device.drive = drive;
    try {
      build_device_network(device, FreeOperator{});
    } catch (const Error& error) {
      EXPECT_EQ(error.code(), ErrorCode::bad_input);
      EXPECT_NE(error.message().find("motor"), std::string::npos);
      return error.place();
    }
    return std::string("accepted");
  };
  EXPECT_EQ(place({std::nullopt, CurrentAmplifier{}, {}}), "amplifier");
  EXPECT_EQ(place({std::nullopt, VoltageAmplifier{}, {}}), "amplifier");
  EXPECT_EQ(place({std::nullopt, IdealDrive{}, {ResistorDamping{1}}}), "damping/0");
  EXPECT_EQ(place({std::nullopt, IdealDrive{}, {}}), "accepted");
}

TEST(Drive, values_are_refused_under_the_name_of_their_circuit) {
  const auto place = [](const std::function<void(Device&)>& change) {
    Device device = make_rc_display();
    change(device);
    try {
      build_device_network(device, FreeOperator{});
    } catch (const Error& error) {
      EXPECT_EQ(error.code(), ErrorCode::bad_input);
      return error.place();
    }
    return std::string("accepted");
  };
  EXPECT_EQ(place([](Device& d) { d.drive.motor->resistance = 0; }), "motor.resistance");
  EXPECT_EQ(place([](Device& d) {
              d.drive.damping = {RcDamping{1, 1}, RcDamping{5, 0}};
            }),
            "damping.1.capacitance");
  EXPECT_EQ(place([](Device& d) { d.drive.damping = {ResistorDamping{-5}}; }),
            "damping.0.resistance");
  EXPECT_EQ(place([](Device& d) { d.mechanics.inertia = 0; }), "mechanics.inertia");
}

}  // namespace
}  // namespace gyrator
