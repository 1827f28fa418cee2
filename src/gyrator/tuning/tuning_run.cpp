#include "gyrator/tuning/tuning_run.hpp"

#include "gyrator/core/error.hpp"
#include "gyrator/core/interrupt.hpp"
#include "gyrator/tuning/step_images.hpp"

#include <algorithm>
#include <cmath>
#include <exception>
#include <numbers>

#include <fmt/core.h>

namespace gyrator {
namespace {

using std::numbers::pi;

// Share of what is left of the winding that stays at each step of a cancellation.
constexpr double kept_per_step = 0.6;
// Steps of an RC branch, from its largest resistance down to the chosen one.
constexpr int rc_steps = 3;
// Less than this of what should be left of the winding is a sign of instability to come, and so is
// a damping that is off by more than this share.
constexpr double least_remaining = 0.5;
constexpr double largest_deviation = 0.5;
// The model is of another motor where a slow sine shows so much reactance, as a share of the
// winding's resistance, or so much more or less inertia.
constexpr double largest_reactance = 0.3;
constexpr double largest_load_ratio = 1.6;
// What is left of the motion must not grow, by more than what noise does to the number.
constexpr double growth_allowed = 0.5;  // [1/s]

// Puts settings back unless told that they may stay.
class SettingsGuard {
 public:
  explicit SettingsGuard(Bench& bench) : bench_(bench) {
    for (const std::string& name : tuned_settings())
      if (bench.has_setting(name)) found_.push_back({name, bench.read_setting(name)});
  }
  ~SettingsGuard() {
    if (kept_) return;
    try {
      put_back();
    } catch (const std::exception&) {
      // The link is gone: the session behind the bench says so, and its journal has the values.
    }
  }
  SettingsGuard(const SettingsGuard&) = delete;
  SettingsGuard& operator=(const SettingsGuard&) = delete;
  SettingsGuard(SettingsGuard&&) = delete;
  SettingsGuard& operator=(SettingsGuard&&) = delete;

  // Switches first, so that a circuit is never closed on half of its values.
  void put_back() {
    for (const Setting& setting : found_) bench_.write_setting(setting.name, setting.value);
    kept_ = true;
  }
  void keep() { kept_ = true; }

 private:
  Bench& bench_;
  std::vector<Setting> found_;
  bool kept_ = false;
};

class Tuner {
 public:
  Tuner(Bench& bench, const PassivityModel& identified, const TuningOptions& options)
      : bench_(bench), options_(options), limits_(bench.limits()), mode_(mode_of(circuit())) {
    run_.model = identified;
    check();
    frequencies_ =
        spread_frequencies(limits_, options.lowest_hz, options.highest_hz, options.frequencies);
  }

  TuningRun run() {
    SettingsGuard guard(bench_);
    switch_off();
    run_.measurement.mode = mode_;
    run_.measurement.delay = run_.model.sampling.delay.to_double();
    set_device(bare_device());
    run_.measurement.bare = measure(frequencies_);
    if (const auto contradiction = find_contradiction()) {
      run_.outcome = TuningOutcome::stopped;
      run_.explanation = *contradiction;
      guard.put_back();
      return run_;
    }
    follow_winding(run_.measurement.bare);
    run_.choice = choose_settings(run_.model, options_.target, range_of());
    if (!run_.choice.reaches_wall && !options_.target.cancellation) {
      run_.outcome = TuningOutcome::unreachable;
      run_.explanation = "no setting of the amplifier carries the wall with its margin";
      guard.put_back();
      return run_;
    }
    if (!raise()) {
      run_.outcome = TuningOutcome::stopped;
      run_.explanation = run_.steps.back().remark;
      guard.put_back();
      return run_;
    }
    run_.measurement.damped = measure(frequencies_);
    follow_winding(run_.measurement.damped);
    run_.verdict = judge_measured(run_.model, run_.measurement);
    const bool passive = run_.verdict->passive || options_.target.cancellation.has_value();
    if (!passive) {
      run_.outcome = TuningOutcome::not_passive;
      run_.explanation = "by the measured response the wall is not passive";
      guard.put_back();
      return run_;
    }
    if (!watch()) {
      run_.outcome = TuningOutcome::stopped;
      run_.explanation = run_.steps.back().remark;
      guard.put_back();
      return run_;
    }
    run_.outcome = TuningOutcome::reached;
    guard.keep();
    return run_;
  }

