#include "gyrator/identification/motion_window.hpp"

#include "gyrator/core/error.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <span>

namespace gyrator {
namespace {

// Fewer samples would not follow the weight's second derivative.
constexpr int least_intervals = 16;

struct Weights {
  std::vector<double> mean, rate, curvature;
};

// Scaled so that the sums, too, are exact for uniform acceleration.
Weights build_weights(int intervals, double period) {
  const double q = std::numbers::pi / intervals;
  Weights weights;
  double mean = 0, rate = 0, curvature = 0;
  for (int k = 0; k <= intervals; ++k) {
    const double s = std::sin(q * k), c = std::cos(q * k), t = (k - intervals / 2.0) * period;
    weights.mean.push_back(s * s * s * s);
    weights.rate.push_back(s * s * s * c);
    weights.curvature.push_back(s * s * (3 * c * c - s * s));
    mean += weights.mean.back();
    rate -= weights.rate.back() * t;
    curvature += weights.curvature.back() * t * t / 2;
  }
  for (double& weight : weights.mean) weight /= mean;
  for (double& weight : weights.rate) weight /= rate;
  for (double& weight : weights.curvature) weight /= curvature;
  return weights;
}

double sum(const std::vector<double>& weights, std::span<const double> signal, double level) {
  double total = 0;
  for (std::size_t k = 0; k < weights.size(); ++k) total += weights[k] * (signal[k] - level);
  return total;
}

// Sure to slide: each quarter moves the same way, fast enough and by more than the encoder's steps.
int find_direction(std::span<const double> position, double period, const WindowOptions& options) {
  const std::size_t quarter = (position.size() - 1) / 4;
  int direction = 0;
  for (std::size_t q = 0; q < 4; ++q) {
    const double way = position[(q + 1) * quarter] - position[q * quarter];
    const double least = std::max(3 * options.position_quantum,
                                  options.least_velocity * static_cast<double>(quarter) * period);
    if (std::abs(way) <= least) return 0;
    const int side = way > 0 ? 1 : -1;
    if (direction != 0 && side != direction) return 0;
    direction = side;
  }
  return direction;
}

std::vector<double> integrate(const std::vector<double>& velocity, double period) {
  std::vector<double> position(velocity.size(), 0.0);
  for (std::size_t k = 1; k < velocity.size(); ++k)
    position[k] = position[k - 1] + period * (velocity[k] + velocity[k - 1]) / 2;
  return position;
}

}  // namespace

std::vector<MotionWindow> find_windows(const Capture& capture, const WindowOptions& options) {
  if (capture.current.empty() || (capture.position.empty() && capture.velocity.empty()))
    throw Error(ErrorCode::bad_input, "capture",
                "no current, or neither position nor velocity: friction and inertia need both");
  const std::vector<double> position =
      capture.position.empty() ? integrate(capture.velocity, capture.period) : capture.position;
  const int half = std::max(least_intervals / 2,
                            static_cast<int>(std::lround(options.length / capture.period / 2)));
  const Weights weights = build_weights(2 * half, capture.period);
  const double last = static_cast<double>(position.size() - 1) * capture.period;
  std::vector<MotionWindow> windows;
  for (std::size_t first = 0; first + 2 * half < position.size(); first += half) {
    const auto cut = [&](const std::vector<double>& signal) {
      return std::span<const double>(signal).subspan(first, 2 * half + 1);
    };
    MotionWindow window;
    const double inside = static_cast<double>(first + half) * capture.period;
    window.time = capture.start + inside;
    window.current = sum(weights.mean, cut(capture.current), 0);
    window.current_rate = -sum(weights.rate, cut(capture.current), window.current);
    if (!capture.voltage.empty()) window.voltage = sum(weights.mean, cut(capture.voltage), 0);
    const double level = position[first + half];
    window.velocity = -sum(weights.rate, cut(position), level);
    window.acceleration = sum(weights.curvature, cut(position), level);
    window.direction = find_direction(cut(position), capture.period, options);
    const double before = capture.winding_temperature_before.value_or(options.default_temperature);
    const double after = capture.winding_temperature_after.value_or(before);
    window.temperature = before + (after - before) * inside / last;
    windows.push_back(window);
  }
  return windows;
}

}  // namespace gyrator
