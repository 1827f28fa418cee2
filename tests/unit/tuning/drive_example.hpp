#pragma once

// A motor, its amplifier and a circuit in closed form, beside the network that the product uses:
// what a bench would measure of them with the shaft free.

#include "gyrator/core/random_stream.hpp"
#include "gyrator/passivity/verdict.hpp"
#include "gyrator/tuning/measured_verdict.hpp"

#include <cmath>
#include <complex>
#include <numbers>
#include <vector>

namespace gyrator::tuning_example {

struct MotorDrive {
  double K = 0.05, R = 1.5, L = 0.5e-3, J = 2e-5, b = 1e-4;
  double bandwidth_hz = 1500;
  double R1 = 5, C = 2200e-6;  // of an RC branch
  double cancelled = 0;        // of a voltage drive
};

inline PassivityModel make_model(const MotorDrive& d, DriveMode mode, double stiffness,
                                 double damping) {
  PassivityModel model;
  model.device.mechanics.inertia = d.J;
  model.device.mechanics.damping = d.b;
  model.device.drive.motor = Motor{d.K, d.R, d.L};
  if (mode == DriveMode::current) {
    model.device.drive.amplifier = CurrentAmplifier{d.bandwidth_hz};
    model.device.drive.damping = {RcDamping{d.R1, d.C}};
  } else {
    model.device.drive.amplifier = VoltageAmplifier{d.bandwidth_hz};
    if (d.cancelled > 0) model.device.drive.damping = {ResistanceCancellation{d.cancelled, {}}};
  }
  model.controller.law = VirtualWall{stiffness, damping};
  return model;
}

// v, i and w for u = 1: amplifier G, motor Z_w i = v - K w, free shaft K i = (J s + b) w.
inline Tone make_tone(const MotorDrive& d, DriveMode mode, bool damped, double f, double delay) {
  const std::complex<double> s(0, 2 * std::numbers::pi * f);
  const std::complex<double> G =
      std::exp(-s * delay) / (1.0 + s / (2 * std::numbers::pi * d.bandwidth_hz));
  const std::complex<double> load = d.J * s + d.b;
  const std::complex<double> motor = d.R + d.L * s + d.K * d.K / load;
  std::complex<double> i, v;
  if (mode == DriveMode::current) {
    i = damped ? G / (1.0 + motor / (d.R1 + 1.0 / (d.C * s))) : G;
    v = motor * i;
  } else {  // v = G u + R_c i
    i = G / (motor - (damped ? d.cancelled : 0.0));
    v = motor * i;
  }
  Tone tone;
  tone.frequency_hz = f;
  tone.command = {1, 0};
  tone.current = {i, 0};
  tone.voltage = {v, 0};
  tone.velocity = {d.K * i / load, 0};
  return tone;
}

inline DriveMeasurement measure(const MotorDrive& d, DriveMode mode, double delay = 0) {
  DriveMeasurement m{mode, delay, {}, {}};
  for (double f = 1; f < 1700; f *= 1.6) {
    m.bare.push_back(make_tone(d, mode, false, f, delay));
    m.damped.push_back(make_tone(d, mode, true, f, delay));
  }
  return m;
}

// So much relative noise on every amplitude, known to the measurement.
inline DriveMeasurement with_noise(DriveMeasurement m, double share, std::uint64_t seed) {
  RandomStream random(seed, 7);
  for (auto* tones : {&m.bare, &m.damped})
    for (Tone& tone : *tones)
      for (Phasor* p : {&tone.current, &tone.voltage, &tone.velocity}) {
        p->deviation = share * std::abs(p->value);
        p->value += p->deviation * std::complex<double>(random.normal(), random.normal());
      }
  return m;
}

}  // namespace gyrator::tuning_example
