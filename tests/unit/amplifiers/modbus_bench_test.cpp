#include "gyrator/amplifiers/modbus_bench.hpp"

#include "gyrator/amplifiers/amplifier_session.hpp"
#include "gyrator/core/error.hpp"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <memory>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "support/profile_bank.hpp"

namespace gyrator {
namespace {

using amplifier_tests::ServedProfile;

constexpr int samples = 250;

// A device whose buffer holds known signals, and a bench on it.
struct OpenBench {
  explicit OpenBench(const std::string& name, ServerHooks hooks = {})
      : device(name, std::move(hooks)),
        link(prepare(device).address(), make_link_options(device.profile)),
        port(device.profile, link, {.apply = true, .persist = false, .limits = {}}),
        bench(port) {}

  static ServedProfile& prepare(ServedProfile& device) {
    device.bank.put("current_limit", 2);
    device.bank.put("voltage_limit", 24);
    device.bank.put("temperature_limit", 393.15);
    device.bank.put("winding_temperature", 298.15);
    for (int i = 0; i < samples; ++i) {
      device.bank.samples[CaptureSignal::current].push_back(0.001 * i);
      device.bank.samples[CaptureSignal::velocity].push_back(-0.5 * i);
    }
    return device;
  }

  ServedProfile device;
  ModbusLink link;
  AmplifierPort port;
  ModbusBench bench;
};

constexpr Excitation quarter_sine{ExcitationKind::sine, DriveMode::current, 0.5, 0.1, 40, 0, 0.5};
constexpr CaptureRequest request{.start = 0.01, .period = 2e-4, .samples = samples};

template <class Function>
std::string refusal(const Function& function, ErrorCode code) {
  try {
    function();
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), code) << error.what();
    return error.what();
  }
  return "nothing was refused";
}

TEST(ModbusBench, ARunWritesTheExcitationAndReadsTheBufferInPagesOrWhole) {
  for (const char* name : {"gyrator_twin", "integer_drive"}) {
    OpenBench open(name);
    bool was_on = false;
    open.device.bank.when_done = [&](bool enabled) { was_on = enabled; };
    const Capture capture = open.bench.run(quarter_sine, request);
    EXPECT_TRUE(was_on) << name;
    EXPECT_EQ(open.device.bank.get("enable"), 0) << name;
    ASSERT_EQ(capture.current.size(), static_cast<std::size_t>(samples));
    ASSERT_EQ(capture.velocity.size(), static_cast<std::size_t>(samples));
    for (int i = 0; i < samples; ++i) {
      // i16 of 0.5 mA, f32
      EXPECT_NEAR(capture.current[static_cast<std::size_t>(i)], 0.001 * i, 1e-7) << name;
      EXPECT_NEAR(capture.velocity[static_cast<std::size_t>(i)], -0.5 * i, 1e-7) << name;
    }
    EXPECT_NEAR(*capture.winding_temperature_before, 298.15, 1e-4);
    const DeviceProfile& profile = open.device.profile;
    EXPECT_EQ(open.device.bank.get(profile.excitation->kind),
              static_cast<double>(*find_code(profile.at(profile.excitation->kind), "sine")));
    EXPECT_NEAR(open.device.bank.get(profile.excitation->amplitude), 0.5, 1e-6);
    EXPECT_NEAR(open.device.bank.get(profile.excitation->frequency), 40, 1e-6);
    EXPECT_NEAR(open.device.bank.get(profile.excitation->duration), 0.5, 1e-6);
    EXPECT_EQ(open.device.bank.get(profile.capture->decimation), 2);
    EXPECT_NEAR(open.device.bank.get(profile.capture->delay), 0.01, 1e-6);
  }
}

TEST(ModbusBench, ItsLimitsAreTheDevicesOwn) {
  OpenBench open("integer_drive");
  const BenchLimits limits = open.bench.limits();
  EXPECT_DOUBLE_EQ(limits.largest_current, 2);
  EXPECT_DOUBLE_EQ(limits.largest_voltage, 24);
  EXPECT_DOUBLE_EQ(limits.shortest_period, 1e-4);
  EXPECT_DOUBLE_EQ(limits.position_quantum, 1e-4);
  EXPECT_EQ(limits.kinds.size(), 5U);
  EXPECT_EQ(limits.modes.size(), 2U);
  open.bench.write_setting("current_limit", 1);
  EXPECT_DOUBLE_EQ(open.bench.limits().largest_current, 1);
  EXPECT_DOUBLE_EQ(open.bench.setting_range("damping_capacitance").step, 10e-6);
}

TEST(ModbusBench, WhatTheAmplifierCannotDoIsRefusedWithTheDriveOff) {
  OpenBench open("gyrator_twin");
  Excitation excitation = quarter_sine;
  excitation.amplitude = 3;
  EXPECT_NE(refusal([&] { open.bench.run(excitation, request); }, ErrorCode::bad_input)
                .find("reaches 3.1 A: at most 2 A"),
            std::string::npos);
  CaptureRequest odd = request;
  odd.period = 1.5e-4;
  EXPECT_THROW(open.bench.run(quarter_sine, odd), Error);
  odd = request;
  odd.samples = 4001;
  EXPECT_THROW(open.bench.run(quarter_sine, odd), Error);
  EXPECT_EQ(open.device.bank.get("enable"), 0);
}

