#include "gyrator/tuning/tuning_run.hpp"

#include "gyrator/core/error.hpp"
#include "gyrator/twin/twin_bench.hpp"

#include <algorithm>
#include <tuple>

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
    EXPECT_NEAR(step.measured_damping, step.modelled_damping, 0.05 * step.modelled_damping);
  }
  // The generator's steps are accounted for, up to the highest sine.
  for (const MeasuredPoint& point : run.verdict->points) {
    const double circuit = point.modelled_impedance.real() - drive.b;
    EXPECT_NEAR(point.impedance.real() - drive.b, circuit, 0.05 * circuit + 1e-6)
        << point.frequency_hz;
    EXPECT_LT(std::abs(point.actuation / point.modelled_actuation - 1.0), 0.01);
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

// Remembers what was written, in order.
class RememberingBench : public TwinBench {
 public:
  using TwinBench::TwinBench;
  void write_setting(std::string_view name, double value) override {
    TwinBench::write_setting(name, value);
    writes.emplace_back(name);
  }
  std::vector<std::string> writes;
};

TEST(TuningRun, ABranchThatWasConnectedIsClosedOnAllOfItsValues) {
  const MotorDrive drive;
  SimulatedAmplifier amplifier(make_twin(drive));
  RememberingBench bench(amplifier);
  amplifier.write("damping_resistance", 33);
  amplifier.write("damping_connected", 1);
  const auto before = read_all(bench);
  TuningOptions options;
  options.on_step = [&](const TuningStep&) { amplifier.write("temperature_limit", 250); };
  EXPECT_THROW(tune(bench, make_identified(drive, 0.1, 4e-4), options), Error);
  EXPECT_TRUE(equal(read_all(bench), before));
  ASSERT_FALSE(bench.writes.empty());
  EXPECT_EQ(bench.writes.front(), "damping_connected");  // off
  const auto last_value =
      std::find(bench.writes.rbegin(), bench.writes.rend(), "damping_resistance");
  ASSERT_NE(last_value, bench.writes.rend());
  EXPECT_EQ(std::count(bench.writes.rbegin(), last_value, "damping_connected"), 1);
  EXPECT_EQ(bench.writes.back(), "damping_connected");
}

TEST(TuningRun, AModelOfAnotherMotorStopsItBeforeTheFirstStep) {
  const MotorDrive drive;
  for (const auto& [K, J, word] :
       {std::tuple(2.0, 2.0, "torque constant"), std::tuple(0.8, 1.0, "torque constant"),
        std::tuple(1.0, 2.5, "inertia"), std::tuple(1.0, 0.4, "inertia")}) {
    SimulatedAmplifier amplifier(make_twin(drive));
    TwinBench bench(amplifier);
    const auto before = read_all(bench);
    MotorDrive wrong = drive;
    wrong.K *= K;
    wrong.J *= J;
    const TuningRun run = tune(bench, make_identified(wrong, 0.1, 4e-4), {});
    EXPECT_EQ(run.outcome, TuningOutcome::stopped);
    EXPECT_NE(run.explanation.find(word), std::string::npos) << run.explanation;
    EXPECT_TRUE(run.steps.empty());
    EXPECT_TRUE(equal(read_all(bench), before));
  }
}

// An amplifier whose register promises what its circuit does not do.
class LyingBench : public TwinBench {
 public:
  LyingBench(SimulatedAmplifier& amplifier, double factor)
      : TwinBench(amplifier), factor_(factor) {}
  void write_setting(std::string_view name, double value) override {
    TwinBench::write_setting(name, name == "cancellation_resistance" ? factor_ * value : value);
  }

 private:
  double factor_;
};

TEST(TuningRun, ACircuitThatDoesMoreThanItsRegisterSaysIsSeenBeforeItIsUnstable) {
  const MotorDrive drive;
  SimulatedAmplifier amplifier(make_twin(drive));
  LyingBench bench(amplifier, 1.25);
  TuningOptions options;
  options.target.circuit = TuningCircuit::cancellation;
  options.target.cancellation = 0.85;  // in truth 106 %
  double most = 0;
  options.on_step = [&](const TuningStep&) {
    most = std::max(most, bench.read_setting("cancellation_resistance"));
  };
  const TuningRun run = tune(bench, make_identified(drive, 0.1, 0), options);
  EXPECT_EQ(run.outcome, TuningOutcome::stopped) << run.explanation;
  EXPECT_EQ(amplifier.faults(), 0U);
  EXPECT_LT(most, drive.R);  // it never was
  EXPECT_EQ(bench.read_setting("cancellation_resistance"), 0);
}

TEST(TuningRun, AShareAboveTheMostAllowedIsBounded) {
  const MotorDrive drive;
  SimulatedAmplifier amplifier(make_twin(drive));
  TwinBench bench(amplifier);
  TuningOptions options;
  options.target.circuit = TuningCircuit::cancellation;
  options.target.cancellation = 1.1;
  const TuningRun run = tune(bench, make_identified(drive, 0.1, 0), options);
  EXPECT_EQ(run.outcome, TuningOutcome::reached) << run.explanation;
  EXPECT_NEAR(bench.read_setting("cancellation_resistance"), 0.85 * drive.R, 0.02 * drive.R);
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
