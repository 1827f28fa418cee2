#include "gyrator/identification/experiments.hpp"

#include "gyrator/core/error.hpp"
#include "gyrator/core/interrupt.hpp"
#include "gyrator/identification/experiment_rules.hpp"
#include "gyrator/identification/sine_fit.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace gyrator {

namespace rules = experiment_rules;

namespace {

std::optional<Phasor> fit_signal(const Capture& capture, const std::vector<double>& signal,
                                 double frequency_hz, double noise_floor) {
  if (signal.empty()) return std::nullopt;
  SineModel model{3, 3};
  while (model.harmonics > 1 && model.harmonics * frequency_hz * capture.period > 0.45)
    --model.harmonics;
  const SineFit fit = fit_sine(signal, capture.start, capture.period, frequency_hz, model);
  return Phasor{fit.coefficient, std::max(fit.deviation, noise_floor)};
}

double mean_temperature(const Capture& capture, double otherwise) {
  if (!capture.winding_temperature_before) return otherwise;
  const double before = *capture.winding_temperature_before;
  return (before + capture.winding_temperature_after.value_or(before)) / 2;
}

// By what the sensors see, the sensor first.
double find_speed(const SineMeasurement& sine, double quantum) {
  const double w = to_radians(sine.frequency_hz);
  if (sine.position && std::abs(sine.position->value) > 3 * quantum &&
      std::abs(sine.position->value) > rules::visible_ratio * sine.position->deviation)
    return w * std::abs(sine.position->value);
  if (sine.velocity &&
      std::abs(sine.velocity->value) > rules::visible_ratio * sine.velocity->deviation)
    return std::abs(sine.velocity->value);
  return 0;
}

bool stands_still(const std::vector<double>& position) {
  return std::all_of(position.begin(), position.end(),
                     [&](double x) { return x == position.front(); });
}

}  // namespace

std::optional<double> find_quantum(const std::vector<double>& position) {
  constexpr double most_steps = 20, tolerance = 0.05, share = 0.95;
  constexpr int least_moves = 5;
  std::vector<double> moves;
  for (std::size_t k = 1; k < position.size(); ++k)
    if (position[k] != position[k - 1]) moves.push_back(std::abs(position[k] - position[k - 1]));
  if (moves.empty()) return std::nullopt;
  const double least = *std::min_element(moves.begin(), moves.end());
  std::erase_if(moves, [&](double move) { return move > most_steps * least; });
  double sum = 0, steps = 0;
  int whole = 0;
  for (const double move : moves) {
    const double multiple = std::round(move / least);
    whole += std::abs(move / least - multiple) < tolerance;
    sum += move;
    steps += multiple;
  }
  const auto count = static_cast<double>(moves.size());
  if (count < least_moves || whole < share * count) return std::nullopt;
  return sum / steps;
}

double find_peak_velocity(double inertia, double damping, double friction, double amplitude,
                          double frequency_hz, int periods) {
  constexpr int steps = 400;
  const double h = 1 / (frequency_hz * steps), w = to_radians(frequency_hz);
  // Exact in the damping over a step, the current that of its middle.
  const double decay = std::exp(-h * damping / inertia);
  const double gain = damping * h > 1e-9 * inertia ? (1 - decay) / damping : h / inertia;
  double velocity = 0, peak = 0;
  for (int k = 0; k < steps * periods; ++k) {
    const double current = amplitude * std::sin(w * (k + 0.5) * h);
    const double side = velocity != 0 ? velocity : current;
    if (velocity == 0 && std::abs(current) <= friction) continue;
    const double next = velocity * decay + gain * (current - std::copysign(friction, side));
    velocity = velocity * next < 0 ? 0 : next;
    peak = std::max(peak, std::abs(velocity));
  }
  return peak;
}

