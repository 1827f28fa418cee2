#include "gyrator/twin/simulated_amplifier.hpp"

#include "gyrator/core/error.hpp"

#include <cmath>
#include <string>

#include <gtest/gtest.h>

#include "unit/twin/twin_models.hpp"

namespace gyrator {
namespace {

constexpr double K_t = 0.05, R_m = 1.5, J = 2e-5, b = 1e-4;

Excitation hold(DriveMode mode, double value, double duration) {
  return {ExcitationKind::dc, mode, 0, value, 0, 0, duration};
}

void switch_on(SimulatedAmplifier& amplifier, DriveMode mode) {
  amplifier.write("drive_mode", mode == DriveMode::voltage ? 1 : 0);
  amplifier.write("enable", 1);
}

TEST(SimulatedAmplifier, AConstantCurrentEndsAtTheSpeedOfDampingAndFriction) {
  TwinDevice twin = make_plain_twin();
  twin.device.mechanics.coulomb_friction = 2e-3;
  SimulatedAmplifier amplifier(twin);
  switch_on(amplifier, DriveMode::current);
  amplifier.start(hold(DriveMode::current, 0.4, 10));
  amplifier.advance(8);
  const double steady = (K_t * 0.4 - 2e-3) / b;
  // What is left of the start after 8 s, and the rounding of 80000 ticks.
  const double tolerance = steady * (std::exp(-8 * b / J) + 1e-11);
  EXPECT_NEAR(amplifier.truth().velocity, steady, tolerance);
  EXPECT_NEAR(amplifier.truth().current, 0.4, 1e-12);
  EXPECT_NEAR(amplifier.truth().voltage, R_m * 0.4 + K_t * steady, tolerance);
}

TEST(SimulatedAmplifier, AConstantVoltageEndsAtTheSpeedOfDampingFrictionAndBackEmf) {
  TwinDevice twin = make_plain_twin();
  twin.device.mechanics.coulomb_friction = 2e-3;
  SimulatedAmplifier amplifier(twin);
  switch_on(amplifier, DriveMode::voltage);
  amplifier.start(hold(DriveMode::voltage, 3, 10));
  amplifier.advance(4);
  const double steady = (K_t * 3 / R_m - 2e-3) / (b + K_t * K_t / R_m);
  const double tolerance = 1e-10 * steady;  // 4 s are 300 time constants
  EXPECT_NEAR(amplifier.truth().velocity, steady, tolerance);
  EXPECT_NEAR(amplifier.truth().current, (3 - K_t * steady) / R_m, tolerance / R_m);
}

TEST(SimulatedAmplifier, AWindingWarmsByTheClosedForm) {
  TwinDevice twin = make_plain_twin();
  twin.thermal = {8, 3};
  twin.device.mechanics.damping = 1e-3;
  SimulatedAmplifier amplifier(twin);
  switch_on(amplifier, DriveMode::current);
  amplifier.start(hold(DriveMode::current, 1, 60));
  const double a = copper_temperature_coefficient;
  const double cools = 1 / twin.thermal.resistance - a * R_m;  // [W/K]
  const double rate = cools / twin.thermal.capacity;
  const double steady = R_m / cools;
  for (const double t : {5.0, 20.0, 50.0}) {
    amplifier.advance(t - amplifier.time());
    const double rise = steady * -std::expm1(-rate * t);
    // The amplifier's lag delays the heat by 1.5/w_b; the resistance of a tick is that of its
    // begin.
    const double late = 1.5 / (2 * M_PI * 1000) + SimulatedAmplifier::tick;
    EXPECT_NEAR(amplifier.winding_temperature() - twin.ambient, rise, steady * rate * late);
    const double resistance = R_m * (1 + a * rise);
    EXPECT_NEAR(amplifier.truth().voltage - K_t * amplifier.truth().velocity, resistance,
                1.1 * SimulatedAmplifier::resistance_step * resistance);
  }
  EXPECT_GT(amplifier.plants_built(), 100);
}

TEST(SimulatedAmplifier, AWarmWindingCoolsTowardsTheAmbient) {
  TwinDevice twin = make_plain_twin();
  twin.thermal = {8, 3};
  twin.winding_rise = 20;
  twin.ambient = 303.15;
  SimulatedAmplifier amplifier(twin);
  amplifier.advance(24);
  EXPECT_NEAR(amplifier.winding_temperature(), 303.15 + 20 * std::exp(-1), 1e-9);
}

TEST(SimulatedAmplifier, RestIsSkippedAsIfItHadBeenWaitedFor) {
  TwinDevice twin = make_plain_twin();
  twin.thermal = {8, 3};
  twin.winding_rise = 20;
  SimulatedAmplifier amplifier(twin);
  amplifier.advance(3600);
  EXPECT_EQ(amplifier.time(), 3600);
  EXPECT_NEAR(amplifier.winding_temperature(), twin.ambient, 1e-9);
  EXPECT_EQ(amplifier.plants_built(), 2);
  switch_on(amplifier, DriveMode::current);
  amplifier.start(hold(DriveMode::current, 0.1, 1));
  amplifier.advance(0.1);
  EXPECT_NEAR(amplifier.truth().voltage - K_t * amplifier.truth().velocity, R_m * 0.1, 1e-4);
}

TEST(SimulatedAmplifier, MoreThanFullCancellationTripsAndLessDoesNot) {
  for (const double part : {0.9, 1.1}) {
    TwinDevice twin = make_plain_twin();
    twin.noise.command = 1e-4;  // nothing grows from nothing
    SimulatedAmplifier amplifier(twin);
    amplifier.write("cancellation_resistance", part * R_m);
    switch_on(amplifier, DriveMode::voltage);
    amplifier.advance(5);
    const bool unstable = part > 1;
    EXPECT_EQ(amplifier.faults() != 0, unstable) << part;
    EXPECT_EQ(amplifier.settings().enable, !unstable);
    if (!unstable) continue;
    EXPECT_EQ(amplifier.faults(), 1U << static_cast<unsigned>(TwinFault::instability));
    amplifier.advance(1);  // the shaft coasts with its terminals open
    EXPECT_NEAR(amplifier.truth().current, 0, 1e-9);
  }
}

TEST(SimulatedAmplifier, AnAbsurdCancellationTripsAndLeavesAMotorThatRunsAgain) {
  TwinDevice twin = make_plain_twin();
  twin.noise.command = 1e-4;
  twin.thermal = {8, 3};
  SimulatedAmplifier amplifier(twin);
  amplifier.write("cancellation_resistance", 1e4);  // grows by e^2000 in a tick
  switch_on(amplifier, DriveMode::voltage);
  amplifier.advance(0.1);
  EXPECT_NE(amplifier.faults(), 0U);
  EXPECT_LT(amplifier.winding_temperature(), twin.ambient + 1);
  amplifier.write("clear_fault", 1);
  amplifier.write("cancellation_resistance", 0);
  switch_on(amplifier, DriveMode::current);
  amplifier.start(hold(DriveMode::current, 0.4, 1));
  amplifier.advance(0.5);
  EXPECT_NEAR(amplifier.truth().current, 0.4, 1e-3);
}

TEST(SimulatedAmplifier, AMotorThatCoastsIsNotUnstable) {
  TwinDevice twin = make_plain_twin();
  twin.device.drive.damping.emplace_back(RcDamping{5, 2.2e-3});
  twin.device.mechanics.transmission = Transmission{1, 1e-5, 2e-5};
  SimulatedAmplifier amplifier(twin);
  switch_on(amplifier, DriveMode::current);
  amplifier.start(hold(DriveMode::current, 1, 0.2));
  amplifier.advance(3);
  EXPECT_EQ(describe_faults(amplifier.faults()), "none");
}

TEST(SimulatedAmplifier, EachLimitTripsItsOwnFault) {
  const auto run = [](const char* limit, double value, DriveMode mode, double command,
                      double cancelled = 0) {
    TwinDevice twin = make_plain_twin();
    twin.thermal = {8, 3};
    SimulatedAmplifier amplifier(twin);
    amplifier.write(limit, value);
    amplifier.write("cancellation_resistance", cancelled);
    switch_on(amplifier, mode);
    amplifier.start(hold(mode, command, 10));
    amplifier.advance(10);
    EXPECT_FALSE(amplifier.settings().enable);
    EXPECT_FALSE(amplifier.is_exciting());
    return describe_faults(amplifier.faults());
  };
  EXPECT_EQ(run("current_limit", 0.5, DriveMode::voltage, 3), "overcurrent");
  EXPECT_EQ(run("velocity_limit", 20, DriveMode::current, 0.5), "overspeed");
  EXPECT_EQ(run("temperature_limit", 298.15 + 0.5, DriveMode::current, 0.5), "overtemperature");
  EXPECT_EQ(run("watchdog_period", 0.5, DriveMode::current, 0.01), "watchdog");
  // 2 V and 0.7 ohm cancelled at a current that starts at 2/0.8 A: more than 1.25 times 2 V.
  EXPECT_EQ(run("voltage_limit", 2, DriveMode::voltage, 2, 0.7), "overvoltage");
}

TEST(SimulatedAmplifier, AFaultStaysUntilItIsCleared) {
  TwinDevice twin = make_plain_twin();
  SimulatedAmplifier amplifier(twin);
  amplifier.write("velocity_limit", 20);
  switch_on(amplifier, DriveMode::current);
  amplifier.start(hold(DriveMode::current, 0.5, 1));
  amplifier.advance(1);
  ASSERT_NE(amplifier.faults(), 0U);
  try {
    amplifier.write("enable", 1);
    FAIL() << "enabled with a fault";
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::device);
    EXPECT_NE(std::string(error.what()).find("overspeed"), std::string::npos);
  }
  amplifier.write("clear_fault", 1);
  amplifier.write("velocity_limit", 1000);
  amplifier.write("enable", 1);
  EXPECT_TRUE(amplifier.settings().enable);
}

TEST(SimulatedAmplifier, TheWatchdogSleepsWhereNobodyCouldFeedIt) {
  SimulatedAmplifier amplifier(make_plain_twin());
  amplifier.write("watchdog_period", 0.1);
  amplifier.write("enable", 1);
  amplifier.advance(10, false);
  EXPECT_EQ(amplifier.faults(), 0U);
  amplifier.advance(0.09);
  amplifier.write("watchdog", 1);
  amplifier.advance(0.09);
  EXPECT_EQ(amplifier.faults(), 0U);
  amplifier.advance(0.02);
  EXPECT_EQ(describe_faults(amplifier.faults()), "watchdog");
}

TEST(SimulatedAmplifier, TheCommandIsBoundedByTheLimitOfItsKind) {
  SimulatedAmplifier amplifier(make_plain_twin());
  amplifier.write("current_limit", 0.3);
  switch_on(amplifier, DriveMode::current);
  amplifier.start(hold(DriveMode::current, 1, 1));
  amplifier.advance(0.1);
  EXPECT_NEAR(amplifier.truth().current, 0.3, 1e-12);
}

TEST(SimulatedAmplifier, RefusedWritesChangeNothing) {
  SimulatedAmplifier amplifier(make_plain_twin());
  const TwinSettings before = amplifier.settings();
  EXPECT_THROW(amplifier.write("damping_resistance", -1), Error);
  EXPECT_THROW(amplifier.write("current_limit", -1), Error);
  EXPECT_THROW(amplifier.write("current_limit", std::nan("")), Error);
  EXPECT_THROW(amplifier.write("enable", 0.5), Error);
  EXPECT_THROW(amplifier.write("current", 1), Error);
  EXPECT_THROW(amplifier.write("dampin_resistance", 1), Error);
  EXPECT_EQ(amplifier.settings(), before);
  amplifier.write("enable", 1);
  EXPECT_THROW(amplifier.write("drive_mode", 1), Error);
  EXPECT_EQ(amplifier.settings().drive_mode, DriveMode::current);
}

TEST(SimulatedAmplifier, AWriteThatChangesNoCircuitBuildsNoPlant) {
  SimulatedAmplifier amplifier(make_plain_twin());
  amplifier.write("damping_resistance", 5);
  const long built = amplifier.plants_built();
  amplifier.write("damping_resistance", 5);
  amplifier.write("current_limit", 1);
  amplifier.write("temperature_limit", 350);
  EXPECT_EQ(amplifier.plants_built(), built);
}

TEST(SimulatedAmplifier, SettingsStartWhereTheModelHasThem) {
  TwinDevice twin = make_plain_twin();
  twin.device.drive.amplifier = VoltageAmplifier{.bandwidth_hz = 500, .output_resistance = 0.1};
  twin.device.drive.damping = {RcDamping{5, 2.2e-3}, ResistanceCancellation{0.7, 300},
                               BackEmfDamping{1e-3, 1.4, 0, {}, {}}};
  SimulatedAmplifier amplifier(twin);
  EXPECT_EQ(amplifier.read("damping_resistance"), 5);
  EXPECT_EQ(amplifier.read("damping_capacitance"), 2.2e-3);
  EXPECT_EQ(amplifier.read("damping_connected"), 1);
  EXPECT_EQ(amplifier.read("cancellation_resistance"), 0.7);
  EXPECT_EQ(amplifier.read("back_emf_damping"), 1e-3);
  EXPECT_EQ(amplifier.read("back_emf_resistance"), 1.4);
  EXPECT_EQ(amplifier.read("drive_mode"), 1);
  EXPECT_EQ(amplifier.read("enable"), 0);
}

TEST(SimulatedAmplifier, ADeviceThatIsNoAmplifierWithAMotorIsRefused) {
  const auto message_of = [](const TwinDevice& twin) -> std::string {
    try {
      SimulatedAmplifier amplifier(twin);
    } catch (const Error& error) {
      EXPECT_EQ(error.code(), ErrorCode::bad_input);
      return error.what();
    }
    return "accepted";
  };
  TwinDevice ideal = make_plain_twin();
  ideal.device.drive.amplifier = IdealDrive{};
  EXPECT_NE(message_of(ideal).find("amplifier: ideal"), std::string::npos);
  TwinDevice bare = make_plain_twin();
  bare.device.drive.motor.reset();
  EXPECT_NE(message_of(bare).find("motor: missing"), std::string::npos);
  TwinDevice held = make_plain_twin();
  held.device.drive.damping.emplace_back(HeldImpedance{0.4, 1e-3, {}});
  EXPECT_NE(message_of(held).find("damping/0: held_impedance"), std::string::npos);
  TwinDevice noisy = make_plain_twin();
  noisy.noise.current = -1;
  EXPECT_NE(message_of(noisy).find("current noise"), std::string::npos);
}

}  // namespace
}  // namespace gyrator
