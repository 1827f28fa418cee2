#include "gyrator/amplifiers/settings.hpp"

#include "gyrator/core/error.hpp"

#include <string>

#include <gtest/gtest.h>

namespace gyrator {
namespace {

using nlohmann::json;

SettingValue content(const DeviceProfile& profile, const std::string& name, double value) {
  const DeviceRegister& place = profile.at(name);
  const std::vector<std::uint16_t> empty(static_cast<std::size_t>(place.words()));
  return take_value(place, put_raw(place, to_raw(place, value), empty));
}

SettingsBackup make_backup(const DeviceProfile& profile, double limit, double enable) {
  SettingsBackup backup{profile.name, profile.digest, "tcp://127.0.0.1:1502 unit 7", "now", {}, {}};
  backup.settings = {content(profile, "enable", enable), content(profile, "current_limit", limit),
                     content(profile, "cancellation_resistance", 1.25)};
  return backup;
}

TEST(Settings, ABackupIsReadAsItWasWritten) {
  const DeviceProfile profile = load_device_profile("integer_drive");
  const SettingsBackup backup = make_backup(profile, 1.5, 0);
  const SettingsBackup read = parse_backup(describe_backup(backup, profile), profile, "b.json");
  EXPECT_TRUE(compare_settings(profile, backup, read).empty());
  EXPECT_EQ(read.settings.size(), 3U);
  EXPECT_EQ(read.find("current_limit")->value, 1.5);
  EXPECT_EQ(read.device, backup.device);
}

TEST(Settings, ADifferenceHasOldAndNewInSiUnitsAndATableInTheProfiles) {
  const DeviceProfile profile = load_device_profile("integer_drive");
  const auto changes =
      compare_settings(profile, make_backup(profile, 1.5, 0), make_backup(profile, 2, 0));
  ASSERT_EQ(changes.size(), 1U);
  EXPECT_EQ(describe_change(changes[0]), json({{"register", "current_limit"},
                                               {"address", "holding 0x00C8 (40201)"},
                                               {"old", 1.5},
                                               {"new", 2.0},
                                               {"unit", "A"}}));
  EXPECT_EQ(describe_changes(changes),
            "register       address                     old      new\n"
            "current_limit  holding 0x00C8 (40201)  1500 mA  2000 mA\n");
}

TEST(Settings, TheDriveIsSwitchedOffFirstAndOnLast) {
  const DeviceProfile profile = load_device_profile("integer_drive");
  const auto on = order_safely(
      compare_settings(profile, make_backup(profile, 1, 0), make_backup(profile, 2, 1)));
  ASSERT_EQ(on.size(), 2U);
  EXPECT_EQ(on.back().place->name, "enable");
  const auto off = order_safely(
      compare_settings(profile, make_backup(profile, 1, 1), make_backup(profile, 2, 0)));
  EXPECT_EQ(off.front().place->name, "enable");
}

TEST(Settings, AWordThatIsSharedIsComparedByItsBits) {
  const DeviceProfile profile = load_device_profile("gyrator_twin");
  const DeviceRegister& mode = profile.at("drive_mode");
  SettingsBackup a, b;
  a.settings = {take_value(mode, {0x0001})};
  b.settings = {take_value(mode, {0x0021})};
  EXPECT_TRUE(compare_settings(profile, a, b).empty());
  b.settings = {take_value(mode, {0x0020})};
  EXPECT_EQ(compare_settings(profile, a, b).size(), 1U);
}

TEST(Settings, WhatIsNoBackupOfThisProfileIsRefusedWithItsPlace) {
  const DeviceProfile profile = load_device_profile("integer_drive");
  const json good = describe_backup(make_backup(profile, 1.5, 0), profile);
  const auto refusal = [&](const json& document) -> std::string {
    try {
      parse_backup(document, profile, "b.json");
    } catch (const Error& error) {
      return error.what();
    }
    return "nothing was refused";
  };
  json wrong = good;
  wrong["settings"][1]["register"] = "fault";
  EXPECT_NE(refusal(wrong).find("b.json: /settings/1/register: \"fault\""), std::string::npos);
  wrong = good;
  wrong["settings"][1]["words"] = {1, 2};
  EXPECT_NE(refusal(wrong).find("/settings/1/words: 2 words: u16 has 1"), std::string::npos);
  wrong = good;
  wrong["settings"][0]["words"] = {2};
  EXPECT_NE(refusal(wrong).find("a bit is 0 or 1"), std::string::npos);
  wrong = good;
  wrong["settings"][0]["words"] = {70000};
  EXPECT_NE(refusal(wrong).find("/settings/0/words/0"), std::string::npos);
}

TEST(Settings, TheSameDeviceHasOneName) {
  EXPECT_EQ(describe_device(TcpAddress{"localhost", 502}, 1),
            describe_device(TcpAddress{"127.0.0.1", 502}, 1));
  EXPECT_NE(describe_device(TcpAddress{"127.0.0.1", 502}, 1),
            describe_device(TcpAddress{"127.0.0.1", 502}, 2));
}

}  // namespace
}  // namespace gyrator
