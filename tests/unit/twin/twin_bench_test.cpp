#include "gyrator/twin/twin_bench.hpp"

#include "gyrator/circuits/descriptor.hpp"
#include "gyrator/core/error.hpp"

#include <cmath>
#include <complex>
#include <numbers>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "unit/twin/twin_models.hpp"

namespace gyrator {
namespace {

using Complex = std::complex<double>;
constexpr double tick = SimulatedAmplifier::tick;

// Amplitude and phase of a signal against sin(2 pi f t): its Fourier sum over whole periods.
Complex find_phasor(const std::vector<double>& signal, const Capture& capture, double f) {
  Complex sum = 0;
  for (std::size_t k = 0; k < signal.size(); ++k) {
    const double t = capture.start + static_cast<double>(k) * capture.period;
    sum += signal[k] * std::polar(1.0, -2 * std::numbers::pi * f * t);
  }
  return Complex(0, 2) * sum / static_cast<double>(signal.size());
}

// What the samples of a signal of the network hold of a sine that is held from tick to tick and
// delayed, with the aliases that the hold makes and the sampler folds back:
//   sum over n of G(s_n) e^(-s_n delay) (1 - e^(-s_n T))/(s_n T),   s_n = j (w + n 2 pi/T)
Complex predict(const Device& device, double f, double delay, bool velocity, double& tail) {
  const DeviceNetwork network = build_device_network(device, FreeOperator{}, 1);
  const NetworkEquations equations(network.network);
  const LinearForm form =
      velocity ? equations.across(network.sensed) : equations.through(*network.drive.motor_ammeter);
  Complex sum = 0;
  constexpr int most = 100;
  double last = 0;
  for (int n = -most; n <= most; ++n) {
    const Complex s(0, 2 * std::numbers::pi * (f + n / tick));
    const Eigen::VectorXcd x = solve_descriptor(equations.descriptor(), s).col(network.command);
    const Complex response = (form.x * x)(0);
    const Complex term = response * std::exp(-s * delay) * (1.0 - std::exp(-s * tick)) / (s * tick);
    sum += term;
    last = std::abs(term);
  }
  // Each term falls as 1/n² at least: what is left of both ends.
  tail = 2 * last * most;
  return sum;
}

TEST(TwinBench, ASineMeetsTheModelsResponse) {
  const struct {
    const char* name;
    DriveMode mode;
    std::vector<std::pair<const char*, double>> settings;
  } circuits[] = {
      {"current", DriveMode::current, {}},
      {"rc",
       DriveMode::current,
       {{"damping_resistance", 5}, {"damping_capacitance", 2.2e-3}, {"damping_connected", 1}}},
      {"cancelled", DriveMode::voltage, {{"cancellation_resistance", 1.1}}},
      {"back-EMF", DriveMode::current, {{"back_emf_damping", 4e-4}, {"back_emf_resistance", 1.45}}},
      {"all",
       DriveMode::voltage,
       {{"damping_resistance", 5},
        {"damping_capacitance", 1e-3},
        {"damping_connected", 1},
        {"cancellation_resistance", 0.8},
        {"back_emf_damping", 2e-4},
        {"back_emf_resistance", 1.4}}},
  };
  for (const auto& circuit : circuits) {
    TwinDevice twin = make_plain_twin();
    twin.delay = 0.23e-3;
    SimulatedAmplifier amplifier(twin);
    TwinBench bench(amplifier);
    for (const auto& [name, value] : circuit.settings) bench.write_setting(name, value);
    TwinSettings settings = amplifier.settings();
    settings.enable = true;
    settings.drive_mode = circuit.mode;
    Device device = make_plant_device(twin, settings, 1.5);
    // The rails are not reached; what they leak is no part of the model.
    if (auto* current = std::get_if<CurrentAmplifier>(&device.drive.amplifier))
      current->voltage_limit.reset();
    for (const double f : {10.0, 50.0, 400.0}) {
      const double amplitude = 0.1;
      const Capture capture =
          bench.run({ExcitationKind::sine, circuit.mode, amplitude, 0, f, 0, 7}, {6.5, tick, 4000});
      for (const bool velocity : {false, true}) {
        double tail = 0;
        const Complex expected = amplitude * predict(device, f, twin.delay, velocity, tail);
        const Complex measured =
            find_phasor(velocity ? capture.velocity : capture.current, capture, f);
        // After 6.5 s of the slowest pole, b/J = 5/s, and the aliases that were not counted.
        const double tolerance =
            amplitude * tail + 2 * std::exp(-6.5 * 5) + 1e-9 * std::abs(expected);
        EXPECT_NEAR(std::abs(measured - expected), 0, tolerance)
            << circuit.name << " " << f << " Hz, " << (velocity ? "velocity" : "current") << " "
            << expected << " " << measured;
        EXPECT_LT(tolerance, 2e-3 * std::abs(expected)) << circuit.name << " " << f;
      }
    }
  }
}

TwinDevice make_noisy_twin() {
  TwinDevice twin = make_plain_twin();
  twin.device.mechanics.coulomb_friction = 1e-3;
  twin.thermal = {8, 3};
  twin.noise = {1e-4, 2e-3, 1e-2, 0.05, 1e-4};
  twin.position_quantum = 1e-3;
  twin.current_step = 1e-3;
  twin.voltage_step = 5e-3;
  return twin;
}

const Excitation chirp{ExcitationKind::chirp, DriveMode::current, 0.3, 0, 5, 200, 0.5};

TEST(TwinBench, TheSameRunTwiceGivesTheSameCapture) {
  SimulatedAmplifier first(make_noisy_twin());
  SimulatedAmplifier second(make_noisy_twin());
  TwinBench bench(first);
  TwinBench other(second);
  for (int i = 0; i < 10; ++i) (void)other.read_setting("current");  // reading draws its own noise
  const Capture a = bench.run(chirp, {0.01, 2 * tick, 2000});
  const Capture b = other.run(chirp, {0.01, 2 * tick, 2000});
  EXPECT_EQ(a.command, b.command);
  EXPECT_EQ(a.current, b.current);
  EXPECT_EQ(a.voltage, b.voltage);
  EXPECT_EQ(a.velocity, b.velocity);
  EXPECT_EQ(a.position, b.position);
  TwinDevice reseeded = make_noisy_twin();
  reseeded.seed = 2;
  SimulatedAmplifier third(reseeded);
  EXPECT_NE(TwinBench(third).run(chirp, {0.01, 2 * tick, 2000}).current, a.current);
}

TEST(TwinBench, NoiseAndStepsAreThoseAskedFor) {
  TwinDevice quiet = make_noisy_twin();
  quiet.noise = {1e-4, 0, 0, 0, 0};
  quiet.position_quantum = quiet.current_step = quiet.voltage_step = 0;
  SimulatedAmplifier noisy_amplifier(make_noisy_twin());
  SimulatedAmplifier quiet_amplifier(quiet);
  const Capture noisy = TwinBench(noisy_amplifier).run(chirp, {0, tick, 4000});
  const Capture pure = TwinBench(quiet_amplifier).run(chirp, {0, tick, 4000});
  const auto expect_spread = [](const std::vector<double>& a, const std::vector<double>& b,
                                double sigma, double step) {
    double sum = 0;
    for (std::size_t k = 0; k < a.size(); ++k) {
      sum += (a[k] - b[k]) * (a[k] - b[k]);
      if (step > 0) {
        EXPECT_NEAR(a[k], step * std::round(a[k] / step), 1e-12);
      }
    }
    const double expected = std::sqrt(sigma * sigma + step * step / 12);
    // The spread of 4000 normal numbers is known to 1/sqrt(8000), four times that is never passed.
    EXPECT_NEAR(std::sqrt(sum / static_cast<double>(a.size())), expected,
                4 / std::sqrt(8000.0) * expected);
  };
  expect_spread(noisy.current, pure.current, 2e-3, 1e-3);
  expect_spread(noisy.voltage, pure.voltage, 1e-2, 5e-3);
  expect_spread(noisy.velocity, pure.velocity, 0.05, 0);
  expect_spread(noisy.position, pure.position, 1e-4, 1e-3);
}

TEST(TwinBench, SamplesLieAtTheirInstants) {
  SimulatedAmplifier amplifier(make_plain_twin());
  amplifier.advance(0.0123);
  const Excitation ramp{ExcitationKind::sine, DriveMode::current, 0.1, 0, 40, 0, 0.1};
  const Capture capture = TwinBench(amplifier).run(ramp, {3e-3, 3 * tick, 400});
  ASSERT_EQ(capture.command.size(), 400U);
  for (std::size_t k = 0; k < 400; ++k) {
    const double t = static_cast<double>(30 + 3 * k) / 10000;
    EXPECT_EQ(capture.command[k], compute_command(ramp, t)) << k;
  }
}

TEST(TwinBench, ACaptureOutlastsItsExcitation) {
  SimulatedAmplifier amplifier(make_plain_twin());
  const Excitation pulse{ExcitationKind::dc, DriveMode::current, 0, 0.5, 0, 0, 0.05};
  const Capture capture = TwinBench(amplifier).run(pulse, {0, tick, 4000});
  ASSERT_EQ(capture.velocity.size(), 4000U);
  // From 50 ms on the shaft coasts, at the rate b/J = 5/s.
  EXPECT_NEAR(std::log(capture.velocity[1000] / capture.velocity[3000]), 5 * 0.2, 1e-3);
  EXPECT_FALSE(amplifier.settings().enable);
}

TEST(TwinBench, WhatTheAmplifierCannotDoIsRefusedBeforeAnythingMoves) {
  SimulatedAmplifier amplifier(make_plain_twin());
  TwinBench bench(amplifier);
  const auto refuse = [&](const Excitation& excitation, const CaptureRequest& request) {
    try {
      bench.run(excitation, request);
      ADD_FAILURE() << describe(excitation);
    } catch (const Error& error) {
      EXPECT_EQ(error.code(), ErrorCode::bad_input) << error.what();
    }
  };
  refuse({ExcitationKind::dc, DriveMode::current, 0, 4, 0, 0, 1}, {0, tick, 10});
  refuse({ExcitationKind::sine, DriveMode::voltage, 20, 10, 10, 0, 1}, {0, tick, 10});
  refuse({ExcitationKind::sine, DriveMode::current, 1, 0, 10, 0, -1}, {0, tick, 10});
  refuse(chirp, {0, tick, 4001});
  refuse(chirp, {0, 1.5 * tick, 100});
  refuse(chirp, {0.5 * tick, tick, 100});
  refuse(chirp, {0, std::nan(""), 100});
  EXPECT_EQ(amplifier.ticks(), 0);
}

TEST(TwinBench, AFaultEndsTheRunWithTheDriveOff) {
  SimulatedAmplifier amplifier(make_plain_twin());
  TwinBench bench(amplifier);
  bench.write_setting("velocity_limit", 20);
  try {
    bench.run({ExcitationKind::dc, DriveMode::current, 0, 1, 0, 0, 1}, {0, tick, 100});
    FAIL() << "no fault";
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::device);
    EXPECT_NE(std::string(error.what()).find("overspeed"), std::string::npos);
  }
  EXPECT_FALSE(amplifier.settings().enable);
}

}  // namespace
}  // namespace gyrator
