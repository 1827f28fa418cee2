#include "gyrator/controllers/contact_effect.hpp"

#include "gyrator/core/error.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>

#include <fmt/core.h>

namespace gyrator {
namespace {

constexpr double time_constants = 14;  // e^-14 is below a millionth
constexpr double most_samples = 1e6;

[[noreturn]] void refuse(const std::string& key, const std::string& message) {
  throw Error(ErrorCode::bad_input, "controller/contact_effects/" + key, message);
}

void require_positive(const std::string& key, double value) {
  if (!(value > 0)) refuse(key, fmt::format("{:g}: must be above 0", value));
}

std::size_t count_samples(const std::string& key, double duration, double period) {
  const double samples = std::max(1.0, std::round(duration / period));
  if (samples > most_samples)
    refuse(key, fmt::format("{:g} s would last {:g} samples: at most {:g} are played", duration,
                            samples, most_samples));
  return static_cast<std::size_t>(samples);
}

// A sine that the hold cannot play would come out as another one.
void check_sine(double frequency_hz, double decay_time, double period) {
  require_positive("decay_time", decay_time);
  if (frequency_hz > 0 && frequency_hz < 0.5 / period) return;
  refuse("frequency", fmt::format("{:g} Hz: must be above 0 and below {:g} Hz, half the sampling "
                                  "rate",
                                  frequency_hz, 0.5 / period));
}

// v(t) = int a dt per velocity of impact.
struct TransientVelocity {
  double time;

  double operator()(const DecayingSine& s) const {
    const double B = 1 / s.decay_time;
    const double w = 2 * std::numbers::pi * s.frequency_hz;
    const double decayed = std::exp(-B * time) * (B * std::sin(w * time) + w * std::cos(w * time));
    return s.velocity_change * (1 - decayed / w);
  }

  double operator()(const RecordedTransient& r) const {
    double sum = 0;
    for (std::size_t i = 0; i + 1 < r.acceleration.size(); ++i) {
      const double share = std::clamp(time / r.time_step - static_cast<double>(i), 0.0, 1.0);
      const double reached =
          r.acceleration[i] + share * (r.acceleration[i + 1] - r.acceleration[i]);
      sum += share * (r.acceleration[i] + reached) / 2;
      if (share < 1) break;
    }
    return sum * r.time_step / r.velocity;
  }
};

std::size_t check_transient(const DecayingSine& sine, double period) {
  check_sine(sine.frequency_hz, sine.decay_time, period);
  return count_samples("decay_time", time_constants * sine.decay_time, period);
}

std::size_t check_transient(const RecordedTransient& recorded, double period) {
  require_positive("time_step", recorded.time_step);
  require_positive("velocity", recorded.velocity);
  if (recorded.acceleration.size() < 2)
    refuse("acceleration", fmt::format("{} samples: at least 2", recorded.acceleration.size()));
  const double steps = static_cast<double>(recorded.acceleration.size() - 1);
  return count_samples("acceleration",
                       std::ceil(steps * recorded.time_step / period - 1e-9) * period, period);
}

}  // namespace

std::vector<double> make_effect_course(const BrakingPulse& pulse, double period) {
  require_positive("damping", pulse.damping);
  const std::size_t samples = count_samples("duration", pulse.duration, period);
  double damping = pulse.damping;
  if (pulse.inertia) {
    require_positive("inertia", *pulse.inertia);
    damping = std::min(damping, *pulse.inertia / (static_cast<double>(samples) * period));
  }
  return std::vector<double>(samples, damping);
}

std::vector<double> make_effect_course(const EventTransient& transient, double period) {
  check_sine(transient.frequency_hz, transient.decay_time, period);
  std::vector<double> course(
      count_samples("decay_time", time_constants * transient.decay_time, period));
  for (std::size_t k = 0; k < course.size(); ++k) {
    const double t = (static_cast<double>(k) + 0.5) * period;
    course[k] = transient.gain * std::exp(-t / transient.decay_time) *
                std::sin(2 * std::numbers::pi * transient.frequency_hz * t);
  }
  return course;
}

std::vector<double> make_effect_course(const AccelerationMatching& matching, double period) {
  require_positive("inertia", matching.inertia);
  if (matching.damping < 0)
    refuse("damping", fmt::format("{:g}: must be at least 0", matching.damping));
  const std::size_t samples =
      std::visit([&](const auto& t) { return check_transient(t, period); }, matching.transient);
  const double rate = matching.damping / matching.inertia;
  const double e = std::exp(-rate * period);
  // Velocity per effort held over a period, (1 - e)/b.
  const double per_effort = matching.damping > 0 ? -std::expm1(-rate * period) / matching.damping
                                                 : period / matching.inertia;
  std::vector<double> course(samples);
  double velocity = 0;
  for (std::size_t k = 0; k < samples; ++k) {
    const double next =
        std::visit(TransientVelocity{static_cast<double>(k + 1) * period}, matching.transient);
    course[k] = (next - e * velocity) / per_effort;
    velocity = next;
  }
  return course;
}

}  // namespace gyrator
