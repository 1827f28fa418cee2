// Cost of a controller's step: every law, and every wrapper around a wall.
#include <cmath>

#include <benchmark/benchmark.h>

#include "../tests/support/law_list.hpp"

namespace gyrator {
namespace {

constexpr double T = 1e-3;

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

}  // namespace
}  // namespace gyrator

int main(int argc, char** argv) {
  for (const auto& named : gyrator::testing::make_controller_list())
    benchmark::RegisterBenchmark(named.name.c_str(), gyrator::step, named.controller);
  benchmark::Initialize(&argc, argv);
  benchmark::RunSpecifiedBenchmarks();
}
