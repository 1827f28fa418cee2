#pragma once

#include "gyrator/amplifiers/experiment.hpp"
#include "gyrator/core/error.hpp"
#include "gyrator/core/random_stream.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <string>
#include <vector>

namespace gyrator {

/// What a MotorBench hides, in SI units.
struct BenchMotor {
  double resistance = 2.06;  // at 298.15 K
  double inductance = 0.238e-3;
  double torque_constant = 23.5e-3;
  double inertia = 1.07e-6;
  double damping = 1.2e-6;
  double coulomb_friction = 3e-4;
  double bandwidth_hz = 1000;
  double delay = 120e-6;
  double temperature = 318.15;  // of the winding at the start [K]
  double thermal_resistance = 10, thermal_capacity = 5;
  double current_noise = 0, voltage_noise = 0, velocity_noise = 0;  // rms
  double current_quantum = 0, voltage_quantum = 0, position_quantum = 0;
  double current_offset = 0, voltage_offset = 0;  // of the sensors
  double current_limit = 5, voltage_limit = 24, velocity_limit = 0;
  std::uint64_t seed = 1;
};

/// What a MotorBench offers.
struct BenchOffer {
  bool command = true, voltage = true, velocity = true, position = true, temperature = true;
  std::vector<DriveMode> modes{DriveMode::current, DriveMode::voltage};
  double shortest_period = 1e-4;
  int most_samples = 4000;
  bool quantum_known = true;  // of the encoder
};

/// A motor behind an amplifier, written for the tests without anything of the library's own: the
/// equations
///   v = R i + L di/dt + K w,   J dw/dt = K i - b w - f_c sgn w,   dy/dt = w_b (u(t - d) - y)
/// by Runge-Kutta steps of at most 5 us that end at the delayed command's jumps; y is the
/// current (current mode) or the voltage (voltage mode).
class MotorBench : public Bench {
 public:
  MotorBench(const BenchMotor& motor, const BenchOffer& offer = {})
      : motor_(motor), offer_(offer), noise_(motor.seed, 1), temperature_(motor.temperature) {}

  BenchLimits limits() const override {
    BenchLimits limits;
    limits.shortest_period = offer_.shortest_period;
    limits.most_samples = offer_.most_samples;
    limits.largest_current = motor_.current_limit;
    limits.largest_voltage = motor_.voltage_limit;
    limits.largest_velocity = motor_.velocity_limit;
    limits.position_quantum = offer_.quantum_known ? motor_.position_quantum : 0;
    limits.modes = offer_.modes;
    limits.kinds = {ExcitationKind::dc, ExcitationKind::step, ExcitationKind::sine,
                    ExcitationKind::chirp, ExcitationKind::prbs};
    return limits;
  }

  Capture run(const Excitation& excitation, const CaptureRequest& request) override {
    ++runs;
    seconds += excitation.duration;
    check_request(excitation, request);
    Capture capture;
    capture.start = request.start;
    capture.period = request.period;
    if (offer_.temperature) capture.winding_temperature_before = temperature_;
    const int stride = static_cast<int>(std::lround(request.period / tick));
    const int first = static_cast<int>(std::lround(request.start / tick));
    const int last = static_cast<int>(std::lround(excitation.duration / tick));
    mode_ = excitation.mode;
    output_ = 0;
    current_ = mode_ == DriveMode::current ? 0 : current_;
    history_.assign(8, 0.0);
    for (int k = 0; k < last; ++k) {
      const bool kept =
          k >= first && (k - first) % stride == 0 && (k - first) / stride < request.samples;
      const double u = compute_command(excitation, k * tick);
      // Kept at the instant itself, before the new command acts.
      if (kept) keep(capture, u);
      step_tick(u);
    }
    coast(0.01);
    if (offer_.temperature) capture.winding_temperature_after = temperature_;
    return capture;
  }

  std::optional<double> winding_temperature() override {
    return offer_.temperature ? std::optional(temperature_) : std::nullopt;
  }
  void wait(double duration) override {
    coast(duration);
    seconds += duration;
  }
  bool has_setting(std::string_view name) const override {
    return settings.contains(std::string(name));
  }
  SettingRange setting_range(std::string_view) const override { return {0, 1e9, 0}; }
  double read_setting(std::string_view name) override { return settings.at(std::string(name)); }
  void write_setting(std::string_view name, double value) override {
    settings[std::string(name)] = value;
    writes.push_back({std::string(name), value});
  }

  double temperature() const { return temperature_; }

  std::map<std::string, double> settings;
  std::vector<std::pair<std::string, double>> writes;
  int runs = 0;
  double seconds = 0;        // of device time asked for
  double peak_velocity = 0;  // reached [rad/s]
  double peak_current = 0;   // [A]
  double peak_voltage = 0;   // [V]
  int fails_at = -1;         // the run that ends with a fault

 private:
  struct State {
    double current, output, velocity, position;
  };

  void check_request(const Excitation& excitation, const CaptureRequest& request) const {
    const double limit =
        excitation.mode == DriveMode::current ? motor_.current_limit : motor_.voltage_limit;
    if (find_peak(excitation) > limit * (1 + 1e-12))
      throw Error(ErrorCode::bad_input, "bench", "more than the limit: " + describe(excitation));
    if (request.samples > offer_.most_samples ||
        request.start + (request.samples - 1) * request.period > excitation.duration)
      throw Error(ErrorCode::bad_input, "bench", "a capture that cannot be");
    if (runs == fails_at) throw Error(ErrorCode::device, "bench", "overcurrent");
  }

