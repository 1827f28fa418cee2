#include "gyrator/identification/identification.hpp"

#include "gyrator/core/error.hpp"
#include "gyrator/identification/experiments.hpp"

#include <cmath>
#include <numbers>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "support/motor_bench.hpp"

namespace gyrator {
namespace {

// Converters of 12 bits, a fifth of a percent of noise, 4096 steps per turn.
BenchMotor make_noisy_motor() {
  BenchMotor motor;
  motor.current_noise = 0.002 * motor.current_limit;
  motor.voltage_noise = 0.002 * motor.voltage_limit;
  motor.velocity_noise = 2;
  motor.current_quantum = motor.current_limit / 2048;
  motor.voltage_quantum = motor.voltage_limit / 2048;
  motor.position_quantum = 2 * std::numbers::pi / 4096;
  return motor;
}

void expect_covers(const Identification& found, const std::string& name, double truth) {
  const IdentifiedParameter& p = found.find(name);
  ASSERT_TRUE(p.value && p.low && p.high) << name;
  EXPECT_TRUE(p.identifiable) << name << ": " << p.note;
  EXPECT_LE(*p.low, truth) << name;
  EXPECT_GE(*p.high, truth) << name;
}

void expect_unknown(const Identification& found, const std::string& name,
                    const std::string& words) {
  const IdentifiedParameter& p = found.find(name);
  EXPECT_FALSE(p.identifiable) << name;
  EXPECT_NE(p.note.find(words), std::string::npos) << name << ": " << p.note;
}

TEST(Identification, WithoutNoiseEveryParameterIsFoundToAThousandth) {
  BenchMotor motor;
  motor.position_quantum = 2 * std::numbers::pi / 16000;
  MotorBench bench(motor);
  const Identification found = identify(bench);
  const auto error = [&](const char* name, double truth) {
    return std::abs(*found.find(name).value / truth - 1);
  };
  EXPECT_LT(error("resistance", motor.resistance), 1e-3);
  EXPECT_LT(error("inductance", motor.inductance), 1e-3);
  EXPECT_LT(error("torque_constant", motor.torque_constant), 1e-3);
  EXPECT_LT(error("inertia", motor.inertia), 1e-3);
  EXPECT_LT(error("damping", motor.damping), 1e-2);
  EXPECT_LT(error("coulomb_friction", motor.coulomb_friction), 1e-2);
  EXPECT_LT(error("bandwidth", motor.bandwidth_hz), 1e-3);
  EXPECT_LT(error("delay", motor.delay), 1e-3);
}

TEST(Identification, ResistanceIsReferredToRoomTemperatureAndTheMeasuredOneKept) {
  const BenchMotor motor = make_noisy_motor();
  MotorBench bench(motor);
  const Identification found = identify(bench);
  expect_covers(found, "resistance", motor.resistance);
  expect_covers(found, "resistance_as_measured",
                motor.resistance * (1 + 0.00393 * (found.winding_temperature - 298.15)));
  EXPECT_GT(found.winding_temperature, 305);
}

TEST(Identification, WithoutATemperatureTheResistanceIsThatOfTheDay) {
  const BenchMotor motor = make_noisy_motor();
  BenchOffer offer;
  offer.temperature = false;
  MotorBench bench(motor, offer);
  const Identification found = identify(bench);
  EXPECT_NE(found.find("resistance").note.find("as measured"), std::string::npos);
  MotorBench same(motor);
  const double temperature = identify(same).winding_temperature;
  expect_covers(found, "resistance", motor.resistance * (1 + 0.00393 * (temperature - 298.15)));
}

TEST(Identification, SensorOffsetsDoNotMatter) {
  BenchMotor motor = make_noisy_motor();
  motor.current_offset = 0.02;
  motor.voltage_offset = -0.1;
  MotorBench bench(motor);
  const Identification found = identify(bench);
  expect_covers(found, "torque_constant", motor.torque_constant);
  expect_covers(found, "inertia", motor.inertia);
  expect_covers(found, "coulomb_friction", motor.coulomb_friction);
  expect_covers(found, "resistance", motor.resistance);
}

TEST(Identification, WithoutTheCommandBandwidthAndDelayAreUnknown) {
  const BenchMotor motor = make_noisy_motor();
  BenchOffer offer;
  offer.command = false;
  MotorBench bench(motor, offer);
  const Identification found = identify(bench);
  expect_unknown(found, "bandwidth", "command");
  expect_unknown(found, "delay", "command");
  expect_covers(found, "resistance", motor.resistance);
  expect_covers(found, "inductance", motor.inductance);
  expect_covers(found, "inertia", motor.inertia);
}

TEST(Identification, TheVelocityServesWhereThereIsNoPosition) {
  const BenchMotor motor = make_noisy_motor();
  BenchOffer offer;
  offer.position = false;
  MotorBench bench(motor, offer);
  const Identification found = identify(bench);
  expect_covers(found, "inertia", motor.inertia);
  expect_covers(found, "torque_constant", motor.torque_constant);
  expect_covers(found, "coulomb_friction", motor.coulomb_friction);
}

TEST(Identification, ThePositionServesWhereThereIsNoVelocity) {
  const BenchMotor motor = make_noisy_motor();
  BenchOffer offer;
  offer.velocity = false;
  MotorBench bench(motor, offer);
  const Identification found = identify(bench);
  for (const char* name : {"resistance", "inductance", "torque_constant", "inertia", "damping"})
    EXPECT_TRUE(found.find(name).identifiable) << name;
  expect_covers(found, "inductance", motor.inductance);
}

TEST(Identification, WithoutAnyMotionSensorTheMotorIsNotSetInMotion) {
  const BenchMotor motor = make_noisy_motor();
  BenchOffer offer;
  offer.velocity = offer.position = false;
  MotorBench bench(motor, offer);
  const Identification found = identify(bench);
  expect_unknown(found, "inertia", "no sensor sees it");
  EXPECT_TRUE(found.windows.empty());
  for (const Experiment& experiment : found.experiments)
    EXPECT_GE(experiment.excitation.frequency_hz, 30);
}

TEST(Identification, AHeldRotorHasNoInertiaButAWinding) {
  BenchMotor motor = make_noisy_motor();
  motor.coulomb_friction = 10;
  MotorBench bench(motor);
  const Identification found = identify(bench);
  expect_covers(found, "resistance", motor.resistance);
  expect_covers(found, "inductance", motor.inductance);
  expect_unknown(found, "inertia", "move");
  expect_unknown(found, "coulomb_friction", "move");
  expect_unknown(found, "torque_constant", "back-EMF");
}

TEST(Identification, FrictionBelowTheNoiseIsNotIdentifiable) {
  BenchMotor motor = make_noisy_motor();
  motor.coulomb_friction = 1e-9;
  motor.damping = 1e-10;
  MotorBench bench(motor);
  const Identification found = identify(bench);
  expect_unknown(found, "coulomb_friction", "noise");
  expect_unknown(found, "damping", "noise");
  EXPECT_LE(*found.find("coulomb_friction").low, motor.coulomb_friction);
  EXPECT_GE(*found.find("coulomb_friction").high, motor.coulomb_friction);
  expect_covers(found, "inertia", motor.inertia);
}

TEST(Identification, ASlowDeviceDoesNotSeeAFastAmplifier) {
  BenchMotor motor = make_noisy_motor();
  motor.bandwidth_hz = 5000;
  motor.delay = 0;
  BenchOffer offer;
  offer.shortest_period = 5e-3;
  MotorBench bench(motor, offer);
  IdentificationOptions options;
  const Identification found = identify(bench, options);
  EXPECT_FALSE(found.find("inductance").identifiable);
  EXPECT_FALSE(found.find("bandwidth").identifiable);
}

TEST(Identification, StaysWithinTheLimits) {
  for (const double speed : {0.0, 100.0}) {
    BenchMotor motor = make_noisy_motor();
    motor.velocity_limit = speed;
    MotorBench bench(motor);
    identify(bench);
    EXPECT_LE(bench.peak_current, 0.35 * motor.current_limit);
    EXPECT_LE(bench.peak_voltage, motor.voltage_limit);
    if (speed > 0) {
      EXPECT_LE(bench.peak_velocity, speed);
    }
  }
}

TEST(Identification, SettingsThatDisturbAreSwitchedOffAndPutBack) {
  MotorBench bench(make_noisy_motor());
  bench.settings = {{"cancellation_resistance", 1.2},
                    {"damping_connected", 1},
                    {"back_emf_damping", 0},
                    {"damping_resistance", 5}};
  identify(bench);
  const std::vector<std::pair<std::string, double>> expected{{"cancellation_resistance", 0},
                                                             {"damping_connected", 0},
                                                             {"damping_connected", 1},
                                                             {"cancellation_resistance", 1.2}};
  EXPECT_EQ(bench.writes, expected);
}

TEST(Identification, SettingsArePutBackAfterAFaultToo) {
  MotorBench bench(make_noisy_motor());
  bench.settings = {{"damping_connected", 1}};
  bench.fails_at = 7;
  EXPECT_THROW(identify(bench), Error);
  EXPECT_EQ(bench.settings["damping_connected"], 1);
}

TEST(Identification, RefusesABenchWithoutCurrentSines) {
  BenchOffer offer;
  offer.modes = {};
  MotorBench bench(make_noisy_motor(), offer);
  EXPECT_THROW(identify(bench), Error);
}

TEST(Identification, AnEncoderWhoseStepNobodyKnowsIsNotTrustedWhereItStandsStill) {
  BenchMotor motor = make_noisy_motor();
  motor.position_quantum = 2 * std::numbers::pi / 500;
  BenchOffer offer;
  offer.quantum_known = false;
  MotorBench bench(motor, offer);
  const Identification found = identify(bench);
  EXPECT_NEAR(found.position_quantum / motor.position_quantum, 1, 1e-6);
  expect_covers(found, "resistance", motor.resistance);
  expect_covers(found, "inductance", motor.inductance);
  expect_covers(found, "torque_constant", motor.torque_constant);
}

TEST(Identification, TheStepOfAnEncoderIsSeenInItsMoves) {
  std::vector<double> position{0};
  for (const int move : {0, 1, 0, 2, 1, 0, 3, 1, 1, -2, 0, 1})
    position.push_back(position.back() + move * 1e-3);
  EXPECT_NEAR(*find_quantum(position), 1e-3, 1e-12);
  position = {0, 0.7, 1.9, 2.3, 4.1, 5.2, 8.9, 9.4};
  EXPECT_FALSE(find_quantum(position));
  EXPECT_FALSE(find_quantum({1, 1, 1}));
}

TEST(Identification, ThePlanHoldsWhatIsThenPlayed) {
  const BenchMotor motor = make_noisy_motor();
  MotorBench bench(motor);
  const std::vector<PlannedStep> plan = plan_identification(bench.limits(), {});
  const Identification found = identify(bench);
  double planned = 0;
  for (const PlannedStep& step : plan) planned += step.duration;
  EXPECT_LE(found.duration, planned);
  for (const Experiment& experiment : found.experiments) {
    const auto& sine = experiment.excitation;
    bool inside = false;
    for (const PlannedStep& step : plan)
      inside = inside || (step.purpose == experiment.purpose &&
                          std::abs(sine.amplitude) <= step.largest * (1 + 1e-9) &&
                          sine.frequency_hz >= step.lowest_hz * (1 - 1e-9) &&
                          sine.frequency_hz <= step.highest_hz * (1 + 1e-9));
    EXPECT_TRUE(inside) << experiment.purpose << " " << describe(sine);
  }
}

}  // namespace
}  // namespace gyrator
