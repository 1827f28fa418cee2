#include "gyrator/amplifiers/settings_guard.hpp"

#include "gyrator/amplifiers/amplifier_session.hpp"
#include "gyrator/amplifiers/modbus_bench.hpp"
#include "gyrator/core/error.hpp"

#include <algorithm>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "support/motor_bench.hpp"
#include "support/profile_bank.hpp"

namespace gyrator {
namespace {

using Writes = std::vector<std::pair<std::string, double>>;

const std::vector<std::string> values{"damping_connected", "damping_resistance",
                                      "damping_capacitance", "back_emf_resistance"};

// A branch and a cancellation are on; there is no back_emf_resistance.
struct DampedBench : MotorBench {
  DampedBench() : MotorBench(BenchMotor{}) {
    settings = {{"cancellation_resistance", 1.2},
                {"damping_connected", 1},
                {"back_emf_damping", 0},
                {"damping_resistance", 5},
                {"damping_capacitance", 1e-3}};
  }
  void write_setting(std::string_view name, double value) override {
    if (name == fails) throw Error(ErrorCode::device, std::string(name), "lost");
    MotorBench::write_setting(name, value);
    if (name == loses_answer) {
      loses_answer.clear();
      throw Error(ErrorCode::device, std::string(name), "no answer in time");
    }
  }
  std::string fails;
  std::string loses_answer;  // of one write, which acts
};

// What a tuning leaves half done.
void tune_otherwise(Bench& bench) {
  bench.write_setting("damping_resistance", 8);
  bench.write_setting("damping_connected", 1);
  bench.write_setting("damping_capacitance", 2e-3);
}

const Writes back_as_it_was{{"damping_connected", 0},
                            {"damping_resistance", 5},
                            {"damping_capacitance", 1e-3},
                            {"damping_connected", 1},
                            {"cancellation_resistance", 1.2}};

TEST(SettingsGuard, SwitchesOffOnlyWhatIsOn) {
  DampedBench bench;
  const SettingsGuard guard(bench, values);
  EXPECT_EQ(bench.writes, (Writes{{"cancellation_resistance", 0}, {"damping_connected", 0}}));
}

TEST(SettingsGuard, PutsValuesBackBeforeItClosesTheSwitchesInReverse) {
  DampedBench bench;
  const auto before = bench.settings;
  SettingsGuard guard(bench, values);
  tune_otherwise(bench);
  bench.writes.clear();
  guard.put_back();
  EXPECT_EQ(bench.writes, back_as_it_was);
  EXPECT_EQ(bench.settings, before);
}

TEST(SettingsGuard, DoesSoTooWhereAnExceptionEndsTheWork) {
  DampedBench bench;
  try {
    const SettingsGuard guard(bench, values);
    tune_otherwise(bench);
    bench.writes.clear();
    throw Error(ErrorCode::device, "bench", "overcurrent");
  } catch (const Error&) {
    EXPECT_EQ(bench.writes, back_as_it_was);
  }
}

TEST(SettingsGuard, LeavesWhatIsToBeKept) {
  DampedBench bench;
  {
    SettingsGuard guard(bench, values);
    tune_otherwise(bench);
    guard.keep();
  }
  EXPECT_EQ(bench.settings["damping_resistance"], 8);
  EXPECT_EQ(bench.settings["cancellation_resistance"], 0);
}

TEST(SettingsGuard, PutsBackWhatItHasSwitchedOffWhereTheNextCannotBe) {
  DampedBench bench;
  bench.settings["back_emf_damping"] = 0.1;
  const auto before = bench.settings;
  bench.fails = "back_emf_damping";
  EXPECT_THROW(SettingsGuard(bench, values), Error);
  EXPECT_EQ(bench.settings, before);
}

TEST(SettingsGuard, PutsBackWhatWasSwitchedOffAlthoughTheAnswerWasLost) {
  for (const char* name : {"cancellation_resistance", "damping_connected", "back_emf_damping"}) {
    DampedBench bench;
    bench.settings["back_emf_damping"] = 0.1;
    const auto before = bench.settings;
    bench.loses_answer = name;
    EXPECT_THROW(SettingsGuard(bench, values), Error);
    EXPECT_EQ(bench.settings, before) << name;
  }
}

TEST(SettingsGuard, TriesAgainAtItsEndWhatCouldNotBePutBack) {
  DampedBench bench;
  const auto before = bench.settings;
  {
    SettingsGuard guard(bench, values);
    tune_otherwise(bench);
    bench.fails = "damping_capacitance";
    EXPECT_THROW(guard.put_back(), Error);
    EXPECT_EQ(bench.settings["damping_connected"], 0) << "closed on half of its values";
    bench.fails.clear();
  }
  EXPECT_EQ(bench.settings, before);
}

TEST(SettingsGuard, TheOrderHoldsOnTheWire) {
  amplifier_tests::ServedProfile device("gyrator_twin");
  for (const auto& [name, value] : Writes{{"current_limit", 2},
                                          {"voltage_limit", 24},
                                          {"damping_connected", 1},
                                          {"damping_resistance", 5},
                                          {"damping_capacitance", 1e-3}})
    device.bank.put(name, value);
  ModbusLink link(device.address(), make_link_options(device.profile));
  AmplifierPort port(device.profile, link, {.apply = true, .persist = false, .limits = {}});
  ModbusBench bench(port);
  SettingsGuard guard(bench, values);
  tune_otherwise(bench);
  device.bank.written.clear();
  guard.put_back();
  const auto place = [&](const char* name) { return device.profile.at(name).address; };
  std::vector<int> written = device.bank.written;
  std::erase(written, place("watchdog"));
  EXPECT_EQ(written, (std::vector<int>{place("damping_connected"), place("damping_resistance"),
                                       place("damping_capacitance"), place("damping_connected")}));
}

}  // namespace
}  // namespace gyrator
