// Cost of a controller's step.
#include "gyrator/controllers/controller.hpp"

#include <cmath>

#include <benchmark/benchmark.h>

namespace gyrator {
namespace {

constexpr double T = 1e-3;
const VirtualWall wall{.stiffness = 1000, .damping = 2, .unilateral = true};

// A gesture through the surface, 20 Hz.
void step(benchmark::State& state, const Controller& controller) {
  RunningController running(controller, T);
  double gesture[50];
  for (int k = 0; k < 50; ++k) gesture[k] = 1e-3 * std::sin(2 * 3.14159265 * k / 50);
  int k = 0;
  for (auto _ : state) {
    benchmark::DoNotOptimize(running.step(gesture[k]));
    k = k == 49 ? 0 : k + 1;
  }
}

const EventTransient transient{.gain = 1, .decay_time = 0.01, .frequency_hz = 100};
const PredictiveWall predictive{.stiffness = 1000, .damping = 2, .device = {0.3, 1, 0}};

BENCHMARK_CAPTURE(step, virtual_wall, wall);
BENCHMARK_CAPTURE(step, wall_and_simple_passivity_control,
                  Controller(wall, {PassivityControl{.max_damping = 300}}));
BENCHMARK_CAPTURE(step, wall_and_reference_passivity_control,
                  Controller(wall, {PassivityControl{PassivityControl::Observer::reference, 300}}));
BENCHMARK_CAPTURE(step, wall_and_event_transient, Controller(wall, {transient}));
BENCHMARK_CAPTURE(step, predictive_wall, Controller(predictive));

}  // namespace
}  // namespace gyrator

BENCHMARK_MAIN();