  double resistance() const { return motor_.resistance * (1 + 0.00393 * (temperature_ - 298.15)); }

  double voltage(const State& s, double u) const {
    if (mode_ == DriveMode::voltage) return s.output;
    return resistance() * s.current +
           motor_.inductance * 2 * std::numbers::pi * motor_.bandwidth_hz * (u - s.current) +
           motor_.torque_constant * s.velocity;
  }

  State slope(const State& s, double u, double friction) const {
    const double w_b = 2 * std::numbers::pi * motor_.bandwidth_hz;
    State d{};
    if (mode_ == DriveMode::current) {
      d.current = w_b * (u - s.current);
    } else {
      d.output = w_b * (u - s.output);
      d.current = (s.output - resistance() * s.current - motor_.torque_constant * s.velocity) /
                  motor_.inductance;
    }
    d.velocity =
        stuck_ ? 0
               : (motor_.torque_constant * s.current - motor_.damping * s.velocity - friction) /
                     motor_.inertia;
    d.position = s.velocity;
    return d;
  }

  static State add(const State& a, const State& b, double h) {
    return {a.current + h * b.current, a.output + h * b.output, a.velocity + h * b.velocity,
            a.position + h * b.position};
  }

  void step(double h, double u) {
    const State s{current_, output_, velocity_, position_};
    const double torque = motor_.torque_constant * s.current;
    stuck_ = s.velocity == 0 && std::abs(torque) <= motor_.coulomb_friction;
    const double side = s.velocity != 0 ? s.velocity : torque;
    const double friction = std::copysign(motor_.coulomb_friction, side);
    const State k1 = slope(s, u, friction);
    const State k2 = slope(add(s, k1, h / 2), u, friction);
    const State k3 = slope(add(s, k2, h / 2), u, friction);
    const State k4 = slope(add(s, k3, h), u, friction);
    State n = s;
    n = add(n, k1, h / 6);
    n = add(n, k2, h / 3);
    n = add(n, k3, h / 3);
    n = add(n, k4, h / 6);
    if (s.velocity * n.velocity < 0) n.velocity = 0;
    current_ = n.current;
    output_ = n.output;
    velocity_ = n.velocity;
    position_ = n.position;
  }

  void step_segment(double length, double u) {
    if (length < 1e-12) return;
    const int parts = std::max(1, static_cast<int>(std::ceil(length / 5e-6)));
    for (int i = 0; i < parts; ++i) step(length / parts, u);
  }

  void step_tick(double u) {
    history_.insert(history_.begin(), u);
    history_.pop_back();
    const int whole = static_cast<int>(std::floor(motor_.delay / tick + 1e-9));
    const double part = std::max(0.0, motor_.delay - whole * tick);
    step_segment(part, history_[static_cast<std::size_t>(whole) + 1]);
    step_segment(tick - part, history_[static_cast<std::size_t>(whole)]);
    warm(tick);
    peak_velocity = std::max(peak_velocity, std::abs(velocity_));
    peak_current = std::max(peak_current, std::abs(current_));
    peak_voltage =
        std::max(peak_voltage, std::abs(voltage({current_, output_, velocity_, position_},
                                                history_[static_cast<std::size_t>(whole)])));
  }

  void warm(double h) {
    const double heat =
        resistance() * current_ * current_ - (temperature_ - 298.15) / motor_.thermal_resistance;
    temperature_ += h * heat / motor_.thermal_capacity;
  }

  // With the drive off nothing flows.
  void coast(double duration) {
    current_ = 0;
    output_ = 0;
    const double h = 1e-3;
    for (double t = 0; t < duration; t += h) {
      const double slower =
          velocity_ -
          h * (motor_.damping * velocity_ + std::copysign(motor_.coulomb_friction, velocity_)) /
              motor_.inertia;
      velocity_ = slower * velocity_ > 0 ? slower : 0;
      position_ += h * velocity_;
      warm(h);
    }
  }

  static double quantize(double value, double quantum) {
    return quantum > 0 ? quantum * std::floor(value / quantum + 0.5) : value;
  }

  void keep(Capture& capture, double u) {
    const int whole = static_cast<int>(std::floor(motor_.delay / tick + 1e-9));
    // u(t - d) just before the instant.
    const double acting = history_[static_cast<std::size_t>(whole)];
    const State s{current_, output_, velocity_, position_};
    if (offer_.command) capture.command.push_back(u);
    capture.current.push_back(
        quantize(current_ + motor_.current_offset + motor_.current_noise * noise_.normal(),
                 motor_.current_quantum));
    if (offer_.voltage)
      capture.voltage.push_back(quantize(
          voltage(s, acting) + motor_.voltage_offset + motor_.voltage_noise * noise_.normal(),
          motor_.voltage_quantum));
    if (offer_.velocity)
      capture.velocity.push_back(velocity_ + motor_.velocity_noise * noise_.normal());
    if (offer_.position) capture.position.push_back(quantize(position_, motor_.position_quantum));
  }

  BenchMotor motor_;
  BenchOffer offer_;
  const double tick = offer_.shortest_period;
  RandomStream noise_;
  DriveMode mode_ = DriveMode::current;
  std::vector<double> history_ = std::vector<double>(8, 0.0);
  double temperature_, current_ = 0, output_ = 0, velocity_ = 0, position_ = 0;
  bool stuck_ = false;
};

}  // namespace gyrator
