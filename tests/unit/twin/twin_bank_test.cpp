#include "gyrator/twin/twin_bank.hpp"

#include "gyrator/core/error.hpp"
#include "gyrator/twin/twin_bench.hpp"

#include <algorithm>
#include <cmath>
#include <string>
#include <string_view>

#include <gtest/gtest.h>

#include "unit/twin/twin_models.hpp"

namespace gyrator {
namespace {

TwinDevice make_measured_twin() {
  TwinDevice twin = make_plain_twin();
  twin.noise = {1e-4, 1e-3, 5e-3, 0.02, 0};
  return twin;
}

// Registers by name through the bank, as a client with the profile sees them.
class Client {
 public:
  explicit Client(const std::string& profile, std::optional<double> pace = std::nullopt,
                  const std::string& stuck = {})
      : profile_(load_device_profile(profile)),
        amplifier_(make_measured_twin()),
        bank_(amplifier_, profile_, {pace, stuck}) {}

  SimulatedAmplifier& amplifier() { return amplifier_; }
  TwinBank& bank() { return bank_; }
  const DeviceProfile& profile() const { return profile_; }

  std::vector<std::uint16_t> read_words(const DeviceRegister& place) {
    if (holds_bits(place.table)) {
      const auto bits = std::get<0>(bank_.read_bits(place.table, place.address, 1));
      return {static_cast<std::uint16_t>(bits[0])};
    }
    return std::get<0>(bank_.read_registers(place.table, place.address, place.words()));
  }
  double read(const std::string& name) {
    const DeviceRegister& place = profile_.at(name);
    return to_physical(place, take_raw(place, read_words(place))).value();
  }
  std::optional<ModbusException> write_words(const DeviceRegister& place,
                                             const std::vector<std::uint16_t>& words) {
    if (holds_bits(place.table)) return bank_.write_coils(place.address, {words[0] != 0});
    return bank_.write_registers(place.address, words);
  }
  std::optional<ModbusException> write(const std::string& name, double value) {
    const DeviceRegister& place = profile_.at(name);
    const auto now = place.bits ? read_words(place) : std::vector<std::uint16_t>{};
    return write_words(place, put_raw(place, to_raw(place, value), now));
  }
  std::optional<ModbusException> write_raw(const std::string& name, const RawValue& raw) {
    const DeviceRegister& place = profile_.at(name);
    const auto now = place.bits ? read_words(place) : std::vector<std::uint16_t>{};
    return write_words(place, put_raw(place, raw, now));
  }
  double code(const std::string& name, std::string_view code) const {
    return static_cast<double>(find_code(profile_.at(name), code).value());
  }

