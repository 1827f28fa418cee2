#include "gyrator/tuning/tuning_run.hpp"

#include "gyrator/core/error.hpp"
#include "gyrator/twin/twin_bench.hpp"

#include <gtest/gtest.h>

#include "unit/tuning/drive_example.hpp"

namespace gyrator {
namespace {

using namespace tuning_example;

TwinDevice make_twin(const MotorDrive& drive) {
  TwinDevice twin;
  twin.device = make_model(drive, DriveMode::current, 0, 0).device;
  twin.device.drive.damping.clear();
  twin.device.mechanics.coulomb_friction = 2e-4;
  twin.noise.current = 2e-3;
  twin.noise.voltage = 5e-3;
  twin.noise.velocity = 0.05;
  twin.position_quantum = 2 * std::numbers::pi / 8192;
  return twin;
}

PassivityModel make_identified(const MotorDrive& drive, double K, double B) {
  PassivityModel model = make_model(drive, DriveMode::current, K, B);
  model.device.drive.damping.clear();
  return model;
}

std::vector<Setting> read_all(Bench& bench) {
  std::vector<Setting> found;
  for (const std::string& name : tuned_settings())
    found.push_back({name, bench.read_setting(name)});
  return found;
}

bool equal(const std::vector<Setting>& a, const std::vector<Setting>& b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(), [](const auto& x, const auto& y) {
    return x.name == y.name && x.value == y.value;
  });
}

TEST(TuningRun, AnRcBranchIsChosenRaisedAndMeasuredPassive) {
  const MotorDrive drive;
  SimulatedAmplifier amplifier(make_twin(drive));
  TwinBench bench(amplifier);
  const PassivityModel model = make_identified(drive, 0.15, 4e-4);
  const TuningRun run = tune(bench, model, {});
  EXPECT_EQ(run.outcome, TuningOutcome::reached) << run.explanation;
  ASSERT_TRUE(run.verdict);
  EXPECT_TRUE(run.verdict->passive);
  EXPECT_GT(run.verdict->max_stiffness_low, 0.15);
  EXPECT_GE(run.choice.max_stiffness, 1.2 * 0.15);
  EXPECT_EQ(bench.read_setting("damping_connected"), 1);
  EXPECT_EQ(bench.read_setting("damping_capacitance"),
            value_of(run.choice.settings, "damping_capacitance"));
  for (const TuningStep& step : run.steps) {
    EXPECT_TRUE(step.stable) << step.remark;
    EXPECT_NEAR(step.measured_damping, step.modelled_damping, 0.1 * step.modelled_damping);
  }
}

TEST(TuningRun, CancellationReachesItsShareOfAWarmingWinding) {
  const MotorDrive drive;
  TwinDevice twin = make_twin(drive);
  twin.winding_rise = 20;
  twin.thermal = {8, 0.5};  // 4 s
  SimulatedAmplifier amplifier(twin);
  TwinBench bench(amplifier);
  TuningOptions options;
  options.target.circuit = TuningCircuit::cancellation;
  options.target.cancellation = 0.85;
  options.watch = 10;
  const TuningRun run = tune(bench, make_identified(drive, 0.15, 0), options);
  EXPECT_EQ(run.outcome, TuningOutcome::reached) << run.explanation;
  const double warm =
      drive.R * (1 + copper_temperature_coefficient * (amplifier.winding_temperature() - 298.15));
  const double share = bench.read_setting("cancellation_resistance") / warm;
  // A step of the setting is 0.7 % of the winding, its measurement is good to 1 %.
  EXPECT_NEAR(share, 0.85, 0.015);
  EXPECT_EQ(amplifier.faults(), 0U);
  EXPECT_GE(run.steps.size(), 4U);
}

TEST(TuningRun, AWallThatNothingCarriesLeavesTheAmplifierAsItWas) {
  const MotorDrive drive;
  SimulatedAmplifier amplifier(make_twin(drive));
  TwinBench bench(amplifier);
  bench.write_setting("damping_resistance", 33);
  const auto before = read_all(bench);
  const TuningRun run = tune(bench, make_identified(drive, 500, 0), {});
  EXPECT_EQ(run.outcome, TuningOutcome::unreachable);
  EXPECT_TRUE(run.steps.empty());
  EXPECT_TRUE(equal(read_all(bench), before));
}

TEST(TuningRun, AModelThatIsWrongStopsAtTheFirstStep) {
  MotorDrive drive;
  SimulatedAmplifier amplifier(make_twin(drive));
  TwinBench bench(amplifier);
  const auto before = read_all(bench);
  drive.K *= 2;
  drive.J *= 2;
  const TuningRun run = tune(bench, make_identified(drive, 0.1, 4e-4), {});
  EXPECT_EQ(run.outcome, TuningOutcome::stopped) << run.explanation;
  EXPECT_TRUE(equal(read_all(bench), before));
}

// The winding turns out colder than anything said: what is left of it must be seen in time.
TEST(TuningRun, AWindingThatCoolsBelowItsShareIsSeenAtTheNextStep) {
  const MotorDrive drive;
  TwinDevice twin = make_twin(drive);
  SimulatedAmplifier amplifier(twin);
  TwinBench bench(amplifier);
  const auto before = read_all(bench);
  TuningOptions options;
  options.target.circuit = TuningCircuit::cancellation;
  options.target.cancellation = 0.85;
  // A share above one would be unstable: refused by the bound on it.
  options.target.cancellation = 1.1;
  const TuningRun run = tune(bench, make_identified(drive, 0.1, 0), options);
  EXPECT_EQ(run.outcome, TuningOutcome::reached) << run.explanation;
  EXPECT_LT(bench.read_setting("cancellation_resistance"), 0.86 * drive.R);
  (void)before;
}

TEST(TuningRun, AFaultPutsTheSettingsBackAndIsTold) {
  const MotorDrive drive;
  TwinDevice twin = make_twin(drive);
  twin.velocity_limit = 30;
  SimulatedAmplifier amplifier(twin);
  TwinBench bench(amplifier);
  const auto before = read_all(bench);
  TuningOptions options;
  options.on_step = [&](const TuningStep&) { amplifier.write("temperature_limit", 250); };
  EXPECT_THROW(tune(bench, make_identified(drive, 0.1, 4e-4), options), Error);
  EXPECT_TRUE(equal(read_all(bench), before));
}

}  // namespace
}  // namespace gyrator