 private:
  TuningCircuit circuit() const { return options_.target.circuit; }

  void check() const {
    const auto need = [&](const char* name) {
      if (!bench_.has_setting(name))
        throw Error(
            ErrorCode::bad_input, name,
            fmt::format("the amplifier has no such setting, and {} needs it", name_of(circuit())));
    };
    if (circuit() == TuningCircuit::rc) {
      need("damping_resistance");
      need("damping_capacitance");
    } else {
      need("cancellation_resistance");
    }
    if (std::find(limits_.modes.begin(), limits_.modes.end(), mode_) == limits_.modes.end())
      throw Error(ErrorCode::bad_input, "drive_mode",
                  fmt::format("the amplifier has no {} mode, and {} needs it", name_of(mode_),
                              name_of(circuit())));
    const auto& motor = run_.model.device.drive.motor;
    if (!motor || !(motor->resistance > 0) || !(motor->torque_constant > 0))
      throw Error(ErrorCode::bad_input, "motor",
                  "resistance and torque constant are needed: identify the motor first");
    if (!(run_.model.device.mechanics.inertia > 0))
      throw Error(ErrorCode::bad_input, "mechanics/inertia", "missing: identify the motor first");
  }

  void switch_off() {
    for (const std::string& name : tuned_settings())
      if ((name == "damping_connected" || name == "cancellation_resistance" ||
           name == "back_emf_damping") &&
          bench_.has_setting(name))
        bench_.write_setting(name, 0);
  }

  RangeOf range_of() {
    return [this](std::string_view name) { return bench_.setting_range(name); };
  }

  Device bare_device() const {
    Device device = run_.model.device;
    device.drive.damping.clear();
    device.gain.reset();
    if (mode_ == DriveMode::voltage)
      device =
          make_tuned_device(device, TuningCircuit::cancellation, {{"cancellation_resistance", 0}});
    return device;
  }

  // The device whose response bounds the sines.
  void set_device(const Device& device) { present_ = device; }

  // So large that neither current nor speed exceed what is allowed.
  double amplitude_at(double frequency_hz) const {
    const double current = options_.current > 0 ? options_.current : limits_.largest_current / 5;
    const double speed = limits_.largest_velocity > 0 ? limits_.largest_velocity / 4
                                                      : std::numeric_limits<double>::infinity();
    const Motor& motor = *present_.drive.motor;
    const std::complex<double> s(0, 2 * pi * frequency_hz);
    const std::complex<double> load = s * present_.mechanics.inertia + present_.mechanics.damping;
    const double motion = std::abs(load) / motor.torque_constant;  // [A.s/rad]
    const double amperes = std::min(current, speed * motion);
    if (mode_ == DriveMode::current) return amperes;
    const std::complex<double> back_emf = motor.torque_constant * motor.torque_constant / load;
    const std::complex<double> circuit =
        motor.warm_resistance() - cancelled() + s * motor.inductance + back_emf;
    return std::min(amperes * std::abs(circuit), limits_.largest_voltage / 2);
  }

  double cancelled() const {
    for (const Damping& damping : present_.drive.damping)
      if (const auto* c = std::get_if<ResistanceCancellation>(&damping)) return c->resistance;
    return 0;
  }

  std::vector<Tone> measure(const std::vector<double>& frequencies) {
    std::vector<Tone> tones;
    for (const double f : frequencies) tones.push_back(measure(f));
    return tones;
  }