Experiments::Experiments(Bench& bench, const IdentificationOptions& options,
                         const ExperimentListener& listener, Identification& found)
    : bench_(bench),
      limits_(bench.limits()),
      options_(options),
      listener_(listener),
      found_(found) {}

Capture Experiments::play(const Experiment& experiment) {
  throw_if_interrupted("identification");
  if (listener_) listener_(experiment);
  found_.experiments.push_back(experiment);
  found_.duration += experiment.excitation.duration;
  return bench_.run(experiment.excitation, experiment.capture);
}

void Experiments::look_at_steps(const Capture& capture) {
  if (found_.position_quantum > 0) return;
  if (const auto quantum = find_quantum(capture.position)) found_.position_quantum = *quantum;
}

SineMeasurement Experiments::measure_sine(const std::string& purpose, double frequency_hz,
                                          double amplitude) {
  Experiment experiment;
  experiment.purpose = purpose;
  const SineTiming timing = find_sine_timing(limits_, frequency_hz);
  experiment.capture = timing.capture;
  experiment.excitation = {ExcitationKind::sine, DriveMode::current, amplitude, 0, frequency_hz, 0,
                           timing.duration};
  const Capture capture = play(experiment);
  SineMeasurement sine;
  sine.frequency_hz = frequency_hz;
  sine.group = groups_++;
  sine.played = {0, -amplitude};  // a sin(wt) = Re(-j a e^{jwt})
  sine.command = fit_signal(capture, capture.command, frequency_hz, 0);
  const auto current = fit_signal(capture, capture.current, frequency_hz, 1e-12);
  if (!current)
    throw Error(ErrorCode::bad_input, "bench",
                "no captured current: nothing can be identified without it");
  sine.current = *current;
  sine.voltage = fit_signal(capture, capture.voltage, frequency_hz, 1e-12);
  sine.velocity = fit_signal(capture, capture.velocity, frequency_hz, 1e-12);
  look_at_steps(capture);
  // An encoder that stands still on one step says nothing, and with no noise at all.
  if (!stands_still(capture.position))
    sine.position = fit_signal(capture, capture.position, frequency_hz, 1e-15);
  if (capture.winding_temperature_before) found_.temperature_known = true;
  sine.temperature = mean_temperature(capture, 298.15);
  found_.sines.push_back(sine);
  return sine;
}

// From the sine nearest in frequency: |Z| changes at most as the frequency or its inverse.
double Experiments::limit_amplitude(double frequency_hz, double wanted) const {
  const double highest = options_.current_share * limits_.largest_current;
  double amplitude = std::min(wanted, highest);
  const SineMeasurement* nearest = nullptr;
  double apart = std::numeric_limits<double>::infinity();
  for (const SineMeasurement& sine : found_.sines) {
    const double ratio =
        std::max(sine.frequency_hz / frequency_hz, frequency_hz / sine.frequency_hz);
    if (ratio <= apart) {
      apart = ratio;
      nearest = &sine;
    }
  }
  if (nearest == nullptr) return amplitude;
  const double played = std::max(std::abs(nearest->current.value), 1e-9);
  if (nearest->voltage && limits_.largest_voltage > 0) {
    const double per_ampere = std::abs(nearest->voltage->value) / played * apart;
    // A third less: at each of the command's steps the voltage is higher than the sine's.
    amplitude = std::min(amplitude,
                         2.0 / 3 * options_.voltage_share * limits_.largest_voltage / per_ampere);
  }
  if (limits_.largest_velocity > 0) {
    // A sine from rest swings to twice its own amplitude.
    const double slower = std::max(1.0, nearest->frequency_hz / frequency_hz);
    const double per_ampere = 2 * find_speed(*nearest, found_.position_quantum) / played * slower;
    if (per_ampere > 0)
      amplitude =
          std::min(amplitude, options_.velocity_share * limits_.largest_velocity / per_ampere);
  }
  return amplitude;
}

