#include "gyrator/tuning/tuning_run.hpp"

#include "gyrator/amplifiers/settings_guard.hpp"
#include "gyrator/core/error.hpp"
#include "gyrator/core/interrupt.hpp"
#include "gyrator/tuning/drive_amplitude.hpp"
#include "gyrator/tuning/step_images.hpp"
#include "gyrator/tuning/tuning_checks.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <fmt/core.h>

namespace gyrator {
namespace {

using std::numbers::pi;

// Share of what is left of the winding that stays at each step of a cancellation.
constexpr double kept_per_step = 0.6;
// Steps of an RC branch, from its largest resistance down to the chosen one.
constexpr int rc_steps = 3;
constexpr double push_duration = 0.05;  // [s]

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
    SettingsGuard guard(bench_, tuned_settings());
    const auto end = [&](TuningOutcome outcome, std::string explanation) {
      run_.outcome = outcome;
      run_.explanation = std::move(explanation);
      outcome == TuningOutcome::reached ? guard.keep() : guard.put_back();
      return run_;
    };
    run_.measurement.mode = mode_;
    run_.measurement.delay = run_.model.sampling.delay.to_double();
    present_ = bare_device();
    run_.measurement.bare = measure(frequencies_);
    if (const auto why = find_contradiction(run_.measurement.bare, run_.model.device))
      return end(TuningOutcome::stopped, *why);
    follow_winding(run_.measurement.bare);
    run_.choice = choose_settings(run_.model, options_.target, range_of());
    if (!run_.choice.reaches_wall && !options_.target.cancellation)
      return end(TuningOutcome::unreachable, explain_unreachable());
    if (!raise() || !watch()) return end(TuningOutcome::stopped, run_.steps.back().remark);
    run_.measurement.damped = measure(frequencies_);
    follow_winding(run_.measurement.damped);
    settle_device();
    run_.verdict = judge_measured(run_.model, run_.measurement);
    if (!run_.verdict->passive && !options_.target.cancellation)
      return end(TuningOutcome::not_passive, explain_not_passive());
    return end(TuningOutcome::reached, {});
  }

 private:
  TuningCircuit circuit() const { return options_.target.circuit; }

  void check() const {
    check_measurable(run_.model);
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

  std::string explain_unreachable() const {
    return fmt::format(
        "no setting of the amplifier carries the wall with its margin; the stiffest wall by the "
        "model is {:.4g} {}. A larger virtual damping, a shorter period or another --circuit may",
        run_.choice.max_stiffness, run_.model.device.motion == Motion::rotary ? "N.m/rad" : "N/m");
  }

  std::string explain_not_passive() const {
    if (run_.verdict->margin > 0)
      return fmt::format(
          "by the measured response the wall is passive at {:.3g} Hz by {:.3g}, but the noise of "
          "the measurement leaves its 99 % bound open: measure with more --current or over another "
          "range",
          run_.verdict->worst_frequency_hz, run_.verdict->margin);
    return "by the measured response the wall is not passive";
  }

  double largest_current() const {
    return options_.current > 0 ? options_.current : limits_.largest_current / 5;
  }

  std::vector<Tone> measure(const std::vector<double>& frequencies) {
    std::vector<Tone> tones;
    for (const double f : frequencies) tones.push_back(measure(f));
    return tones;
  }

  Tone measure(double frequency_hz) {
    const Tone tone =
        measure_tone(bench_, mode_,
                     find_sine_amplitude(present_, limits_, mode_, largest_current(), frequency_hz),
                     frequency_hz);
    time_ += tone.duration;
    return remove_step_images(tone, present_, limits_.shortest_period, run_.measurement.delay);
  }

  // The winding as warm as the lowest sines say.
  double follow_winding(const std::vector<Tone>& tones) {
    Motor& motor = *run_.model.device.drive.motor;
    const double resistance = measure_winding(tones, motor);
    if (motor.temperature_coefficient > 0) {
      motor.temperature_rise = (resistance / motor.resistance - 1) / motor.temperature_coefficient;
    } else {
      motor.resistance = resistance;
    }
    present_.drive.motor = motor;
    return resistance;
  }

  void write(const std::vector<Setting>& settings) {
    for (const Setting& setting : settings) bench_.write_setting(setting.name, setting.value);
    if (circuit() == TuningCircuit::rc && bench_.has_setting("damping_connected"))
      bench_.write_setting("damping_connected", 1);
    present_ = make_tuned_device(run_.model.device, circuit(), settings);
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
        if (next == now) break;
        if (!take_step({{"cancellation_resistance", next}})) return false;
        const bool went_down = next < now;  // the winding measured colder
        now = next;
        if (went_down) break;
      }
    }
    // Nothing to raise: the bare drive is what was chosen.
    if (run_.steps.empty() && !take_step(run_.choice.settings)) return false;
    run_.choice.settings = run_.steps.back().settings;
    settle_device();
    return true;
  }

  // What the settings reached make of the device, with the winding as warm as it is.
  void settle_device() {
    present_ = make_tuned_device(run_.model.device, circuit(), run_.choice.settings);
    run_.choice.device = run_.model.device = present_;
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

  // First whether it is stable, by a short push; then what it does.
  bool take_step(const std::vector<Setting>& settings) {
    write(settings);
    TuningStep step;
    step.settings = settings;
    if (auto why = push(step)) {
      refuse(step, *why);
    } else {
      measure_damping(step);
      judge(step);
    }
    step.time = time_;
    run_.steps.push_back(step);
    if (options_.on_step) options_.on_step(run_.steps.back());
    return step.stable;
  }

  static void refuse(TuningStep& step, std::string why) {
    step.stable = false;
    step.remark = std::move(why);
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
  }

  // The command ends; what is left must fade.
  std::optional<std::string> push(TuningStep& step) {
    Excitation push;
    push.kind = ExcitationKind::dc;
    push.mode = mode_;
    push.duration = push_duration;
    push.offset =
        find_push_amplitude(present_, limits_, mode_, largest_current() / 2, push.duration);
    CaptureRequest request;
    request.start = push.duration;
    request.samples = std::min(2000, limits_.most_samples);
    request.period =
        limits_.shortest_period * std::ceil(0.2 / (limits_.shortest_period * request.samples));
    run_.ring_down = bench_.run(push, request);
    time_ += push.duration + request.samples * request.period;
    const RingDown ring = measure_ring_down(run_.ring_down);
    step.decay = ring.decay;
    return find_instability(ring, limits_.largest_current);
  }

  void judge(TuningStep& step) const {
    if (mode_ == DriveMode::voltage) {
      const double expected = step.winding_resistance - find_cancelled_resistance(present_.drive);
      if (auto why = find_shortage(step.remaining_resistance, expected)) return refuse(step, *why);
    }
    if (auto why = find_deviation(step.measured_damping, step.modelled_damping)) refuse(step, *why);
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
    settle_device();
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
