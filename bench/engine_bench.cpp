// Cost of the sampled loop per sample, by engine: one second at 1 kHz, spring wall, no trace.
#include "gyrator/cosim/simulation.hpp"

#include <benchmark/benchmark.h>

#include "reference_models.hpp"

namespace {

using namespace gyrator;

void run_loop(benchmark::State& state, EngineKind engine, bool ledger, bool record,
              const Device& device) {
  const Plant plant = build_plant(build_device_network(device, FreeOperator{}));
  SimulationOptions options;
  options.duration = Rational(1);
  options.initial_velocity = 1;
  options.engine = engine;
  options.engine_options.ledger = ledger;
  options.record = record;
  long samples = 0;
  for (auto _ : state) {
    const TimeRun run = simulate(plant, Sensor{}, VirtualWall{0.05, 0}, Sampling{}, options);
    samples += run.steps;
    benchmark::DoNotOptimize(run.energy.residual);
  }
  state.counters["per_sample"] = benchmark::Counter(
      static_cast<double>(samples), benchmark::Counter::kIsRate | benchmark::Counter::kInvert);
  state.counters["states"] = static_cast<double>(plant.states());
}

// The same with a quantized sensor, and dry friction that sticks.
void run_contact_loop(benchmark::State& state, EngineKind engine, bool ledger, bool record) {
  Device device = bench::make_rc_display();
  device.mechanics.coulomb_friction = 1e-3;
  device.mechanics.stiction = 1.5e-3;
  long samples = 0;
  for (auto _ : state) {
    // Plant and modes are part of what a run costs.
    const Plant plant = build_moving_plant(build_device_network(device, FreeOperator{}));
    SimulationOptions options;
    options.duration = Rational(1);
    options.initial_velocity = 1;
    options.external_effort = 4e-3;
    options.engine = engine;
    options.engine_options.ledger = ledger;
    options.record = record;
    const TimeRun run =
        simulate(plant, Sensor{.quantum = 2e-4}, VirtualWall{0.05, 1e-4}, Sampling{}, options);
    samples += run.steps;
    benchmark::DoNotOptimize(run.energy.residual);
  }
  state.counters["per_sample"] = benchmark::Counter(
      static_cast<double>(samples), benchmark::Counter::kIsRate | benchmark::Counter::kInvert);
}

const Device four = bench::make_rc_display();
const Device six = bench::make_compliant_display();

BENCHMARK_CAPTURE(run_loop, exact_4_states, EngineKind::exact, false, false, four);
BENCHMARK_CAPTURE(run_loop, exact_4_states_ledger, EngineKind::exact, true, false, four);
BENCHMARK_CAPTURE(run_loop, exact_4_states_ledger_trace, EngineKind::exact, true, true, four);
BENCHMARK_CAPTURE(run_loop, exact_6_states, EngineKind::exact, false, false, six);
BENCHMARK_CAPTURE(run_loop, exact_6_states_ledger, EngineKind::exact, true, false, six);
BENCHMARK_CAPTURE(run_contact_loop, exact_stiction, EngineKind::exact, false, false);
BENCHMARK_CAPTURE(run_contact_loop, exact_stiction_ledger_trace, EngineKind::exact, true, true);
BENCHMARK_CAPTURE(run_contact_loop, cvode_stiction, EngineKind::cvode, false, false);
BENCHMARK_CAPTURE(run_contact_loop, cvode_stiction_ledger_trace, EngineKind::cvode, true, true);
BENCHMARK_CAPTURE(run_loop, cvode_4_states, EngineKind::cvode, false, false, four);
BENCHMARK_CAPTURE(run_loop, cvode_4_states_ledger, EngineKind::cvode, true, false, four);
BENCHMARK_CAPTURE(run_loop, odeint_4_states, EngineKind::odeint, false, false, four);
BENCHMARK_CAPTURE(run_loop, odeint_4_states_ledger, EngineKind::odeint, true, false, four);

}  // namespace

BENCHMARK_MAIN();
