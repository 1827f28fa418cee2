#include "gyrator/identification/motor_fit.hpp"

#include "gyrator/core/error.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace gyrator {
namespace {

constexpr double reference_temperature = 298.15;
// (motion-2) neglects the harmonics of the speed: a fifth of what friction changes, and 2 % of the
// speed for all that a rotor is not.
constexpr double describing_error = 0.2, model_error = 0.02;
// An encoder that moves by fewer steps than this holds no sine.
constexpr double least_steps = 2;
// Rounding of a few steps is not white: up to this much larger in a sine than white noise.
constexpr double rounding_excess = 3;

Phasor find_model_velocity(const MotionFit& motion, const SineMeasurement& sine) {
  const double w = to_radians(sine.frequency_hz);
  const std::complex<double> moving =
      compute_sine_velocity(motion, sine.current.value, sine.frequency_hz);
  const std::complex<double> free =
      sine.current.value / std::complex<double>(motion.damping(), w * motion.inertia());
  return {moving, model_error * std::abs(moving) + describing_error * std::abs(free - moving)};
}

std::optional<Phasor> find_position_velocity(const SineMeasurement& sine, double quantum) {
  if (!sine.position) return std::nullopt;
  const double w = to_radians(sine.frequency_hz);
  const double size = std::abs(sine.position->value);
  double deviation = rounding_excess * sine.position->deviation;
  if (size < least_steps * quantum) deviation = std::max(deviation, quantum / 2);
  return Phasor{sine.position->value * std::complex<double>(0, w), w * deviation};
}

// I, dI/dt and W of (winding-1), the first as warm as the winding.
struct SineTerms {
  std::complex<double> in_phase, slope, velocity;
  double deviation = 0;  // of the velocity
};

SineTerms find_terms(const SineMeasurement& sine, const WindingOptions& options, int age) {
  const Phasor velocity = choose_velocity(sine, options);
  const std::complex<double> slope = options.lag
                                         ? compute_held_slope(*options.lag, sine.frequency_hz, age)
                                         : std::complex<double>(0, to_radians(sine.frequency_hz));
  const double warm =
      1 + options.temperature_coefficient * (sine.temperature - reference_temperature);
  return {warm * sine.current.value, slope * sine.current.value, velocity.value,
          velocity.deviation};
}

void add_sine_equations(std::vector<Equation>& equations, const SineMeasurement& sine,
                        const WindingOptions& options, int age, double impedance, double constant) {
  const SineTerms terms = find_terms(sine, options, age);
  const double deviation =
      std::sqrt(std::norm(sine.voltage->deviation) + std::norm(impedance * sine.current.deviation) +
                std::norm(constant * terms.deviation));
  const auto add = [&](auto part) {
    Equation equation;
    equation.x = Eigen::Vector4d(part(terms.in_phase), part(terms.slope), part(terms.velocity), 0);
    equation.y = part(sine.voltage->value);
    equation.deviation = std::max(deviation, 1e-12);
    equation.family = 0;
    equation.group = sine.group;
    equations.push_back(equation);
  };
  add([](std::complex<double> z) { return z.real(); });
  add([](std::complex<double> z) { return z.imag(); });
}

// What of (lag-3) the voltage's samples hold: the slope per jw turns by its phase into the current.
double find_sampled_rate(const MotionWindow& window, const WindingOptions& options, int age) {
  if (!options.lag || !(window.frequency_hz > 0)) return window.current_rate;
  const double w = to_radians(window.frequency_hz);
  const std::complex<double> slope = compute_held_slope(*options.lag, window.frequency_hz, age);
  return slope.imag() / w * window.current_rate + slope.real() * window.current;
}

std::vector<Equation> build_winding(std::span<const SineMeasurement> sines,
                                    std::span<const MotionWindow> windows,
                                    const WindingOptions& options, int age, double constant) {
  std::vector<Equation> equations;
  for (const SineMeasurement& sine : sines) {
    if (!sine.voltage || !(std::abs(sine.current.value) > 0)) continue;
    const double impedance = std::abs(sine.voltage->value) / std::abs(sine.current.value);
    add_sine_equations(equations, sine, options, age, impedance, constant);
  }
  for (const MotionWindow& window : windows) {
    const double warm =
        1 + options.temperature_coefficient * (window.temperature - reference_temperature);
    Equation equation;
    equation.x = Eigen::Vector4d(warm * window.current, find_sampled_rate(window, options, age),
                                 window.velocity, 1);
    equation.y = window.voltage;
    equation.family = 1;
    equation.group = window.group;
    equations.push_back(equation);
  }
  return equations;
}

double find_misfit(const std::vector<Equation>& equations, const Eigen::VectorXd& values) {
  double sum = 0;
  for (const Equation& e : equations)
    if (e.family == 0) sum += std::pow((e.y - e.x.dot(values)) / e.deviation, 2);
  return sum;
}

}  // namespace