 private:
  DeviceProfile profile_;
  SimulatedAmplifier amplifier_;
  TwinBank bank_;
};

class EveryProfile : public testing::TestWithParam<const char*> {};
INSTANTIATE_TEST_SUITE_P(Shipped, EveryProfile, testing::Values("gyrator_twin", "integer_drive"));

TEST_P(EveryProfile, IdentityRegistersAreThose) {
  Client client(GetParam());
  for (const DeviceAction& known : client.profile().identity)
    EXPECT_EQ(client.read(known.register_name), known.value);
}

TEST_P(EveryProfile, SettingsActOnTheAmplifierAndReadBackWhatWasWritten) {
  Client client(GetParam());
  const std::pair<const char*, double> settings[] = {
      {"current_limit", 1.5},           {"voltage_limit", 12},
      {"temperature_limit", 363.15},    {"damping_resistance", 7.5},
      {"damping_capacitance", 1e-3},    {"damping_connected", 1},
      {"back_emf_damping", 2e-3},       {"back_emf_resistance", 1.4},
      {"cancellation_resistance", 0.5}, {"enable", 1}};
  for (const auto& [name, value] : settings) {
    EXPECT_FALSE(client.write(name, value)) << name;
    EXPECT_NEAR(client.amplifier().read(name), value, 1e-6 * value) << name;
    EXPECT_EQ(client.read(name), client.amplifier().read(name)) << name;
    EXPECT_EQ(client.bank().write_counts().at(name), 1) << name;
  }
}

TEST_P(EveryProfile, TheDriveModeGoesByTheProfilesCodes) {
  Client client(GetParam());
  EXPECT_FALSE(client.write("drive_mode", client.code("drive_mode", "voltage")));
  EXPECT_EQ(client.amplifier().settings().drive_mode, DriveMode::voltage);
  EXPECT_EQ(client.read("drive_mode"), client.code("drive_mode", "voltage"));
  EXPECT_FALSE(client.write("enable", 1));
  EXPECT_EQ(client.write("drive_mode", client.code("drive_mode", "current")),
            ModbusException::device_failure);
  EXPECT_EQ(client.read("drive_mode"), client.code("drive_mode", "voltage"));
}

TEST_P(EveryProfile, WhatTheProfileDoesNotAllowIsRefusedAndChangesNothing) {
  Client client(GetParam());
  const double before = client.read("damping_resistance");
  const DeviceRegister& place = client.profile().at("damping_resistance");
  DeviceRegister boundless = place;
  boundless.low = boundless.high = boundless.step = std::nullopt;
  for (const double value : {*place.low - 1, *place.high + 1, 5.25}) {
    if (place.type != RegisterType::f32 && (value < *place.low || value == 5.25)) continue;
    EXPECT_EQ(client.write_raw("damping_resistance", to_raw(boundless, value)),
              ModbusException::illegal_data_value)
        << value;
  }
  EXPECT_EQ(client.read("damping_resistance"), before);
  EXPECT_EQ(client.write_raw("drive_mode", std::uint64_t{3}), ModbusException::illegal_data_value);
  // No register there; and one that is only read.
  EXPECT_EQ(client.bank().write_registers(999, std::vector<std::uint16_t>{1}),
            ModbusException::illegal_data_address);
  EXPECT_EQ(client.bank().write_coils(999, {true}), ModbusException::illegal_data_address);
  const DeviceRegister& identity =
      client.profile().at(client.profile().identity.front().register_name);
  EXPECT_EQ(client.write_words(identity, {1}), ModbusException::illegal_data_address);
  const auto far = client.bank().read_registers(RegisterTable::holding, 5000, 1);
  EXPECT_EQ(std::get<1>(far), ModbusException::illegal_data_address);
  const auto large =
      client.bank().read_registers(RegisterTable::input, 1000, client.profile().link.max_read + 1);
  EXPECT_EQ(std::get<1>(large), ModbusException::illegal_data_value);
}

TEST_P(EveryProfile, ANumberOfTwoWordsIsWrittenWhole) {
  Client client(GetParam());
  const DeviceRegister& place = client.profile().at("cancellation_resistance");
  ASSERT_EQ(place.words(), 2);
  ASSERT_FALSE(client.write("cancellation_resistance", 0.5));
  for (const int address : {place.address, place.address + 1})
    EXPECT_EQ(client.bank().write_registers(address, std::vector<std::uint16_t>{0}),
              ModbusException::illegal_data_value);
  EXPECT_NEAR(client.read("cancellation_resistance"), 0.5, 1e-6);
}

TEST_P(EveryProfile, AWriteOfSeveralIsDoneWholeOrNotAtAll) {
  Client client(GetParam());
  const DeviceRegister& resistance = client.profile().at("damping_resistance");
  const DeviceRegister& capacitance = client.profile().at("damping_capacitance");
  ASSERT_EQ(capacitance.address, resistance.address + resistance.words());
  const double before = client.read("damping_resistance");
  auto words = put_raw(resistance, to_raw(resistance, 20));
  words.push_back(5000);  // more than the bank has
  EXPECT_EQ(client.bank().write_registers(resistance.address, words),
            ModbusException::illegal_data_value);
  EXPECT_EQ(client.read("damping_resistance"), before);
  words.back() = 100;
  EXPECT_FALSE(client.bank().write_registers(resistance.address, words));
  EXPECT_EQ(client.read("damping_resistance"), 20);
  EXPECT_NEAR(client.read("damping_capacitance"), 1e-3, 1e-12);
}

// The capture as the profile's window and pages show it.
std::vector<double> fetch(Client& client, CaptureSignal signal, int samples) {
  const DeviceCapture& capture = *client.profile().capture;
  const DeviceRegister& place = *capture.find(signal);
  std::vector<double> values;
  const int page = capture.page.empty() ? capture.max_samples : capture.page_samples;
  for (int k = 0; k < samples; ++k) {
    if (k % page == 0 && !capture.page.empty()) {
      EXPECT_FALSE(client.write(capture.page, k / page));
    }
    const auto words = std::get<0>(client.bank().read_registers(
        place.table, place.address + (k % page) * place.words(), place.words()));
    values.push_back(to_physical(place, take_raw(place, words)).value());
  }
  return values;
}

TEST_P(EveryProfile, AnExperimentOverRegistersIsTheOneInProcess) {
  const Excitation chirp{ExcitationKind::chirp, DriveMode::current, 0.3, 0.1, 5, 200, 0.25};
  constexpr int samples = 450;
  Client client(GetParam());
  const auto& names = *client.profile().excitation;
  const auto& capture = *client.profile().capture;
  const auto put = [&](const std::string& name, double value) {
    EXPECT_FALSE(client.write(name, value)) << name;
  };
  put("enable", 1);
  put(names.kind, client.code(names.kind, "chirp"));
  put(names.amplitude, chirp.amplitude);
  put(names.offset, chirp.offset);
  put(names.frequency, chirp.frequency_hz);
  put(names.end_frequency, chirp.end_frequency_hz);
  put(names.duration, chirp.duration);
  put(capture.delay, 0.013);
  put(capture.decimation, 3);
  put(capture.samples, samples);
  put(capture.arm.register_name, capture.arm.value);
  put(names.start.register_name, names.start.value);
  EXPECT_TRUE(client.amplifier().is_exciting());
  // Reading the state while it is busy is its end.
  EXPECT_EQ(client.read(capture.state), client.code(capture.state, "done"));

  SimulatedAmplifier twin(make_measured_twin());
  TwinBench bench(twin);
  bench.write_setting("back_emf_damping", client.amplifier().read("back_emf_damping"));
  Excitation as_written = chirp;  // to the registers' rounding
  as_written.amplitude = client.read(names.amplitude);
  as_written.offset = client.read(names.offset);
  const Capture expected = bench.run(as_written, {0.013, 3e-4, samples});
  const std::pair<CaptureSignal, const std::vector<double>*> signals[] = {
      {CaptureSignal::command, &expected.command},
      {CaptureSignal::current, &expected.current},
      {CaptureSignal::voltage, &expected.voltage},
      {CaptureSignal::velocity, &expected.velocity},
      {CaptureSignal::position, &expected.position}};
  for (const auto& [signal, column] : signals) {
    const DeviceRegister& place = *capture.find(signal);
    const auto values = fetch(client, signal, samples);
    for (std::size_t k = 0; k < values.size(); ++k) {
      const double step = place.type == RegisterType::f32 ? 1e-7 * std::abs((*column)[k])
                                                          : place.scale * place.factor / 2;
      ASSERT_NEAR(values[k], (*column)[k], step * (1 + 1e-9)) << name_of(signal) << " " << k;
    }
  }
}

TEST_P(EveryProfile, AFaultShowsItsBitAndIsCleared) {
  Client client(GetParam());
  const DeviceFault& fault = *client.profile().fault;
  client.amplifier().write("velocity_limit", 5);
  const auto& names = *client.profile().excitation;
  ASSERT_FALSE(client.write("enable", 1));
  client.write(names.kind, client.code(names.kind, "dc"));
  client.write(names.offset, 0.4);
  client.write(names.duration, 1);
  ASSERT_FALSE(client.write(names.start.register_name, names.start.value));
  client.bank().pass(0.5);
  const auto bit = std::find_if(fault.bits.begin(), fault.bits.end(),
                                [](const auto& known) { return known.second == "overspeed"; });
  EXPECT_EQ(client.read(fault.register_name), std::exp2(bit->first));
  EXPECT_EQ(client.read("enable"), 0);
  EXPECT_EQ(client.write("enable", 1), ModbusException::device_failure);
  EXPECT_FALSE(client.write(fault.clear->register_name, fault.clear->value));
  EXPECT_EQ(client.read(fault.register_name), 0);
  EXPECT_FALSE(client.write("enable", 1));
}

TEST_P(EveryProfile, TheWatchdogIsFedByItsRegisterWhereTimeIsTheWalls) {
  Client client(GetParam(), 1.0);
  const DeviceWatchdog& watchdog = *client.profile().watchdog;
  EXPECT_EQ(client.amplifier().settings().watchdog_period, watchdog.period);
  ASSERT_FALSE(client.write("enable", 1));
  // The wall's own time comes on top, a little of it.
  client.amplifier().advance(0.6 * watchdog.period);
  EXPECT_FALSE(client.write(watchdog.feed.register_name, watchdog.feed.value));
  client.amplifier().advance(0.6 * watchdog.period);
  EXPECT_EQ(client.amplifier().faults(), 0U);
  client.amplifier().advance(0.5 * watchdog.period);
  EXPECT_EQ(describe_faults(client.amplifier().faults()), "watchdog");
}

TEST_P(EveryProfile, SavingIsCounted) {
  Client client(GetParam());
  const DeviceAction& save = client.profile().persist->action;
  EXPECT_EQ(client.bank().persist_count(), 0);
  EXPECT_FALSE(client.write(save.register_name, save.value));
  EXPECT_EQ(client.bank().persist_count(), 1);
  EXPECT_FALSE(client.write("label", 77));
  EXPECT_EQ(client.read("label"), 77);
}

TEST(TwinBank, TheClockTellsAndMovesTheDevicesTime) {
  Client client("gyrator_twin");
  EXPECT_EQ(client.read("device_time"), 0);
  EXPECT_FALSE(client.write("advance_time", 12.5));
  EXPECT_EQ(client.read("device_time"), 12.5);
  client.bank().pass(0.00025);
  client.bank().pass(0.00025);
  EXPECT_EQ(client.read("device_time"), 12.5005);
}

TEST(TwinBank, FieldsOfOneWordAreSettingsOfTheirOwn) {
  Client client("gyrator_twin");
  const int address = client.profile().at("drive_mode").address;
  // drive_mode in bits 0 and 1, status_light in bits 4 and 5
  EXPECT_FALSE(client.bank().write_registers(address, std::vector<std::uint16_t>{0x21}));
  EXPECT_EQ(client.read("status_light"), 2);
  EXPECT_EQ(client.amplifier().settings().drive_mode, DriveMode::voltage);
  EXPECT_EQ(client.bank().write_registers(address, std::vector<std::uint16_t>{0x31}),
            ModbusException::illegal_data_value);
  EXPECT_EQ(client.read("status_light"), 2);
}

TEST(TwinBank, AStuckRegisterTakesWritesAndKeepsItsValue) {
  Client client("gyrator_twin", std::nullopt, "damping_resistance");
  const double before = client.read("damping_resistance");
  EXPECT_FALSE(client.write("damping_resistance", 50));
  EXPECT_EQ(client.read("damping_resistance"), before);
  EXPECT_THROW(Client("gyrator_twin", std::nullopt, "damping_resistanc"), Error);
}

TEST(TwinBank, SmallHolesReadAsZeroAndLargeOnesAreRefused) {
  Client client("gyrator_twin");
  // 22 and 23 lie between temperature_limit and cancellation_resistance.
  const auto words = std::get<0>(client.bank().read_registers(RegisterTable::holding, 16, 14));
  EXPECT_EQ(words[6], 0);
  EXPECT_EQ(words[7], 0);
  const auto beyond = client.bank().read_registers(RegisterTable::holding, 72, 10);
  EXPECT_EQ(std::get<1>(beyond), ModbusException::illegal_data_address);
}

}  // namespace
}  // namespace gyrator
