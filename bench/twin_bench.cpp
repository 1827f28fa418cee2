// How much faster than real time a simulated amplifier runs: device seconds per second.
#include "gyrator/twin/simulated_amplifier.hpp"

#include <benchmark/benchmark.h>

namespace gyrator {
namespace {

TwinDevice make_display(double friction, bool has_branch) {
  TwinDevice twin;
  Device& device = twin.device;
  device.drive.motor = Motor{0.05, 1.5, 0.5e-3};
  device.drive.amplifier = CurrentAmplifier{.bandwidth_hz = 1000};
  if (has_branch) device.drive.damping.emplace_back(RcDamping{5, 2.2e-3});
  device.mechanics.inertia = 2e-5;
  device.mechanics.damping = 1e-4;
  device.mechanics.coulomb_friction = friction;
  twin.delay = 0.13e-3;
  twin.noise = {1e-5, 1e-3, 1e-2, 0.01, 1e-5};
  twin.position_quantum = 1e-4;
  twin.velocity_limit = 1e5;
  return twin;
}

// Commands of a maximal sequence, all signals captured all the time.
void run(benchmark::State& state, const TwinDevice& twin, DriveMode mode) {
  SimulatedAmplifier amplifier(twin);
  amplifier.write("drive_mode", mode == DriveMode::voltage ? 1 : 0);
  amplifier.write("enable", 1);
  constexpr double span = 0.4;  // [s]
  const double amplitude = mode == DriveMode::voltage ? 2 : 0.4;
  const long built = amplifier.plants_built();
  for (auto _ : state) {
    amplifier.arm({0, 1e-4, 4000});
    amplifier.start({ExcitationKind::prbs, mode, amplitude, 0, 500, 0, span});
    amplifier.advance(span);
    benchmark::DoNotOptimize(amplifier.capture().current.data());
  }
  if (amplifier.faults() != 0) state.SkipWithError(describe_faults(amplifier.faults()).c_str());
  state.counters["times_real_time"] = benchmark::Counter(
      span * static_cast<double>(state.iterations()), benchmark::Counter::kIsRate);
  state.counters["plants"] = static_cast<double>(amplifier.plants_built() - built);
}

void current_drive(benchmark::State& state) {
  run(state, make_display(0, false), DriveMode::current);
}
void current_drive_rc_friction(benchmark::State& state) {
  run(state, make_display(2e-3, true), DriveMode::current);
}
void voltage_drive(benchmark::State& state) {
  run(state, make_display(0, false), DriveMode::voltage);
}
void voltage_drive_rc_friction(benchmark::State& state) {
  run(state, make_display(2e-3, true), DriveMode::voltage);
}
BENCHMARK(current_drive);
BENCHMARK(current_drive_rc_friction);
BENCHMARK(voltage_drive);
BENCHMARK(voltage_drive_rc_friction);

// What a change of a setting costs.
void build_plant(benchmark::State& state) {
  const TwinDevice twin = make_display(2e-3, true);
  const TwinSettings settings = find_initial_settings(twin);
  const Device device = make_plant_device(twin, settings, 1.5);
  for (auto _ : state) {
    TwinPlant plant(device, 1e-4, 3e-5);
    plant.advance(0, 0, 0);
    benchmark::DoNotOptimize(plant.current());
  }
}
BENCHMARK(build_plant);

}  // namespace
}  // namespace gyrator

BENCHMARK_MAIN();
