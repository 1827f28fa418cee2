// Cost of a verdict and of a Z-width boundary, inside the process.
#include "gyrator/passivity/verdict.hpp"

#include <benchmark/benchmark.h>

#include "reference_models.hpp"

namespace {

using namespace gyrator;

PassivityModel make_model(double stiffness) {
  return {bench::make_rc_display(), VirtualWall{stiffness, 1.5e-4}, Sampling{}, 0};
}

void verdict_passive(benchmark::State& state) {
  for (auto _ : state) benchmark::DoNotOptimize(judge_passivity(make_model(0.05)).passive);
}
void verdict_with_counterexample(benchmark::State& state) {
  for (auto _ : state) benchmark::DoNotOptimize(judge_passivity(make_model(0.4)).counterexample);
}
void boundary_of_200_points(benchmark::State& state, Criterion criterion) {
  for (auto _ : state) {
    StiffnessLimits limits(bench::make_rc_display(), Sampling{}, DifferenceEstimator{},
                           FreeOperator{});
    for (int i = 0; i < 200; ++i) benchmark::DoNotOptimize(limits.find(criterion, i * 3e-6));
  }
}

// What one Monte Carlo sample costs: a device not met before, one stiffness limit.
void limit_of_a_new_device(benchmark::State& state) {
  for (auto _ : state) {
    StiffnessLimits limits(bench::make_rc_display(), Sampling{}, DifferenceEstimator{},
                           FreeOperator{});
    benchmark::DoNotOptimize(limits.find(Criterion::exact_disk, 1.5e-4));
  }
}

BENCHMARK(limit_of_a_new_device)->Unit(benchmark::kMillisecond);
BENCHMARK(verdict_passive)->Unit(benchmark::kMillisecond);
BENCHMARK(verdict_with_counterexample)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(boundary_of_200_points, exact_disk, Criterion::exact_disk)
    ->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(boundary_of_200_points, coupled, Criterion::coupled)
    ->Unit(benchmark::kMillisecond);

}  // namespace

BENCHMARK_MAIN();
