// Cost of one step of each law that simulates an environment, in the loop and behind an update.
#include "gyrator/controllers/controller.hpp"

#include <cmath>
#include <vector>

#include <benchmark/benchmark.h>

namespace {

using namespace gyrator;

constexpr double period = 1e-3;

// In and out of contact, at 2 Hz.
std::vector<double> make_samples() {
  std::vector<double> samples;
  for (int k = 0; k < 4096; ++k) samples.push_back(0.01 * std::sin(2 * M_PI * k / 512));
  return samples;
}

void run_steps(benchmark::State& state, const Law& law) {
  const std::vector<double> samples = make_samples();
  RunningController run(Controller(law, {}), period);
  std::size_t k = 0;
  for (auto _ : state) {
    benchmark::DoNotOptimize(run.step(samples[k]));
    k = (k + 1) % samples.size();
  }
}

VirtualCoupling make_coupling(Integration integration, bool slow) {
  VirtualCoupling law;
  law.coupling = {300, 0.2};
  law.tool_inertia = 0.01;
  law.wall = ToolWall{{2000, 1}, 0, true};
  law.integration = integration;
  if (slow) law.update = {.period = Rational(1, 60), .delay = Rational(1, 100), .loss = 0.1};
  return law;
}

DeformableScene make_scene(Integration integration, bool slow) {
  DeformableScene scene;
  scene.object = {1, {300, 0.06}, 0};
  scene.contact = {300, 0.06};
  scene.integration = integration;
  if (slow) scene.update = {.period = Rational(1, 30), .delay = Rational(1, 100), .loss = 0.1};
  return scene;
}

ProxyRendering make_proxy(bool slow, int substeps = 1) {
  ProxyRendering law{make_scene(Integration::implicit, slow), 1e-4, {300, 0.06}};
  law.scene.substeps = substeps;
  return law;
}

constexpr auto semi = Integration::semi_implicit;
constexpr auto implicit = Integration::implicit;

BENCHMARK_CAPTURE(run_steps, wall, VirtualWall{300, 0.2});
BENCHMARK_CAPTURE(run_steps, coupling_in_loop, make_coupling(semi, false));
BENCHMARK_CAPTURE(run_steps, coupling_in_loop_implicit, make_coupling(implicit, false));
BENCHMARK_CAPTURE(run_steps, coupling_slow, make_coupling(semi, true));
BENCHMARK_CAPTURE(run_steps, direct_in_loop, DirectRendering{make_scene(semi, false)});
BENCHMARK_CAPTURE(run_steps, direct_slow, DirectRendering{make_scene(semi, true)});
BENCHMARK_CAPTURE(run_steps, proxy_in_loop_implicit, make_proxy(false));
BENCHMARK_CAPTURE(run_steps, proxy_slow_implicit, make_proxy(true));
BENCHMARK_CAPTURE(run_steps, proxy_slow_64_substeps, make_proxy(true, 64));
BENCHMARK_CAPTURE(run_steps, equivalent_in_loop, EquivalentImpedance{make_scene(semi, false)});
BENCHMARK_CAPTURE(run_steps, equivalent_slow, EquivalentImpedance{make_scene(semi, true)});

}  // namespace

BENCHMARK_MAIN();
