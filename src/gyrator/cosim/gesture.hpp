#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <variant>
#include <vector>

namespace gyrator {

// What a hand wants over time: a force that it exerts, or a motion that it intends and that acts
// through its spring and damper. Forces are zero and motions at position zero before the start.

/// Pulses of force of width w from each of `times` on [s], and again every `repeat` [s]:
///   half sine       A sin(pi x/w)                  impulse 2 A w / pi                   (hit-1)
///   raised cosine   A (1 - cos(2 pi x/w)) / 2      impulse A w / 2                      (hit-2)
/// x from 0 to w. Pulses that overlap add up; `repeat` is at least w.
struct HitGesture {
  enum class Shape { half_sine, raised_cosine };
  double effort = 0;  ///< A [N, N.m]
  double width = 0;   ///< w [s]
  std::vector<double> times{0};
  std::optional<double> repeat{};
  Shape shape = Shape::half_sine;
};

/// A force that rises linearly from `start` on within `rise` [s] and stays.
struct HoldGesture {
  double effort = 0;  ///< [N, N.m]
  double start = 0, rise = 0;
};

/// A sin(2 pi f t).
struct StrokeGesture {
  double amplitude = 0;  ///< A [N, N.m; m, rad of a motion]
  double frequency_hz = 0;
  bool is_motion = false;
};

/// A force of random phases and even power up to `bandwidth_hz`: 64 sines of equal amplitude, the
/// i-th at a random frequency in the i-th 64th of the band. Its mean square over a long time is
/// effort^2.
struct RandomGesture {
  double effort = 0;  ///< root mean square [N, N.m]
  double bandwidth_hz = 0;
};

/// Samples of a recording, linear in between; the first is at the run's start, after the last it
/// stays.
struct RecordedGesture {
  std::vector<double> time{};  ///< increasing [s]
  std::vector<double> value{};
  bool is_motion = false;
  std::string end_place{};  ///< of the last row, for messages
};

/// The closed list.
using Gesture =
    std::variant<HitGesture, HoldGesture, StrokeGesture, RandomGesture, RecordedGesture>;

/// Whether it is a motion, which needs the hand's spring or damper to act.
bool is_motion(const Gesture& gesture);

/// A gesture with the hand that it acts through; a force needs none.
struct HandGesture {
  Gesture gesture{};
  double stiffness = 0;  ///< k of the hand [N/m, N.m/rad]
  double damping = 0;    ///< b of the hand [N.s/m, N.m.s/rad]
};

/// A curve over time with a closed integral.
class Waveform {
 public:
  Waveform() = default;
  Waveform(const Waveform&) = delete;
  Waveform& operator=(const Waveform&) = delete;
  virtual ~Waveform() = default;
  /// Over [from, to], without the difference of two large numbers.
  virtual double integrate(double from, double to) = 0;
  /// Value at `to` less that at `from`; of motions only.
  virtual double rise(double from, double to) = 0;
};

/// The effort of a gesture at the port, held at its mean over each sampling period:
///   f = 1/L int F dt                                      of a force                 (ges-1)
///   f = 1/L (k int x_h dt + b (x_h(to) - x_h(from)))       of a motion x_h            (ges-2)
/// so that the impulse of each period is exact. A free mass then has the velocity of the gesture
/// itself at every sample instant, and a position off by T^2/12m times the change of the force
/// since the start: second order in T, and gone when the force is back where it began.
class RunningGesture {
 public:
  RunningGesture(const HandGesture& gesture, std::uint64_t seed);

  /// `length` is to - from, exactly [s].
  double mean_effort(double from, double to, double length);

 private:
  std::unique_ptr<Waveform> wave_;
  bool is_motion_;
  double stiffness_, damping_;
};

}  // namespace gyrator