  Tone measure(double frequency_hz) {
    const Tone tone = measure_tone(bench_, mode_, amplitude_at(frequency_hz), frequency_hz);
    time_ += tone.duration;
    return remove_step_images(tone, present_, limits_.shortest_period, run_.measurement.delay);
  }

  // The winding as warm as the lowest sines say.
  double follow_winding(const std::vector<Tone>& tones) {
    Motor& motor = *run_.model.device.drive.motor;
    double sum = 0, weights = 0;
    for (std::size_t i = 0; i < tones.size() && i < 3; ++i) {
      const Tone& tone = tones[i];
      const double error =
          std::hypot(tone.voltage.deviation, motor.torque_constant * tone.velocity.deviation) /
              std::abs(tone.current.value) +
          1e-6;
      const std::complex<double> winding =
          (tone.voltage.value - motor.torque_constant * tone.velocity.value) / tone.current.value;
      sum += winding.real() / (error * error);
      weights += 1 / (error * error);
    }
    const double resistance = sum / weights;
    motor.temperature_rise = (resistance / motor.resistance - 1) / motor.temperature_coefficient;
    present_.drive.motor->temperature_rise = motor.temperature_rise;
    return resistance;
  }

  // What the bare drive did against the model: the back-EMF of the slowest sines, and the inertia.
  std::optional<std::string> find_contradiction() const {
    const Motor& motor = *run_.model.device.drive.motor;
    const Mechanics& mechanics = run_.model.device.mechanics;
    for (std::size_t i = 0; i < 4 && i < run_.measurement.bare.size(); ++i) {
      const Tone& tone = run_.measurement.bare[i];
      const double omega = 2 * pi * tone.frequency_hz;
      const std::complex<double> winding =
          (tone.voltage.value - motor.torque_constant * tone.velocity.value) / tone.current.value;
      const double off = winding.imag() - omega * motor.inductance;
      // What an amplifier samples of L di/dt behind its steps is its own affair.
      const double allowed = largest_reactance * motor.resistance + 0.5 * omega * motor.inductance;
      if (std::abs(off) > allowed) {
        return fmt::format(
            "at {:.3g} Hz the winding seems to have {:.3g} ohm of reactance that is not its "
            "inductance's: the torque constant of the model, {:.4g}, is not this motor's; identify "
            "it",
            tone.frequency_hz, off, motor.torque_constant);
      }
      const double load =
          std::abs(motor.torque_constant * tone.current.value / tone.velocity.value);
      const double modelled =
          std::abs(std::complex<double>(mechanics.damping, omega * mechanics.inertia));
      // Dry friction adds to what slow motion takes.
      const bool is_light = load < modelled / largest_load_ratio;
      const bool is_heavy =
          i > 0 && load > modelled * largest_load_ratio &&
          mechanics.coulomb_friction < 0.2 * motor.torque_constant * std::abs(tone.current.value);
      if (is_light || is_heavy) {
        return fmt::format(
            "at {:.3g} Hz the motor turns as if it had {:.3g} times the model's "
            "inertia; identify it",
            tone.frequency_hz, load / modelled);
      }
    }
    return {};
  }

  void write(const std::vector<Setting>& settings) {
    for (const Setting& setting : settings) bench_.write_setting(setting.name, setting.value);
    if (circuit() == TuningCircuit::rc && bench_.has_setting("damping_connected"))
      bench_.write_setting("damping_connected", 1);
    set_device(make_tuned_device(run_.model.device, circuit(), settings));
  }

