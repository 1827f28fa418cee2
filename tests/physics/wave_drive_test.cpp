#include "gyrator/controllers/wave_controller.hpp"
#include "gyrator/core/error.hpp"
#include "gyrator/cosim/sampled_plant.hpp"
#include "gyrator/cosim/simulation.hpp"
#include "gyrator/passivity/port_response.hpp"

#include <algorithm>
#include <cmath>
#include <complex>
#include <functional>
#include <numbers>
#include <string>

#include <gtest/gtest.h>

#include "support/wave_display.hpp"

// The wave drive against its closed forms, and the sampled wave loop in time against frequency.

namespace gyrator {
namespace {

using Complex = std::complex<double>;
using std::numbers::pi;
using testing::make_wave_controller;
using testing::make_wave_display;

constexpr double K_t = 23.5e-3, R_m = 2.06, L_m = 0.238e-3, J = 1.07e-6, b = 1.2e-6;
constexpr double b_w = testing::wave_impedance, R_w = K_t * K_t / b_w;

// As in drive_test: the descriptor's LU costs three or four digits.
constexpr double tolerance = 1e-9;

void expect_impedance(const Device& device, const std::function<Complex(Complex)>& formula) {
  std::vector<double> hz;
  for (int i = 0; i <= 70; ++i) hz.push_back(0.01 * std::pow(10.0, i / 10.0));
  for (const PortResponse& r : compute_port_response(device, hz)) {
    const Complex Z = formula(Complex(0, r.omega));
    EXPECT_LE(std::abs(r.impedance - Z), tolerance * std::abs(Z)) << r.omega / (2 * pi) << " Hz";
  }
}

TEST(WaveDrive, impedance_is_that_of_the_winding_and_the_source_resistance) {
  expect_impedance(make_wave_display(),
                   [](Complex s) { return J * s + b + K_t * K_t / (R_w + R_m + L_m * s); });
}

TEST(WaveDrive, a_matched_line_behind_an_ideal_winding_is_a_damper_of_the_wave_impedance) {
  Device device = make_wave_display(1);
  device.drive.motor->inductance = 0;
  expect_impedance(device, [](Complex s) { return J * s + b + b_w; });
}

TEST(WaveDrive, the_winding_inductance_couples_shaft_and_line_as_a_spring) {
  // All of R_m cancelled: K_L = K_t^2/L_m in series with b_w [8.6.4].
  const double K_L = K_t * K_t / L_m;
  EXPECT_NEAR(K_L, 2.3204, 1e-4);
  expect_impedance(make_wave_display(1),
                   [&](Complex s) { return J * s + b + 1.0 / (1 / b_w + s / K_L); });
}

TEST(WaveDrive, counts_the_amplifiers_own_resistance_in) {
  Device device = make_wave_display();
  for (const double share : {0.3, 1.0}) {
    device.drive.amplifier = VoltageAmplifier{{}, share * R_w};
    expect_impedance(device,
                     [](Complex s) { return J * s + b + K_t * K_t / (R_w + R_m + L_m * s); });
    const DeviceNetwork network = build_device_network(device, FreeOperator{});
    EXPECT_NEAR(network.drive.volts_per_command, (R_w + R_m) / K_t, 1e-9);
  }
  device.drive.amplifier = VoltageAmplifier{{}, 1.01 * R_w};
  EXPECT_THROW(build_device_network(device, FreeOperator{}), Error);
}

TEST(WaveDrive, refuses_what_has_no_source_resistance_and_a_second_one) {
  const auto message = [](const Device& device) -> std::string {
    try {
      build_device_network(device, FreeOperator{});
    } catch (const Error& error) {
      return error.place() + ": " + error.message();
    }
    return "accepted";
  };
  Device device = make_wave_display();
  device.drive.damping.emplace_back(WaveDamping{1e-3});
  EXPECT_EQ(message(device).find("damping/1: a second wave"), 0U) << message(device);
  device.drive.damping = {WaveDamping{1e-3}};
  for (const Amplifier& amplifier : {Amplifier{CurrentAmplifier{}}, Amplifier{IdealDrive{}}}) {
    device.drive.amplifier = amplifier;
    EXPECT_NE(message(device).find("\"voltage\""), std::string::npos) << message(device);
  }
  device.drive.amplifier = VoltageAmplifier{};
  device.drive.damping.clear();
  EXPECT_NE(message(device).find("no wave leaves"), std::string::npos) << message(device);
}

// Stiffness at the port at low frequency with the loop closed, the base alias alone (the others
// weigh with w^2):  Z + A H k_0 S/(1 + H k_0 M), k_0 = (1 - e^(-jwT)) e^(-jw t_d)/(T (jw)^2).
double find_rendered_stiffness(const Device& device, const WaveController& wave,
                               const Sampling& sampling, double hz) {
  const double T = sampling.period.to_double();
  const PortResponse r = compute_port_response(device, {hz}).front();
  const Complex s(0, r.omega);
  const Complex k =
      (1.0 - std::exp(-s * T)) * std::exp(-s * sampling.delay.to_double()) / (T * s * s);
  const Complex loop = make_wave_law(wave, T).response(std::exp(s * T)) * k;
  const Complex Z =
      r.impedance + r.actuation * loop * r.sensor_path / (1.0 + loop * r.blocked_motion);
  return (s * Z).real();
}

TEST(WaveDrive, renders_the_spring_in_series_with_line_and_inductance) {
  // Averaging and hold delay a wave by T/2 each: of a line with round trip T + t_d stays the
  // stiffness 2 b_w/(T + t_d),
  //   1/K_felt = 1/K + (T + t_d)/(2 b_w) + L_m/K_t^2     (R_m cancelled).
  const Device device = make_wave_display(1);
  for (const Rational& delay : {Rational(0), Rational(1, 2000)}) {
    const Sampling sampling{Rational(1, 1000), delay};
    const double round_trip = 1e-3 + delay.to_double();
    for (const double K : {0.02, 0.5, 5.0, 1e6}) {
      const double felt = 1 / (1 / K + round_trip / (2 * b_w) + L_m / (K_t * K_t));
      const WaveController wave = make_wave_controller(device, WaveWall{K, 0});
      // 0.02 Hz: the line's own w T, and the wall against b_w w, come squared: 1e-4 at most here.
      EXPECT_NEAR(find_rendered_stiffness(device, wave, sampling, 0.02), felt, 1e-4 * felt) << K;
    }
  }
}

TEST(WaveDrive, what_is_left_of_the_winding_resistance_lets_the_wall_give_way) {
  // A damper K_t^2/(R_m - R_c) in series with the wall: held down, it relaxes.
  const Device device = make_wave_display(0.9);
  const WaveController wave = make_wave_controller(device, WaveWall{0.5, 0});
  const double creep = K_t * K_t / (0.1 * R_m);
  const double felt = 1 / (1 / 0.5 + 1e-3 / (2 * b_w) + L_m / (K_t * K_t));
  const double corner = felt / creep / (2 * pi);  // [Hz]
  EXPECT_NEAR(corner, 20.26, 0.01);
  for (const double share : {0.01, 0.1}) {
    const double omega = 2 * pi * share * corner;
    // Re{s Z} of spring and damper in series, beside the rotor's inertia.
    const double yielding = felt / (1 + std::pow(felt / (creep * omega), 2));
    const double expected = yielding - J * omega * omega;
    // w T and L_m w/R come squared: 2e-4 at most.
    EXPECT_NEAR(find_rendered_stiffness(device, wave, {}, share * corner), expected,
                2e-3 * yielding);
  }
}

struct Loop {
  Plant plant;
  Sampling sampling;
  WaveController wave;
  SampledPlant sampled;
  DiscreteStateSpace law;
  Eigen::MatrixXd matrix;

