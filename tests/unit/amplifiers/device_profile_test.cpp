#include "gyrator/amplifiers/device_profile.hpp"

#include "gyrator/core/error.hpp"
#include "gyrator/documents/json_text.hpp"

#include <string>

#include <gtest/gtest.h>

namespace gyrator {
namespace {

using nlohmann::json;

json load(const std::string& name) {
  return load_json_file("profiles/" + name + ".json");
}

std::size_t index_of(const json& document, const std::string& name) {
  for (std::size_t i = 0; i < document["registers"].size(); ++i)
    if (document["registers"][i]["name"] == name) return i;
  ADD_FAILURE() << "no register " << name;
  return 0;
}

json& register_of(json& document, const std::string& name) {
  return document["registers"][index_of(document, name)];
}

// The error of a profile that was changed somewhere; the twin's by default.
template <class Change>
std::string refusal(const Change& change, const std::string& name = "gyrator_twin") {
  json document = load(name);
  change(document);
  try {
    parse_device_profile(document, "p.json");
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::bad_input);
    return error.what();
  }
  return "nothing was refused";
}

void expect_words(const std::string& text, const std::vector<std::string>& words) {
  for (const std::string& word : words)
    EXPECT_NE(text.find(word), std::string::npos) << word << "\nis not in\n" << text;
}

TEST(DeviceProfile, BothShippedOnesOfferEveryWellKnownSetting) {
  for (const char* name : {"gyrator_twin", "integer_drive"}) {
    const DeviceProfile profile = load_device_profile(name);
    for (const char* setting :
         {"enable", "drive_mode", "current_limit", "voltage_limit", "temperature_limit",
          "cancellation_resistance", "damping_resistance", "damping_capacitance",
          "damping_connected", "back_emf_damping", "back_emf_resistance"}) {
      const DeviceRegister* place = profile.find(setting);
      ASSERT_NE(place, nullptr) << name << " " << setting;
      EXPECT_TRUE(place->is_setting) << name << " " << setting;
    }
    EXPECT_TRUE(profile.fault && profile.watchdog && profile.excitation && profile.capture);
    EXPECT_EQ(profile.capture->signals.size(), capture_signals.size());
    EXPECT_EQ(profile.capture->max_samples, 4000);
    EXPECT_FALSE(profile.at(profile.excitation->amplitude).is_setting);
    EXPECT_FALSE(profile.at("watchdog").is_setting);
    EXPECT_EQ(profile.at("cancellation_resistance").safe, 0);
  }
  EXPECT_TRUE(load_device_profile("gyrator_twin").clock);
  EXPECT_FALSE(load_device_profile("integer_drive").clock);
}

TEST(DeviceProfile, ValuesAreInSiUnits) {
  const DeviceProfile profile = load_device_profile("integer_drive");
  EXPECT_DOUBLE_EQ(*profile.at("current_limit").high, 10);
  EXPECT_DOUBLE_EQ(*profile.at("damping_capacitance").step, 10e-6);
  EXPECT_EQ(profile.at("damping_capacitance").symbol, "F");
  const DeviceRegister& temperature = profile.at("winding_temperature");
  EXPECT_DOUBLE_EQ(*to_physical(temperature, std::int64_t{251}), 298.25);
  EXPECT_FALSE(to_physical(temperature, std::int64_t{-32768}));
  const DeviceRegister& potentiometer = profile.at("damping_resistance");
  EXPECT_EQ(std::get<std::uint64_t>(to_raw(potentiometer, 5)), 8U);
}

TEST(DeviceProfile, RegistersOnTopOfOneAnotherAreRefused) {
  expect_words(refusal([](json& d) { register_of(d, "voltage_limit")["address"] = 17; }),
               {"p.json: /registers/5/address", "holding 0x0011 (40018)", "'current_limit'"});
  expect_words(refusal([](json& d) { register_of(d, "status_light")["bits"]["first"] = 1; }),
               {"/registers/11/address", "'drive_mode'"});
  expect_words(refusal([](json& d) { d["capture"]["signals"]["current"]["address"] = 8999; }),
               {"/capture/signals/current/address", "the window of command"});
  // Another table is another place.
  EXPECT_EQ(refusal([](json& d) { register_of(d, "fault")["address"] = 500; }),
            "nothing was refused");
}

TEST(DeviceProfile, NamesAreUnique) {
  expect_words(refusal([](json& d) { register_of(d, "label")["name"] = "enable"; }),
               {"/registers/16/name", "'enable'", "/registers/2"});
}

TEST(DeviceProfile, TypesFitTheirTablesAndAddresses) {
  expect_words(refusal([](json& d) { register_of(d, "enable")["type"] = "u16"; }),
               {"/registers/2/type", "coil holds bits"});
  expect_words(refusal([](json& d) { register_of(d, "fault").erase("type"); }),
               {"'type'", "\"f32\""});
  expect_words(refusal([](json& d) { register_of(d, "advance_time")["address"] = 65534; }),
               {"/address", "beyond the last address"});
  expect_words(refusal([](json& d) { register_of(d, "current")["access"] = "read_write"; }),
               {"/access", "input cannot be written"});
  expect_words(refusal([](json& d) { register_of(d, "drive_mode")["bits"]["count"] = 17; }),
               {"/bits", "up to bit 16"});
  expect_words(refusal([](json& d) { d["capture"]["signals"]["position"]["address"] = 60000; }),
               {"/capture/signals/position/address", "in pages"});
}

TEST(DeviceProfile, LimitsAreInOrderAndOnTheStep) {
  expect_words(refusal([](json& d) { register_of(d, "current_limit")["min"] = 6; }),
               {"/registers/4/min", "6 A", "5 A"});
  expect_words(refusal([](json& d) { register_of(d, "current_limit")["safe"] = "7 A"; }),
               {"/registers/4/safe", "7 A", "at most 5 A"});
  expect_words(refusal([](json& d) { register_of(d, "current_limit")["safe"] = 0.503; }),
               {"/registers/4/safe", "nearest is 0.5 A"});
  expect_words(refusal([](json& d) { register_of(d, "current_limit")["step"] = 0; }),
               {"/registers/4/step", "above 0"});
  expect_words(refusal([](json& d) { register_of(d, "damping_capacitance")["step"] = 15; }),
               {"/step", "multiple of the register's resolution, 10 uF"});
  expect_words(refusal([](json& d) { register_of(d, "damping_capacitance")["max"] = 700000; }),
               {"/max", "holds 0 uF to 655350 uF"});
  expect_words(refusal([](json& d) { register_of(d, "current_limit")["scale"] = 0; }),
               {"/scale", "must not be zero"});
  expect_words(refusal([](json& d) { register_of(d, "current_limit")["max"] = "5 V"; }),
               {"/registers/4/max", "'5 V'", "current [A]"});
}

TEST(DeviceProfile, UnitsOfWellKnownNamesAreTheirs) {
  expect_words(refusal([](json& d) { register_of(d, "cancellation_resistance")["unit"] = "F"; }),
               {"/unit", "'F'", "cancellation_resistance is in ohm"});
  expect_words(refusal([](json& d) { register_of(d, "current_limit")["unit"] = "Amp"; }),
               {"/registers/4/unit", "Amp"});
  EXPECT_EQ(refusal([](json& d) { register_of(d, "velocity")["unit"] = "m/s"; }),
            "nothing was refused");
}

TEST(DeviceProfile, CodesAreNumbersThatTheTypeHolds) {
  expect_words(refusal([](json& d) { register_of(d, "drive_mode")["codes"]["voltage"] = 4; }),
               {"/codes/voltage", "cannot hold it"});
  expect_words(refusal([](json& d) { register_of(d, "drive_mode")["codes"]["voltage"] = 0; }),
               {"/codes/current", "code of voltage"});
  expect_words(refusal([](json& d) { register_of(d, "capture_state")["codes"].erase("done"); }),
               {"/capture/state", "\"done\""});
  expect_words(refusal([](json& d) { register_of(d, "excitation_kind")["codes"]["sinne"] = 7; }),
               {"/excitation/kind", "sinne", "did you mean 'sine'?"});
}

TEST(DeviceProfile, WhatIsReferredToExistsAndCanBeUsedSo) {
  expect_words(refusal([](json& d) { d["watchdog"]["register"] = "watchdok"; }),
               {"/watchdog/register", "did you mean 'watchdog'?"});
  expect_words(refusal([](json& d) { d["watchdog"]["register"] = "current"; }),
               {"/watchdog/register", "cannot be written"});
  expect_words(refusal([](json& d) { d["fault"]["register"] = "save"; }),
               {"/fault/register", "cannot be read"});
  expect_words(refusal([](json& d) { d["fault"]["bits"]["16"] = "fire"; }),
               {"/fault/bits", "'16'", "0 to 15"});
  expect_words(refusal([](json& d) { d["excitation"]["start"]["value"] = 2; }),
               {"/excitation/start/value", "at most on"});
}

TEST(DeviceProfile, UnknownKeysAndProfilesAreNamed) {
  expect_words(refusal([](json& d) { register_of(d, "enable")["adress"] = 1; }),
               {"/registers/2/adress", "did you mean 'address'?"});
  EXPECT_THROW(load_device_profile("no_such_drive"), Error);
}

TEST(DeviceProfile, BitFieldsThatWouldLoseTheirNeighboursAreRefused) {
  const json low_bits{{"first", 0}, {"count", 2}};
  expect_words(refusal([&](json& d) { register_of(d, "watchdog")["bits"] = low_bits; }),
               {"/watchdog", "'watchdog': is a bit field"});
  expect_words(refusal([&](json& d) { register_of(d, "save")["bits"] = low_bits; }),
               {"/access", "can only be written", "would be lost"});
  expect_words(refusal([&](json& d) {
                 json& place = register_of(d, "advance_time");
                 place = {{"name", "advance_time"},
                          {"address", 72},
                          {"type", "u16"},
                          {"unit", "s"},
                          {"bits", low_bits}};
               }),
               {"/clock/advance", "'advance_time': is a bit field"});
}

}  // namespace
}  // namespace gyrator