  // The settings step by step, the chosen ones last.
  bool raise() {
    if (circuit() == TuningCircuit::rc) {
      const double R = value_of(run_.choice.settings, "damping_resistance");
      const double C = value_of(run_.choice.settings, "damping_capacitance");
      const SettingRange range = bench_.setting_range("damping_resistance");
      const double from = std::max(R, std::min(range.high, 10 * R));
      for (int step = 1; step <= rc_steps; ++step) {
        const double value =
            step == rc_steps ? R : snap(from * std::pow(R / from, step / double(rc_steps)), range);
        if (!take_step({{"damping_resistance", value}, {"damping_capacitance", C}})) return false;
      }
    } else {
      const SettingRange range = bench_.setting_range("cancellation_resistance");
      double now = 0;
      for (int step = 0; step < 100; ++step) {
        const double target = cancellation_target(range);
        const double winding = run_.model.device.drive.motor->warm_resistance();
        // Of what is left, by the register or by measurement, whichever is less.
        const double left = run_.steps.empty()
                                ? winding
                                : std::min(winding - now, run_.steps.back().remaining_resistance);
        const double next = std::min(target, snap(now + (1 - kept_per_step) * left, range, true));
        if (next <= now) break;
        if (!take_step({{"cancellation_resistance", next}})) return false;
        now = next;
      }
    }
    if (run_.steps.empty()) {  // nothing to raise: the bare drive is what was chosen
      if (!take_step(run_.choice.settings)) return false;
    }
    run_.choice.settings = run_.steps.back().settings;
    run_.choice.device = present_;
    run_.model.device = present_;
    return true;
  }

  // With the winding as warm as it is now.
  double cancellation_target(const SettingRange& range) const {
    const double winding = run_.model.device.drive.motor->warm_resistance();
    const double chosen = value_of(run_.choice.settings, "cancellation_resistance");
    const double share = options_.target.cancellation ? std::min(*options_.target.cancellation,
                                                                 options_.target.most_cancellation)
                                                      : options_.target.most_cancellation;
    const double most = snap(share * winding, range, true);
    return options_.target.cancellation ? most : std::min(chosen, most);
  }

  bool take_step(const std::vector<Setting>& settings) {
    write(settings);
    TuningStep step;
    step.settings = settings;
    measure_damping(step);
    measure_decay(step);
    judge(step);
    step.time = time_;
    run_.steps.push_back(step);
    if (options_.on_step) options_.on_step(run_.steps.back());
    return step.stable;
  }

  // Where the circuit damps most: well above the corner of an RC branch, low for a cancellation.
  double damping_frequency() const {
    double f = 10;
    if (circuit() == TuningCircuit::rc) {
      const auto& rc = std::get<RcDamping>(present_.drive.damping.front());
      const double R = rc.resistance + present_.drive.motor->warm_resistance();
      f = 5 / (2 * pi * rc.capacitance * R);
    }
    return std::clamp(f, frequencies_.front(), frequencies_.back());
  }

  void measure_damping(TuningStep& step) {
    // One of the frequencies that were measured bare.
    const double wanted = damping_frequency();
    std::size_t at = 0;
    for (std::size_t i = 1; i < frequencies_.size(); ++i)
      if (std::abs(std::log(frequencies_[i] / wanted)) <
          std::abs(std::log(frequencies_[at] / wanted)))
        at = i;
    step.frequency_hz = frequencies_[at];
    const Tone tone = measure(frequencies_[at]);
    step.winding_resistance = follow_winding({tone});
    const Motor& motor = *run_.model.device.drive.motor;
    const DrivePoint point = find_drive_point(mode_, motor, run_.measurement.bare[at], tone);
    step.measured_damping =
        find_drive_port(mode_, motor.torque_constant, 1, point).impedance.real();
    if (mode_ == DriveMode::voltage)
      step.remaining_resistance = (point.winding + point.source).real();
    PortModel model(present_);
    step.modelled_damping =
        model.at(2 * pi * step.frequency_hz).impedance.real() - present_.mechanics.damping;
    step.remark.clear();
  }

