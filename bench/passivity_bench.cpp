// Cost of a verdict and of a Z-width boundary, inside the process.
#include "gyrator/passivity/disk_proof.hpp"
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

// Proved at every frequency: 4 states, 6, and 6 with the sensor behind the transmission.
void proof(benchmark::State& state, const Device& device, const Sampling& sampling) {
  const DiscreteStateSpace law =
      make_contact_law(VirtualWall{0.05, 1.5e-4}, sampling.period.to_double());
  for (auto _ : state) {
    PortModel model(device);
    benchmark::DoNotOptimize(prove_disk(model, sampling, law).margin);
  }
}
void proved_verdict_of_6_states(benchmark::State& state) {
  const PassivityModel model{bench::make_compliant_display(), VirtualWall{0.05, 1.5e-4}, Sampling{},
                             0};
  for (auto _ : state) benchmark::DoNotOptimize(judge_passivity(model).passive);
}
Device make_sensed_at_motor() {
  Device device = bench::make_compliant_display();
  device.sensor = SensorLocation::motor;
  return device;
}
const Sampling part_late{Rational(1, 1000), Rational(37, 100000)};

BENCHMARK_CAPTURE(proof, 4_states, bench::make_rc_display(), Sampling{})
    ->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(proof, 6_states, bench::make_compliant_display(), Sampling{})
    ->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(proof, 6_states_fractional_delay, bench::make_compliant_display(), part_late)
    ->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(proof, 6_states_sensed_at_motor, make_sensed_at_motor(), Sampling{})
    ->Unit(benchmark::kMillisecond);
BENCHMARK(proved_verdict_of_6_states)->Unit(benchmark::kMillisecond);
BENCHMARK(limit_of_a_new_device)->Unit(benchmark::kMillisecond);
BENCHMARK(verdict_passive)->Unit(benchmark::kMillisecond);
BENCHMARK(verdict_with_counterexample)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(boundary_of_200_points, exact_disk, Criterion::exact_disk)
    ->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(boundary_of_200_points, coupled, Criterion::coupled)
    ->Unit(benchmark::kMillisecond);

}  // namespace

BENCHMARK_MAIN();
