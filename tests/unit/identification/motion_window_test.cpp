#include "gyrator/identification/motion_window.hpp"

#include "gyrator/core/error.hpp"

#include <cmath>
#include <vector>

#include <gtest/gtest.h>

namespace gyrator {
namespace {

Capture make_capture(double from, double acceleration, double quantum) {
  Capture capture;
  capture.period = 1e-3;
  capture.start = 0.5;
  for (int k = 0; k < 1000; ++k) {
    const double t = k * capture.period;
    const double x = from * t + acceleration * t * t / 2;
    capture.position.push_back(quantum > 0 ? quantum * std::round(x / quantum) : x);
    capture.current.push_back(0.2 + 0.3 * t);
    capture.voltage.push_back(5 - t);
  }
  capture.winding_temperature_before = 300;
  capture.winding_temperature_after = 310;
  return capture;
}

TEST(MotionWindow, MeansOfUniformAccelerationAreExact) {
  const auto windows = find_windows(make_capture(3, 40, 0), {.length = 0.05});
  ASSERT_GT(windows.size(), 30U);
  for (const MotionWindow& window : windows) {
    const double t = window.time - 0.5;
    EXPECT_NEAR(window.acceleration, 40, 1e-6);
    EXPECT_NEAR(window.velocity, 3 + 40 * t, 1e-9);
    EXPECT_NEAR(window.current, 0.2 + 0.3 * t, 1e-9);
    EXPECT_NEAR(window.current_rate, 0.3, 1e-9);
    EXPECT_NEAR(window.voltage, 5 - t, 1e-9);
    EXPECT_NEAR(window.temperature, 300 + 10 * t / 0.999, 1e-6);
    EXPECT_EQ(window.direction, 1);
  }
}

TEST(MotionWindow, TheVelocityServesWherePositionIsMissing) {
  Capture capture = make_capture(3, 40, 0);
  capture.position.clear();
  for (int k = 0; k < 1000; ++k) capture.velocity.push_back(3 + 40 * k * capture.period);
  const auto windows = find_windows(capture, {.length = 0.05});
  EXPECT_NEAR(windows[10].velocity, 3 + 40 * (windows[10].time - 0.5), 1e-9);
  EXPECT_NEAR(windows[10].acceleration, 40, 1e-6);
}

// -10 + 40 t turns at 0.25 s.
TEST(MotionWindow, OnlyWhatMovesOneWayThroughoutHasADirection) {
  const auto windows =
      find_windows(make_capture(-10, 40, 1e-3), {.length = 0.05, .least_velocity = 0.5});
  for (const MotionWindow& window : windows) {
    const double t = window.time - 0.5;
    // A window reaches 0.025 s to either side.
    const int expected = t < 0.2 ? -1 : t > 0.3 ? 1 : 0;
    if (t < 0.2 || t > 0.3 || (t > 0.23 && t < 0.27)) {
      EXPECT_EQ(window.direction, expected) << t;
    }
  }
}

TEST(MotionWindow, RefusesACaptureWithoutMotion) {
  Capture capture = make_capture(1, 0, 0);
  capture.position.clear();
  EXPECT_THROW(find_windows(capture, {}), Error);
}

}  // namespace
}  // namespace gyrator