double find_mean_current(const MotionWindow& window, const std::optional<HeldLag>& lag) {
  if (!lag || !(window.frequency_hz > 0)) return window.current;
  const std::complex<double> mean = compute_held_mean(*lag, window.frequency_hz);
  return mean.real() * window.current +
         mean.imag() * window.current_rate / to_radians(window.frequency_hz);
}

MotionFit fit_motion(std::span<const MotionWindow> windows, const std::optional<HeldLag>& lag) {
  std::vector<Equation> equations;
  for (const MotionWindow& window : windows) {
    if (window.direction == 0) continue;
    Equation equation;
    equation.x = Eigen::Vector4d(window.acceleration, window.velocity, window.direction, 1);
    equation.y = find_mean_current(window, lag);
    // The faster the run, the more the encoder's steps are worth in current.
    equation.family = window.run;
    equation.group = window.group;
    equations.push_back(equation);
  }
  return {fit_grouped(equations), static_cast<int>(equations.size())};
}

std::complex<double> compute_sine_velocity(const MotionFit& motion, std::complex<double> current,
                                           double frequency_hz) {
  const double w = to_radians(frequency_hz);
  const double a = w * motion.inertia(), b = motion.damping();
  const double f = 4 / std::numbers::pi * std::max(motion.friction(), 0.0);
  const double size = std::abs(current);
  if (size <= f || !(a > 0)) return 0;
  // (a s)^2 + (b s + f)^2 = |I|^2
  const double p = a * a + b * b;
  const double speed = (-b * f + std::sqrt(b * b * f * f + p * (size * size - f * f))) / p;
  return current / std::complex<double>(b + f / speed, a);
}

std::complex<double> compute_terminal_voltage(const SineMeasurement& sine, const WindingFit& fit,
                                              const WindingOptions& options) {
  const SineTerms terms = find_terms(sine, options, fit.age);
  const Eigen::VectorXd& p = fit.fit.values;
  return p[0] * terms.in_phase + p[1] * terms.slope + p[2] * terms.velocity;
}

Phasor choose_velocity(const SineMeasurement& sine, const WindingOptions& options) {
  Phasor best{0, std::numeric_limits<double>::infinity()};
  const auto offer = [&](const std::optional<Phasor>& phasor) {
    if (phasor && phasor->deviation < best.deviation) best = *phasor;
  };
  offer(sine.velocity);
  offer(find_position_velocity(sine, options.position_quantum));
  if (options.motion) offer(find_model_velocity(*options.motion, sine));
  if (!std::isfinite(best.deviation)) best = {0, 0};
  return best;
}

std::optional<WindingFit> fit_winding(std::span<const SineMeasurement> sines,
                                      std::span<const MotionWindow> windows,
                                      const WindingOptions& options) {
  if (std::none_of(sines.begin(), sines.end(), [](const auto& s) { return s.voltage; }))
    return std::nullopt;
  // A delay of whole ticks may count to either side of the sampled instant: what fits better.
  std::vector<int> ages{1};
  if (options.lag) {
    const int age = find_acting_age(*options.lag);
    ages = {age - 1, age, age + 1};
  }
  std::optional<WindingFit> best;
  double least = std::numeric_limits<double>::infinity();
  for (const int age : ages) {
    if (age < 0) continue;
    double constant = 0;
    for (int round = 0; round < 2; ++round) {
      const auto equations = build_winding(sines, windows, options, age, constant);
      const GroupedFit fit = fit_grouped(equations);
      constant = fit.values[2];
      const double misfit = find_misfit(equations, fit.values);
      if (round == 1 && misfit < least) {
        least = misfit;
        best = WindingFit{fit, age};
      }
    }
  }
  return best;
}

}  // namespace gyrator
