#include "gyrator/cosim/gesture.hpp"

#include "gyrator/cosim/sensor.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <utility>

namespace gyrator {
namespace {

using std::numbers::pi;

constexpr std::size_t random_sines = 64;

// sin(a) over a from `from` to `to`, as a product: exact for short steps.
double integrate_sine(double from, double to) {
  return 2 * std::sin((from + to) / 2) * std::sin((to - from) / 2);
}

class HitWave : public Waveform {
 public:
  explicit HitWave(HitGesture hit) : hit_(std::move(hit)) {}

  double integrate(double from, double to) override {
    double sum = 0;
    for (const double first : hit_.times) {
      if (!hit_.repeat) {
        sum += integrate_pulse(from - first, to - first);
        continue;
      }
      const double n_first = std::max(0.0, std::ceil((from - first - hit_.width) / *hit_.repeat));
      for (double n = n_first; first + n * *hit_.repeat < to; ++n) {
        const double start = first + n * *hit_.repeat;
        sum += integrate_pulse(from - start, to - start);
      }
    }
    return sum;
  }

  double rise(double, double) override { return 0; }

 private:
  double integrate_pulse(double from, double to) const {
    const double w = hit_.width;
    from = std::clamp(from, 0.0, w);
    to = std::clamp(to, 0.0, w);
    if (!(to > from)) return 0;
    if (hit_.shape == HitGesture::Shape::half_sine)
      return hit_.effort * w / pi * integrate_sine(pi * from / w, pi * to / w);
    const double ripple = std::cos(pi * (from + to) / w) * std::sin(pi * (to - from) / w);
    return hit_.effort / 2 * (to - from - w / pi * ripple);
  }

  HitGesture hit_;
};

class HoldWave : public Waveform {
 public:
  explicit HoldWave(const HoldGesture& hold) : hold_(hold) {}

  double integrate(double from, double to) override {
    const double top = hold_.start + hold_.rise;
    double sum = hold_.effort * std::max(0.0, to - std::max(from, top));
    const double low = std::clamp(from, hold_.start, top);
    const double high = std::clamp(to, hold_.start, top);
    if (high > low)
      sum += hold_.effort * ((low + high) / 2 - hold_.start) / hold_.rise * (high - low);
    return sum;
  }

  double rise(double, double) override { return 0; }

 private:
  HoldGesture hold_;
};

class StrokeWave : public Waveform {
 public:
  explicit StrokeWave(const StrokeGesture& stroke)
      : amplitude_(stroke.amplitude), omega_(2 * pi * stroke.frequency_hz) {}

  double integrate(double from, double to) override {
    return amplitude_ / omega_ * integrate_sine(omega_ * from, omega_ * to);
  }
  double rise(double from, double to) override {
    return 2 * amplitude_ * std::cos(omega_ * (from + to) / 2) * std::sin(omega_ * (to - from) / 2);
  }

 private:
  double amplitude_, omega_;
};

class RandomWave : public Waveform {
 public:
  RandomWave(const RandomGesture& gesture, std::uint64_t seed)
      : amplitude_(gesture.effort * std::sqrt(2.0 / random_sines)) {
    RandomStream random(seed, gesture_stream);
    const double share = 2 * pi * gesture.bandwidth_hz / random_sines;
    for (std::size_t i = 0; i < random_sines; ++i) {
      omega_[i] = share * (static_cast<double>(i) + 1 - random.uniform());  // above zero
      phase_[i] = 2 * pi * random.uniform();
    }
  }

  double integrate(double from, double to) override {
    double sum = 0;
    for (std::size_t i = 0; i < random_sines; ++i) {
      const double w = omega_[i];
      sum += integrate_sine(w * from + phase_[i], w * to + phase_[i]) / w;
    }
    return amplitude_ * sum;
  }

  double rise(double, double) override { return 0; }

 private:
  double amplitude_;
  std::array<double, random_sines> omega_{}, phase_{};
};

class RecordedWave : public Waveform {
 public:
  explicit RecordedWave(RecordedGesture recorded) : data_(std::move(recorded)) {
    const double first = data_.time.front();
    for (double& t : data_.time) t -= first;
  }

  double integrate(double from, double to) override {
    double sum = 0;
    seek(from);
    for (double at = from; at < to;) {
      const bool after = at_ + 1 >= data_.time.size();
      const double end = after ? to : std::min(to, data_.time[at_ + 1]);
      sum += (value(at) + value(end)) / 2 * (end - at);
      if (!after && end == data_.time[at_ + 1]) ++at_;
      at = end;
    }
    return sum;
  }

  double rise(double from, double to) override {
    seek(from);
    const double before = value(from);
    seek(to);
    return value(to) - before;
  }

 private:
  // To the piece that holds `t`, forwards or back: a motion is asked for both ends of each period.
  void seek(double t) {
    const auto next = std::upper_bound(data_.time.begin(), data_.time.end(), t);
    at_ = next == data_.time.begin() ? 0 : static_cast<std::size_t>(next - data_.time.begin()) - 1;
  }

  // Within the current piece.
  double value(double t) const {
    if (at_ + 1 >= data_.time.size()) return data_.value.back();
    const double share = (t - data_.time[at_]) / (data_.time[at_ + 1] - data_.time[at_]);
    return data_.value[at_] + share * (data_.value[at_ + 1] - data_.value[at_]);
  }

  RecordedGesture data_;
  std::size_t at_ = 0;
};

std::unique_ptr<Waveform> make_wave(const Gesture& gesture, std::uint64_t seed) {
  if (const auto* hit = std::get_if<HitGesture>(&gesture)) return std::make_unique<HitWave>(*hit);
  if (const auto* hold = std::get_if<HoldGesture>(&gesture))
    return std::make_unique<HoldWave>(*hold);
  if (const auto* stroke = std::get_if<StrokeGesture>(&gesture))
    return std::make_unique<StrokeWave>(*stroke);
  if (const auto* random = std::get_if<RandomGesture>(&gesture))
    return std::make_unique<RandomWave>(*random, seed);
  return std::make_unique<RecordedWave>(std::get<RecordedGesture>(gesture));
}

}  // namespace

bool is_motion(const Gesture& gesture) {
  if (const auto* stroke = std::get_if<StrokeGesture>(&gesture)) return stroke->is_motion;
  const auto* recorded = std::get_if<RecordedGesture>(&gesture);
  return recorded && recorded->is_motion;
}

RunningGesture::RunningGesture(const HandGesture& gesture, std::uint64_t seed)
    : wave_(make_wave(gesture.gesture, seed)),
      is_motion_(gyrator::is_motion(gesture.gesture)),
      stiffness_(gesture.stiffness),
      damping_(gesture.damping) {}

double RunningGesture::mean_effort(double from, double to, double length) {
  if (!is_motion_) return wave_->integrate(from, to) / length;
  return (stiffness_ * wave_->integrate(from, to) + damping_ * wave_->rise(from, to)) / length;
}

}  // namespace gyrator
