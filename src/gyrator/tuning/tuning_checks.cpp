#include "gyrator/tuning/tuning_checks.hpp"

#include "gyrator/core/error.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <fmt/core.h>

namespace gyrator {
namespace {

using std::numbers::pi;

// The model is of another motor where a slow sine shows so much reactance that is not the
// inductance's, as a share of the winding's resistance; or so much more or less inertia.
constexpr double largest_reactance = 0.3;
constexpr double largest_load_ratio = 1.6;
// So far from the model's no winding is, hot or cold.
constexpr double largest_resistance_ratio = 2;
constexpr std::size_t slowest = 4;

constexpr double growth_allowed = 0.5;  // [1/s], what noise may do to the number
constexpr double noise_ratio = 9;       // of mean squares: three standard deviations
constexpr double least_motion = 0.05;
constexpr double oscillation_allowed = 0.05;
constexpr double least_remaining = 0.5;
constexpr double largest_deviation = 0.5;
constexpr std::size_t fewest_samples = 64;

std::complex<double> find_winding(const Tone& tone, const Motor& motor) {
  return (tone.voltage.value - motor.torque_constant * tone.velocity.value) / tone.current.value;
}

// Energy of what is left when mean and trend are taken out, and the mean square itself.
struct Window {
  double oscillation = 0, square = 0;
};

Window measure_window(const std::vector<double>& signal, std::size_t from, std::size_t to) {
  const auto n = static_cast<double>(to - from);
  double sum = 0, moment = 0, square = 0, times = 0;
  for (std::size_t k = from; k < to; ++k) {
    const double t = static_cast<double>(k - from) - (n - 1) / 2;
    sum += signal[k];
    moment += t * signal[k];
    times += t * t;
    square += signal[k] * signal[k];
  }
  const double about_trend = square - sum * sum / n - moment * moment / times;
  return {std::max(0.0, about_trend) / n, square / n};
}

}  // namespace

std::optional<std::string> find_contradiction(const std::vector<Tone>& bare, const Device& device) {
  const Motor& motor = *device.drive.motor;
  const Mechanics& mechanics = device.mechanics;
  for (std::size_t i = 0; i < std::min(slowest, bare.size()); ++i) {
    const Tone& tone = bare[i];
    const double omega = 2 * pi * tone.frequency_hz;
    const double off = find_winding(tone, motor).imag() - omega * motor.inductance;
    // What an amplifier samples of L di/dt behind its steps is its own affair.
    const double allowed = largest_reactance * motor.resistance + 0.5 * omega * motor.inductance;
    if (!(std::abs(off) <= allowed)) {
      return fmt::format(
          "at {:.3g} Hz the winding seems to have {:.3g} ohm of reactance that is not its "
          "inductance's: the torque constant of the model, {:.4g}, is not this motor's; identify "
          "it",
          tone.frequency_hz, off, motor.torque_constant);
    }
    const double load = std::abs(motor.torque_constant * tone.current.value / tone.velocity.value);
    const double modelled =
        std::abs(std::complex<double>(mechanics.damping, omega * mechanics.inertia));
    // Dry friction adds to what slow motion takes.
    const bool slides = i > 0 && mechanics.coulomb_friction <
                                     0.2 * motor.torque_constant * std::abs(tone.current.value);
    const bool is_light = !(load >= modelled / largest_load_ratio);
    if (is_light || (slides && load > modelled * largest_load_ratio)) {
      return fmt::format(
          "at {:.3g} Hz the motor turns as if it had {:.3g} times the model's inertia; identify it",
          tone.frequency_hz, load / modelled);
    }
  }
  return {};
}

double measure_winding(const std::vector<Tone>& tones, const Motor& motor) {
  double sum = 0, weights = 0;
  for (std::size_t i = 0; i < tones.size() && i + 1 < slowest; ++i) {
    const Tone& tone = tones[i];
    const double error =
        std::hypot(tone.voltage.deviation, motor.torque_constant * tone.velocity.deviation) /
            std::abs(tone.current.value) +
        1e-6;
    sum += find_winding(tone, motor).real() / (error * error);
    weights += 1 / (error * error);
  }
  const double resistance = sum / weights;
  if (!(resistance > motor.resistance / largest_resistance_ratio &&
        resistance < motor.resistance * largest_resistance_ratio)) {
    throw Error(ErrorCode::device, "winding",
                fmt::format("measures {:.4g} ohm, the model has {:.4g} ohm: no temperature makes "
                            "that; is the motor connected, and is it the model's?",
                            resistance, motor.resistance));
  }
  return resistance;
}

RingDown measure_ring_down(const Capture& capture) {
  const auto& v = capture.velocity;
  const auto& i = capture.current;
  const std::size_t n = v.size();
  if (n < fewest_samples || (!i.empty() && i.size() != n))
    throw Error(ErrorCode::device, "capture",
                fmt::format("{} samples of a ring-down: at least {}", n, fewest_samples));
  RingDown ring;
  const Window early = measure_window(v, n / 8, n / 4);
  const Window late = measure_window(v, 7 * n / 8, n);
  // From the middle of the one to the middle of the other.
  const double between = static_cast<double>(n) * (0.9375 - 0.1875) * capture.period;
  // A motor at rest has noise alone, whose level comes and goes.
  double largest = 0, steps = 0;
  for (std::size_t k = 0; k < n; ++k) {
    largest = std::max(largest, std::abs(v[k]));
    if (k > 7 * n / 8) steps += (v[k] - v[k - 1]) * (v[k] - v[k - 1]);
  }
  const double noise = steps / (2 * static_cast<double>(n - 7 * n / 8));
  const bool is_seen = late.square > noise_ratio * noise &&
                       late.square > least_motion * least_motion * largest * largest;
  if (is_seen && early.square > 0)
    ring.decay = std::log(early.square / late.square) / (2 * between);
  if (!i.empty()) ring.oscillating_current = std::sqrt(measure_window(i, 3 * n / 4, n).oscillation);
  if (!std::isfinite(ring.decay) || !std::isfinite(ring.oscillating_current))
    throw Error(ErrorCode::device, "capture", "a ring-down that is not finite");
  return ring;
}

std::optional<std::string> find_instability(const RingDown& ring, double largest_current) {
  if (!(ring.decay >= -growth_allowed)) {
    return fmt::format("motion grew by itself, {:.3g} per second, after the command's end",
                       -ring.decay);
  }
  if (!(ring.oscillating_current <= oscillation_allowed * largest_current)) {
    return fmt::format("{:.3g} A went on oscillating after the command's end",
                       ring.oscillating_current);
  }
  return {};
}

std::optional<std::string> find_shortage(double remaining, double expected) {
  if (remaining > least_remaining * expected) return {};
  return fmt::format(
      "{:.4g} ohm is left of the winding where {:.4g} ohm should be: less than {:.0f} %", remaining,
      expected, 100 * least_remaining);
}

std::optional<std::string> find_deviation(double measured, double modelled) {
  if (std::abs(measured - modelled) <= largest_deviation * std::abs(modelled)) return {};
  return fmt::format(
      "a damping of {:.4g} was measured where the model has {:.4g}: the model does not describe "
      "this amplifier",
      measured, modelled);
}

}  // namespace gyrator