  // The command ends; what is left must fade.
  void measure_decay(TuningStep& step) {
    Excitation push;
    push.kind = ExcitationKind::dc;
    push.mode = mode_;
    push.offset = amplitude_at(step.frequency_hz) / 2;
    push.duration = 0.05;
    CaptureRequest request;
    request.start = push.duration;
    request.samples = std::min(2000, limits_.most_samples);
    request.period =
        limits_.shortest_period * std::ceil(0.2 / (limits_.shortest_period * request.samples));
    run_.ring_down = bench_.run(push, request);
    time_ += push.duration + request.samples * request.period;
    const auto& v = run_.ring_down.velocity;
    const auto energy = [&](std::size_t from, std::size_t to) {
      double sum = 0;
      for (std::size_t k = from; k < to; ++k) sum += v[k] * v[k];
      return sum / static_cast<double>(std::max<std::size_t>(1, to - from));
    };
    const std::size_t n = v.size();
    if (n < 8) return;
    const double early = energy(n / 8, n / 4);
    const double late = energy(7 * n / 8, n);
    // From the middle of the one to the middle of the other.
    const double between = static_cast<double>(n) * (0.9375 - 0.1875) * request.period;
    if (early > 0 && late > 0) step.decay = std::log(early / late) / (2 * between);
  }

  void judge(TuningStep& step) const {
    const double winding = step.winding_resistance;
    if (step.decay < -growth_allowed) {
      step.stable = false;
      step.remark = fmt::format("motion grew by itself, {:.3g} per second, after the command's end",
                                -step.decay);
    } else if (mode_ == DriveMode::voltage) {
      const double expected = winding - cancelled();
      if (!(step.remaining_resistance > least_remaining * expected)) {
        step.stable = false;
        step.remark = fmt::format(
            "{:.4g} ohm is left of the winding where {:.4g} ohm should be: less than {:.0f} %",
            step.remaining_resistance, expected, 100 * least_remaining);
      }
    }
    if (step.stable && std::abs(step.measured_damping - step.modelled_damping) >
                           largest_deviation * std::abs(step.modelled_damping)) {
      step.stable = false;
      step.remark = fmt::format(
          "a damping of {:.4g} was measured where the model has {:.4g}: the "
          "model does not describe this amplifier",
          step.measured_damping, step.modelled_damping);
    }
  }

  // Keeps the cancelled share as the winding warms and cools. An RC branch needs no following.
  bool watch() {
    if (circuit() != TuningCircuit::cancellation) return true;
    const SettingRange range = bench_.setting_range("cancellation_resistance");
    double now = value_of(run_.choice.settings, "cancellation_resistance");
    for (double waited = 0; waited < options_.watch; waited += options_.watch_interval) {
      throw_if_interrupted("watch");
      bench_.wait(options_.watch_interval);
      time_ += options_.watch_interval;
      const double f = frequencies_[frequencies_.size() / 3];
      follow_winding({measure(f)});
      const double next = cancellation_target(range);
      if (next == now) continue;
      if (!take_step({{"cancellation_resistance", next}})) return false;
      now = next;
    }
    run_.choice.settings = {{"cancellation_resistance", now}};
    run_.choice.device = run_.model.device = present_;
    return true;
  }

  Bench& bench_;
  const TuningOptions& options_;
  BenchLimits limits_;
  DriveMode mode_;
  Device present_;
  std::vector<double> frequencies_;
  double time_ = 0;
  TuningRun run_;
};

}  // namespace

const std::vector<std::string>& tuned_settings() {
  static const std::vector<std::string> names{"damping_connected",   "cancellation_resistance",
                                              "back_emf_damping",    "damping_resistance",
                                              "damping_capacitance", "back_emf_resistance"};
  return names;
}

std::string_view name_of(TuningOutcome outcome) {
  switch (outcome) {
    case TuningOutcome::reached:
      return "reached";
    case TuningOutcome::not_passive:
      return "not_passive";
    case TuningOutcome::unreachable:
      return "unreachable";
    case TuningOutcome::stopped:
      return "stopped";
  }
  return "";
}

TuningRun tune(Bench& bench, const PassivityModel& identified, const TuningOptions& options) {
  return Tuner(bench, identified, options).run();
}

}  // namespace gyrator