void Experiments::find_amplitude() {
  const double frequency = find_probe_frequency(choose_frequencies(limits_, options_));
  amplitude_ = rules::first_share * limits_.largest_current;
  for (;;) {
    const SineMeasurement sine = measure_sine("amplitude", frequency, amplitude_);
    const auto stands_out = [](const Phasor& phasor) {
      return std::abs(phasor.value) > rules::wanted_ratio * phasor.deviation;
    };
    const bool enough = stands_out(sine.current) && (!sine.voltage || stands_out(*sine.voltage));
    const double largest =
        limit_amplitude(frequency, options_.current_share * limits_.largest_current);
    if (enough || amplitude_ >= 0.95 * largest) break;
    amplitude_ = std::min(rules::growth * amplitude_, largest);
  }
}

void Experiments::sweep_sines() {
  std::vector<double> frequencies = choose_frequencies(limits_, options_);
  // From the probe's frequency each neighbour is known before it is played.
  for (int turn = 0; turn < 2; ++turn) {
    for (const double frequency : frequencies)
      measure_sine("winding and amplifier", frequency, limit_amplitude(frequency, amplitude_));
    std::reverse(frequencies.begin(), frequencies.end());
  }
}

bool Experiments::find_motion() {
  // Without a sensor nobody would see how fast it runs.
  if (std::none_of(found_.sines.begin(), found_.sines.end(),
                   [](const auto& sine) { return sine.position || sine.velocity; }))
    return false;
  const auto slowest = std::min_element(
      found_.sines.begin(), found_.sines.end(),
      [](const auto& a, const auto& b) { return a.frequency_hz < b.frequency_hz; });
  SineMeasurement sine = *slowest;
  double frequency = sine.frequency_hz;
  double amplitude = amplitude_;
  for (;;) {
    const double speed = find_speed(sine, found_.position_quantum);
    if (speed > 0) {
      inertia_guess_ = std::abs(sine.current.value) / (to_radians(sine.frequency_hz) * speed);
      seen_velocity_ = speed;
      return true;
    }
    const double largest = options_.current_share * limits_.largest_current;
    if (amplitude < 0.95 * largest)
      amplitude = std::min(rules::growth * amplitude, limit_amplitude(frequency, largest));
    else
      frequency = round_frequency(frequency / 2);
    if (frequency < std::max(rules::slowest_frequency, limits_.lowest_frequency_hz)) return false;
    sine = measure_sine("motion", frequency, limit_amplitude(frequency, amplitude));
  }
}

// A quarter to spare: what grows is not yet known well.
double Experiments::find_velocity_cap() const {
  double cap = std::numeric_limits<double>::infinity();
  if (limits_.largest_velocity > 0) cap = options_.velocity_share * limits_.largest_velocity;
  if (limits_.largest_voltage > 0 && found_.winding) {
    const Estimate constant = found_.winding->fit.at(2);
    const double surely = std::abs(constant.value) + 3 * constant.deviation;
    cap = std::min(cap, options_.voltage_share * limits_.largest_voltage / surely);
  }
  return cap;
}

void Experiments::refit() {
  try {
    found_.motion = fit_motion(found_.windows, found_.lag);
  } catch (const Error& error) {
    if (error.code() != ErrorCode::numerical) throw;
  }
  WindingOptions options;
  options.motion = found_.motion;
  options.position_quantum = found_.position_quantum;
  options.temperature_coefficient = options_.temperature_coefficient;
  options.lag = found_.lag;
  found_.winding = fit_winding(found_.sines, found_.windows, options);
}