  Loop(const Device& device, const Operator& held_by, const Rational& delay,
       const WaveEnvironment& environment)
      : plant(build_plant(build_device_network(device, held_by))),
        sampling{Rational(1, 1000), delay},
        wave(make_wave_controller(device, environment)),
        sampled(sample_plant(plant, sampling)),
        law(make_wave_law(wave, 1e-3)),
        matrix(build_loop_matrix(sampled, law)) {}

  TimeRun run(EngineKind engine = EngineKind::exact) const {
    SimulationOptions options;
    options.duration = Rational(80, 1000);
    options.initial_velocity = 10;
    options.initial_position = 0.02;
    options.external_effort = 1e-4;
    options.engine = engine;
    return simulate(plant, {}, wave, sampling, options);
  }
};

const MassSpringDamper hand{.inertia = 2e-6, .damping = 1e-5, .stiffness = 0.3, .resonators = {}};

double find_largest(const std::vector<double>& column) {
  double largest = 0;
  for (const double value : column) largest = std::max(largest, std::abs(value));
  return largest;
}

TEST(WaveLoop, powers_of_the_loop_matrix_are_the_simulated_run) {
  for (const double cancelled : {0.0, 0.9}) {
    for (const Operator& held_by : {Operator{FreeOperator{}}, Operator{hand}}) {
      for (const Rational& delay : {Rational(0), Rational(3, 10000), Rational(25, 10000)}) {
        const Loop loop(make_wave_display(cancelled, 10e3), held_by, delay, WaveWall{0.5, 1e-4});
        SimulationOptions options;
        options.duration = Rational(80, 1000);
        options.initial_velocity = 10;
        const TimeRun run = simulate(loop.plant, {}, loop.wave, loop.sampling, options);
        Eigen::VectorXd z = Eigen::VectorXd::Zero(loop.matrix.rows());
        const Eigen::Index n = loop.plant.states();
        z.head(n) = loop.plant.initial_state(0, 10);
        z(n) = loop.sampled.sense * z.head(n);  // the first sample is no wave
        const auto& measured = run.trace.column("measured_wave_integral");
        const double largest = find_largest(measured);
        EXPECT_EQ(measured.front(), 0) << "the wave's integral starts at zero";
        for (const double y : measured) {
          // Two orders of the same exact steps, eighty times.
          ASSERT_NEAR(loop.sampled.sense * z.head(n), y, 1e-11 * largest) << cancelled;
          z = loop.matrix * z;
        }
      }
    }
  }
}

TEST(WaveLoop, a_run_starts_where_it_was_told_and_the_environment_with_it) {
  const Loop loop(make_wave_display(), hand, 0, WaveWall{0.5, 0, true});
  const TimeRun run = loop.run();
  EXPECT_NEAR(run.trace.column("position").front(), 0.02, 1e-15);
  EXPECT_NEAR(run.trace.column("velocity").front(), 10, 1e-12);
  EXPECT_LT(run.trace.column("command").front(), 0) << "the wall is entered from the start";
}

TEST(WaveLoop, the_ledger_closes_and_the_engines_agree) {
  for (const double cancelled : {0.0, 0.9}) {
    for (const WaveWall& wall : {WaveWall{0.5, 1e-4}, WaveWall{2, 0, true}}) {
      const Loop loop(make_wave_display(cancelled, 10e3), hand, Rational(3, 10000), wall);
      const TimeRun exact = loop.run();
      const double moved = std::max(exact.energy.stored_initially, exact.energy.dissipated);
      EXPECT_NEAR(exact.energy.residual, 0, 1e-12 * moved) << cancelled;
      for (const EngineKind engine : {EngineKind::cvode, EngineKind::odeint}) {
        const TimeRun other = loop.run(engine);
        for (const char* name : {"position", "measured_wave_integral"}) {
          const auto& wanted = exact.trace.column(name);
          const auto& found = other.trace.column(name);
          ASSERT_EQ(found.size(), wanted.size());
          for (std::size_t k = 0; k < wanted.size(); ++k) {
            // A millionth, as in the engines' contract.
            ASSERT_NEAR(found[k], wanted[k], 1e-6 * find_largest(wanted)) << name << ' ' << k;
          }
        }
        EXPECT_NEAR(other.energy.residual, 0, 1e-6 * moved);
      }
    }
  }
}

TEST(WaveLoop, takes_energy_from_every_unilateral_contact) {
  // Thrown at the wall the rotor comes back slower, however hard the wall; from the position the
  // same walls throw it back faster.
  for (const double K : {0.1, 1.0, 30.0}) {
    const Loop loop(make_wave_display(0.9, 10e3), FreeOperator{}, 0, WaveWall{K, 0, true});
    SimulationOptions options;
    options.duration = Rational(60, 1000);
    options.initial_velocity = 20;
    options.initial_position = -0.1;
    const TimeRun run = simulate(loop.plant, {}, loop.wave, loop.sampling, options);
    EXPECT_LE(find_largest(run.trace.column("velocity")), 20) << K;
  }
}

}  // namespace
}  // namespace gyrator