TEST(ModbusBench, AFaultEndsTheRunWithTheDriveOff) {
  OpenBench open("gyrator_twin");
  open.device.bank.put("fault", 2);
  EXPECT_NE(refusal([&] { open.bench.run(quarter_sine, request); }, ErrorCode::device)
                .find("fault before the excitation: overtemperature"),
            std::string::npos);
  open.device.bank.put("fault", 0);
  open.device.bank.put("current", 3);
  EXPECT_NE(refusal([&] { open.bench.run(quarter_sine, request); }, ErrorCode::device)
                .find("current: 3 A during the excitation: at most 2.4 A"),
            std::string::npos);
  EXPECT_EQ(open.device.bank.get("enable"), 0);
  open.device.bank.put("current", 0);
  open.device.bank.put("winding_temperature", 400);
  EXPECT_NE(refusal([&] { open.bench.run(quarter_sine, request); }, ErrorCode::device)
                .find("winding_temperature: 400 K during"),
            std::string::npos);
  EXPECT_EQ(open.device.bank.get("enable"), 0);
}

TEST(ModbusBench, AModeThatTheAmplifierDoesNotHaveIsRefused) {
  OpenBench open("gyrator_twin");
  const DeviceRegister& mode = open.device.profile.at("drive_mode");
  open.bench.set_mode(DriveMode::voltage);
  EXPECT_EQ(open.device.bank.get("drive_mode"),
            static_cast<double>(find_code(mode, "voltage").value()));
  open.bench.set_mode(DriveMode::current);
  EXPECT_EQ(open.device.bank.get("drive_mode"),
            static_cast<double>(find_code(mode, "current").value()));
  std::erase_if(open.device.profile.registers,
                [](const DeviceRegister& place) { return place.name == "drive_mode"; });
  ModbusBench without(open.port);
  without.set_mode(DriveMode::current);
  EXPECT_EQ(refusal([&] { without.set_mode(DriveMode::voltage); }, ErrorCode::bad_input),
            "drive_mode: the amplifier has no voltage mode");
}

// Refuses to be switched off so often.
ServerHooks refuse_off(int times) {
  auto left = std::make_shared<std::atomic<int>>(times);
  ServerHooks hooks;
  hooks.before_request =
      [left](std::span<const std::uint8_t> pdu) -> std::optional<ModbusException> {
    const bool is_off =
        pdu.size() == 5 && pdu[0] == 5 && pdu[2] == 0 && pdu[3] == 0;  // coil 0 is enable
    if (!is_off || left->load() == 0) return {};
    --*left;
    return ModbusException::device_failure;
  };
  return hooks;
}

TEST(ModbusBench, ARunThatOnlyTheSafeStateSwitchesOffIsAnError) {
  OpenBench open("gyrator_twin", refuse_off(1));
  const std::string message =
      refusal([&] { open.bench.run(quarter_sine, request); }, ErrorCode::device);
  EXPECT_NE(message.find("switched off only by its safe state: "), std::string::npos) << message;
  EXPECT_NE(message.find("coil 0x0000"), std::string::npos) << message;
  EXPECT_EQ(open.device.bank.get("enable"), 0);
  EXPECT_NEAR(open.device.bank.get("current_limit"), 0.5, 1e-6) << "the safe value";
}

TEST(ModbusBench, AnErrorWhileSwitchingOffNamesTheOneBefore) {
  for (const int times : {1, 1000}) {
    OpenBench open("gyrator_twin", refuse_off(times));
    open.device.bank.put("current", 3);
    const std::string message =
        refusal([&] { open.bench.run(quarter_sine, request); }, ErrorCode::device);
    EXPECT_NE(message.find(times == 1 ? "only by its safe state" : "COULD NOT BE SWITCHED OFF"),
              std::string::npos)
        << message;
    EXPECT_NE(message.find("current: 3 A during the excitation"), std::string::npos) << message;
  }
}

TEST(ModbusBench, ASettingIsWrittenWithTheDriveOff) {
  OpenBench open("gyrator_twin");
  open.device.bank.put("enable", 1);
  open.bench.write_setting("damping_resistance", 20);
  std::vector<int> written = open.device.bank.written;
  std::erase(written, open.device.profile.at("watchdog").address);
  EXPECT_EQ(written, (std::vector<int>{0, 26}));  // the coil of enable, the resistance
  EXPECT_EQ(open.device.bank.get("enable"), 0);
}

DeviceRegister& register_of(DeviceProfile& profile, const std::string& name) {
  return *std::find_if(profile.registers.begin(), profile.registers.end(),
                       [&](const DeviceRegister& place) { return place.name == name; });
}

TEST(ModbusBench, ExperimentsDoNotWearPersistentMemoryOut) {
  ServedProfile device("gyrator_twin");
  OpenBench::prepare(device);
  register_of(device.profile, "damping_resistance").persistent = true;
  device.bank.put("damping_resistance", 10);
  ModbusLink link(device.address(), make_link_options(device.profile));
  AmplifierPort port(device.profile, link, {.apply = true, .persist = true, .limits = {}});
  ModbusBench bench(port);
  bench.write_setting("damping_resistance", 10);  // is there already
  const std::string message =
      refusal([&] { bench.write_setting("damping_resistance", 20); }, ErrorCode::device);
  EXPECT_NE(message.find("damping_resistance"), std::string::npos) << message;
  EXPECT_NE(message.find("persistent memory"), std::string::npos) << message;
  EXPECT_EQ(device.bank.get("damping_resistance"), 10);
  const std::vector<int>& written = device.bank.written;
  EXPECT_EQ(std::count(written.begin(), written.end(), 26), 0);
  port.write("damping_resistance", 20);  // what is kept in the end
  EXPECT_EQ(device.bank.get("damping_resistance"), 20);
  register_of(device.profile, "excitation_amplitude").persistent = true;
  EXPECT_NE(refusal([&] { ModbusBench(port).limits(); }, ErrorCode::bad_input)
                .find("excitation_amplitude: is in persistent memory"),
            std::string::npos);
}

}  // namespace
}  // namespace gyrator