void Experiments::measure_motion(const std::string& purpose, double frequency_hz, double amplitude,
                                 int periods) {
  Experiment experiment;
  experiment.purpose = purpose;
  const double duration = round_duration(periods / frequency_hz);
  const double shortest = limits_.shortest_period;
  experiment.capture.period =
      shortest * std::max(1.0, std::ceil(duration / (limits_.most_samples * shortest) - 1e-9));
  experiment.capture.samples =
      std::min(limits_.most_samples,
               static_cast<int>(std::floor(duration / experiment.capture.period + 1e-9)));
  experiment.excitation = {
      ExcitationKind::sine, DriveMode::current, amplitude, 0, frequency_hz, 0, duration};
  const Capture capture = play(experiment);
  look_at_steps(capture);
  WindowOptions options;
  options.length = std::min(rules::window_periods / frequency_hz, rules::longest_window);
  options.position_quantum = found_.position_quantum;
  std::vector<MotionWindow> windows = find_windows(capture, options);
  double peak = 0;
  for (const MotionWindow& window : windows) peak = std::max(peak, std::abs(window.velocity));
  options.least_velocity = 0.03 * peak;
  windows = find_windows(capture, options);
  seen_velocity_ = std::max(seen_velocity_, peak);
  for (std::size_t k = 0; k < windows.size(); ++k) {
    windows[k].run = runs_;
    windows[k].frequency_hz = frequency_hz;
    windows[k].group = groups_ + static_cast<int>(k * rules::segments / windows.size());
    found_.windows.push_back(windows[k]);
  }
  groups_ += rules::segments;
  ++runs_;
  bench_.wait(rules::pause);
  found_.duration += rules::pause;
}

namespace {

// The amplitude that brings the motor to a speed, by bisection; the peak rises with it.
double find_amplitude_for(double inertia, double damping, double friction, double velocity,
                          double frequency_hz, int periods, double largest) {
  double low = 0, high = largest;
  if (find_peak_velocity(inertia, damping, friction, largest, frequency_hz, periods) < velocity)
    return largest;
  for (int round = 0; round < 30; ++round) {
    const double middle = (low + high) / 2;
    const bool over =
        find_peak_velocity(inertia, damping, friction, middle, frequency_hz, periods) > velocity;
    (over ? high : low) = middle;
  }
  return low;
}

}  // namespace

void Experiments::measure_inertia() {
  constexpr int periods = rules::inertia_periods;
  const double largest = options_.current_share * limits_.largest_current;
  refit();
  double velocity = seen_velocity_;
  for (int round = 0; round < rules::inertia_rounds; ++round) {
    velocity = std::min(rules::growth * velocity, find_velocity_cap());
    double inertia = inertia_guess_, damping = 0, friction = 0;
    if (found_.motion && found_.motion->inertia() > 0) {
      inertia = found_.motion->inertia();
      damping = std::max(0.0, found_.motion->damping());
      friction = std::max(0.0, found_.motion->friction());
    }
    // At half the current the inertia is what counts; the frequency follows from it.
    const double frequency =
        round_frequency(std::clamp(largest / (inertia * to_radians(velocity)),
                                   find_slowest_inertia(limits_), find_fastest_motion(limits_)));
    const double amplitude =
        find_amplitude_for(inertia, damping, friction, velocity, frequency, periods, largest);
    measure_motion("inertia", frequency, amplitude, periods);
    measure_motion("inertia", frequency, -amplitude, periods);
    refit();
    if (velocity >= 0.9 * find_velocity_cap() || amplitude >= 0.99 * largest) break;
  }
}

void Experiments::measure_friction() {
  constexpr int periods = rules::friction_periods;
  const double largest = options_.current_share * limits_.largest_current;
  const double frequency = options_.slow_frequency_hz;
  for (int repeat = 0; repeat < rules::friction_repeats; ++repeat) {
    if (!found_.motion || !(found_.motion->inertia() > 0)) return;
    const double amplitude = find_amplitude_for(
        found_.motion->inertia(), std::max(0.0, found_.motion->damping()),
        std::max(0.0, found_.motion->friction()), find_velocity_cap(), frequency, periods, largest);
    measure_motion("friction", frequency, amplitude, periods);
    measure_motion("friction", frequency, -amplitude, periods);
    refit();
  }
}

}  // namespace gyrator
