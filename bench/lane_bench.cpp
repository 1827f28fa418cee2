// What a sample of one lane costs: over states and lanes, linear and with encoder and unilateral
// wall, by instruction set; and how much of the machine's peak of fused products that is.
//
//   lane_bench --benchmark_filter=lanes       the counter `ns` is per lane and sample

#include "gyrator/lanes/lane_runs.hpp"

#include <string>
#include <vector>

#include <benchmark/benchmark.h>

#include "support/passivity_closed_forms.hpp"

namespace {

using namespace gyrator;

// The RC-damped motor under a mass hung on springs: two states more for each.
Plant make_plant_of(int states) {
  Device device = passivity_tests::make_rc_motor().device;
  if (states < 4) {
    device.drive.amplifier = IdealDrive{};
    device.drive.damping.clear();
  }
  MassSpringDamper hand{.inertia = 1e-6, .damping = 1e-4, .stiffness = 0, .resonators = {}};
  for (int i = 4; i + 1 < states; i += 2)
    hand.resonators.push_back({.inertia = 1e-6, .stiffness = 0.05 * i});
  return build_plant(build_device_network(device, hand));
}

LaneScene make_scene(bool encoder) {
  LaneScene scene;
  scene.sampling = {Rational(1, 1000), Rational(0)};
  scene.sensor.quantum = encoder ? 1e-5 : 0;
  scene.options.duration = Rational(2);
  scene.options.initial_velocity = 1;
  return scene;
}

LaneLaw make_law(double stiffness, bool unilateral) {
  return *find_lane_law(
      Controller(VirtualWall{.stiffness = stiffness, .damping = 1e-4, .unilateral = unilateral}),
      1e-3);
}

void lanes(benchmark::State& state, LaneInstructions instructions, bool shared) {
  if (instructions > find_lane_instructions()) {
    state.SkipWithError("this machine has no such instructions");
    return;
  }
  const bool encoder = state.range(1) != 0;
  const auto count = static_cast<std::size_t>(state.range(2));
  const LaneScene scene = make_scene(encoder);
  const Plant plant = make_plant_of(static_cast<int>(state.range(0)));
  const std::vector<LanePlant> plants(shared ? 1 : count, make_lane_plant(plant, scene.sampling));
  std::vector<LaneLaw> laws;
  for (std::size_t i = 0; i < count; ++i)
    laws.push_back(
        make_law(0.02 + 0.1 * static_cast<double>(i) / static_cast<double>(count), encoder));
  LaneOptions options;
  options.threads = 1;
  options.instructions = instructions;
  for (auto _ : state) {
    benchmark::DoNotOptimize(classify_lanes(
        scene, count,
        [&](std::size_t i, LaneDesign& design) {
          design = {&plants[shared ? 0 : i], laws[i]};
        },
        options));
  }
  state.counters["states"] = static_cast<double>(plant.states());
  state.counters["ns"] = benchmark::Counter(
      static_cast<double>(count) * 2000 * 1e-9,
      benchmark::Counter::kIsIterationInvariantRate | benchmark::Counter::kInvert);
}

void over_states(benchmark::internal::Benchmark* bench) {
  for (const int states : {2, 4, 6, 8, 10, 12}) bench->Args({states, 1, 256});
  bench->Args({4, 0, 256});
}
void over_lanes(benchmark::internal::Benchmark* bench) {
  for (const int count : {1, 4, 16, 64, 256, 1024, 4096}) bench->Args({4, 1, count});
}

BENCHMARK_CAPTURE(lanes, baseline, LaneInstructions::baseline, true)->Apply(over_states);
BENCHMARK_CAPTURE(lanes, avx2, LaneInstructions::avx2, true)->Apply(over_states);
BENCHMARK_CAPTURE(lanes, avx512, LaneInstructions::avx512, true)->Apply(over_states);
BENCHMARK_CAPTURE(lanes, avx2_own_plants, LaneInstructions::avx2, false)->Apply(over_states);
BENCHMARK_CAPTURE(lanes, avx2_over_lanes, LaneInstructions::avx2, true)->Apply(over_lanes);

#if defined(__x86_64__)
// Peak: independent fused products, as many as the pipes and their latency take.
__attribute__((target("avx2,fma"))) void peak(benchmark::State& state) {
  typedef double Four __attribute__((vector_size(32)));
  constexpr int chains = 12;
  Four sums[chains];
  for (int i = 0; i < chains; ++i) sums[i] = Four{} + 1e-3 * i;
  const Four factor = Four{} + 0.999;
  const Four term = Four{} + 1e-3;
  for (auto _ : state) {
    for (int k = 0; k < 1000; ++k) {
#pragma GCC unroll 12
      for (int i = 0; i < chains; ++i) sums[i] = __builtin_ia32_vfmaddpd256(sums[i], factor, term);
    }
    benchmark::DoNotOptimize(sums);
  }
  state.counters["GFLOP/s"] =
      benchmark::Counter(1000.0 * chains * 8 * 1e-9, benchmark::Counter::kIsIterationInvariantRate);
}
BENCHMARK(peak);
#endif

}  // namespace

BENCHMARK_MAIN();
