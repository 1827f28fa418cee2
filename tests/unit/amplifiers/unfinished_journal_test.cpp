// What a session leaves behind that did not end well, and how the next one knows of it.
#include "gyrator/amplifiers/amplifier_session.hpp"
#include "gyrator/core/error.hpp"

#include <atomic>
#include <cmath>
#include <cstdlib>
#include <fcntl.h>
#include <fstream>
#include <memory>
#include <set>
#include <string>
#include <sys/stat.h>

#include <gtest/gtest.h>

#include "support/profile_bank.hpp"
#include "support/scratch_folder.hpp"

namespace gyrator {
namespace {

using amplifier_tests::ServedProfile;
using nlohmann::json;

const std::set<int> damping_registers{26, 27};

// A served device, and sessions with it whose journals lie among a user's state of its own.
struct SessionsTest : testing::Test {
  SessionsTest() {
    ::setenv("XDG_STATE_HOME", folder.path().c_str(), 1);
    device.bank.put("damping_resistance", 12);
    device.bank.put("voltage_limit", 24);
  }
  ~SessionsTest() override { ::unsetenv("XDG_STATE_HOME"); }

  SessionOptions options(const std::string& restores = {}) {
    SessionOptions options;
    options.port.apply = true;
    options.port.safe_patience = 0.3;
    options.link = make_link_options(device.profile);
    options.link.response_timeout = 0.1;
    options.link.gap = 0;
    options.restores = restores;
    options.warn = [this](const std::string& text) { said.push_back(text); };
    return options;
  }
  AmplifierSession open(const std::string& restores = {}) {
    return {device.profile, device.address(), options(restores)};
  }
  // What a session that ends now would leave on the disk if the power went instead.
  static std::string cut_off(AmplifierSession& session) {
    const std::string path = session.journal_path();
    std::string text = read_text(path);
    session.keep();
    std::ofstream(path, std::ios::binary) << text;
    return path;
  }
  // The session's journal is all that is left of it, as after a power loss.
  std::string crash(double damping) {
    AmplifierSession session = open();
    session.port().write("damping_resistance", damping);
    return cut_off(session);
  }
  void restore(const std::string& journal) {
    AmplifierSession session = open(journal);
    put_back(session.port(), read_settings_journal(journal).backup, true, true);
    session.keep();
  }
  std::vector<std::string> find_hints() {
    said.clear();
    open().restore();
    return said;
  }

  ScratchFolder folder;
  ServedProfile device{"gyrator_twin"};
  std::vector<std::string> said;
};

using UnfinishedJournals = SessionsTest;

TEST_F(UnfinishedJournals, SettingsThatCouldNotBePutBackAreNotForgotten) {
  std::string journal;
  {
    AmplifierSession session = open();
    journal = session.journal_path();
    session.port().write("damping_resistance", 60);
    device.bank.stuck = damping_registers;
  }
  ASSERT_EQ(said.size(), 1U);
  EXPECT_NE(said[0].find("could not be put back"), std::string::npos) << said[0];
  EXPECT_NE(said[0].find("gyrator restore --journal " + journal + " --apply"), std::string::npos)
      << said[0];
  EXPECT_EQ(read_settings_journal(journal).state, "safe");
  EXPECT_TRUE(is_unfinished_journal(journal));
  device.bank.stuck.clear();
  ASSERT_EQ(find_hints().size(), 1U);
  EXPECT_NE(said[0].find(journal), std::string::npos);
  restore(journal);
  EXPECT_EQ(device.bank.get("damping_resistance"), 12);
  EXPECT_TRUE(find_hints().empty());
}

TEST_F(UnfinishedJournals, WhatFailsWhilePuttingBackAndAfterwardsIsAllSaid) {
  auto put_back_breaks = std::make_shared<std::atomic<bool>>(false);
  auto is_broken = std::make_shared<std::atomic<bool>>(false);
  ServerHooks hooks;
  hooks.before_request = [=](auto request) -> std::optional<ModbusException> {
    const bool writes_damping = request[0] == 16 && request[2] == *damping_registers.begin();
    if (*put_back_breaks && writes_damping) *is_broken = true;
    if (*is_broken) return ModbusException::device_failure;
    return {};
  };
  ServedProfile fragile("gyrator_twin", hooks);
  fragile.bank.put("damping_resistance", 12);
  {
    AmplifierSession session(fragile.profile, fragile.address(), options());
    session.port().write("damping_resistance", 60);
    *put_back_breaks = true;
  }
  ASSERT_EQ(said.size(), 1U);
  for (const char* words : {"NOT IN ITS SAFE STATE", "could not be put back", "enable = "})
    EXPECT_NE(said[0].find(words), std::string::npos) << said[0];
}

TEST_F(UnfinishedJournals, ARestoreThatFailsIsStillToBeDone) {
  std::string journal;
  {
    AmplifierSession session = open();
    session.port().write("voltage_limit", 10);
    session.port().write("damping_resistance", 60);
    journal = session.journal_path();
    session.keep();
  }
  EXPECT_FALSE(is_unfinished_journal(journal));
  device.bank.stuck = damping_registers;
  EXPECT_THROW(restore(journal), Error);
  EXPECT_EQ(device.bank.get("voltage_limit"), 24) << "what was put back does not go away again";
  ASSERT_EQ(said.size(), 1U);
  EXPECT_NE(said[0].find("did not come to its end"), std::string::npos) << said[0];
  EXPECT_NE(said[0].find("gyrator restore --journal " + journal + " --apply"), std::string::npos)
      << said[0];
  EXPECT_TRUE(is_unfinished_journal(journal));
  device.bank.stuck.clear();
  ASSERT_EQ(find_hints().size(), 1U);
  EXPECT_NE(said[0].find(journal), std::string::npos) << "and not the restore's own";
  restore(journal);
  EXPECT_EQ(device.bank.get("damping_resistance"), 12);
  EXPECT_TRUE(find_hints().empty());
}

TEST_F(UnfinishedJournals, OfSeveralTheOldestIsToldUntilItIsRestoredItself) {
  const std::string first = crash(60);
  const std::string second = crash(70);
  const std::string third = crash(80);
  said.clear();
  restore(second);
  EXPECT_EQ(device.bank.get("damping_resistance"), 60);
  EXPECT_TRUE(is_unfinished_journal(first));
  EXPECT_FALSE(is_unfinished_journal(third)) << "knows only what the second had left";
  ASSERT_EQ(find_hints().size(), 1U);
  EXPECT_NE(said[0].find(first), std::string::npos);
  const std::string fourth = crash(90);
  restore(first);
  EXPECT_EQ(device.bank.get("damping_resistance"), 12);
  EXPECT_FALSE(is_unfinished_journal(fourth));
  EXPECT_TRUE(find_hints().empty());
}

TEST_F(UnfinishedJournals, AreFoundAfterAPowerLossWithoutTheLocksNote) {
  const std::string journal = crash(60);
  std::filesystem::remove(SettingsLock(describe_line(device.address(), 1)).path());
  const auto found = find_unfinished_journals(describe_device(device.address(), 1));
  ASSERT_EQ(found.size(), 1U);
  EXPECT_EQ(found[0].path, journal);
  EXPECT_TRUE(find_unfinished_journals(describe_device(device.address(), 11)).empty());
}

TEST_F(UnfinishedJournals, NeverThrowWhateverStandsInThem) {
  for (const char* text :
       {R"({"schema":5})", R"({"schema":"gyrator/amplifier-journal/1","state":7})", "[1]", "", "{",
        R"({"state":"safe"})"}) {
    std::ofstream(folder / "j", std::ios::trunc) << text;
    EXPECT_NO_THROW(is_unfinished_journal(folder / "j")) << text;
    EXPECT_THROW(read_settings_journal(folder / "j"), Error) << text;
  }
}

TEST_F(UnfinishedJournals, AMalformedLineIsNamedByItsNumber) {
  const std::string good = read_text(crash(60));
  for (const char* line : {R"({"write":5})", R"({"state":7})"}) {
    std::ofstream(folder / "j", std::ios::trunc) << good << line << "\n";
    try {
      read_settings_journal(folder / "j");
      ADD_FAILURE() << line;
    } catch (const Error& error) {
      EXPECT_EQ(error.code(), ErrorCode::bad_input);
      EXPECT_NE(std::string(error.what()).find("/j: line 4: "), std::string::npos) << error.what();
    }
  }
}

TEST_F(UnfinishedJournals, WordsThatStandForNoValueEscapeNoLimit) {
  AmplifierSession session = open();
  const DeviceRegister& place = device.profile.at("current_limit");
  const SettingValue none = take_value(place, put_raw(place, RawValue(std::nan(""))));
  ASSERT_FALSE(none.value);
  EXPECT_THROW(session.port().write_content(none), Error);
  EXPECT_EQ(device.bank.get("current_limit"), 0);
  session.port().write_content(none, true);  // was read from there
  EXPECT_EQ(device.bank.get("current_limit"), -1) << "no value";
  session.port().write_content(none);  // it is so already
  session.keep();
}

TEST(SettingsLock, IsOfASerialLineWhateverTheUnit) {
  const LinkAddress line = SerialAddress{"/dev/null", 19200, {}, 1};
  EXPECT_EQ(describe_line(line, 1), describe_line(line, 2));
  EXPECT_NE(describe_device(line, 1), describe_device(line, 2));
  const LinkAddress device = TcpAddress{"127.0.0.1", 502};
  EXPECT_NE(describe_line(device, 1), describe_line(device, 2));
}

TEST(SettingsLock, IsTheSameFileForEveryUserAndGoesWithItsHolder) {
  const std::string what = "rtu://test-of-the-lock-" + std::to_string(::getpid());
  std::filesystem::path path;
  const mode_t mask = ::umask(077);
  {
    SettingsLock lock(what);
    path = lock.path();
    EXPECT_TRUE(path.parent_path() == "/run/lock" || path.parent_path() == "/tmp") << path;
    EXPECT_EQ(static_cast<int>(std::filesystem::status(path).permissions()), 0666);
    EXPECT_THROW(SettingsLock second(what), Error);
    lock.note_journals({"/one", "/two"});
  }
  ::umask(mask);
  {
    SettingsLock lock(what);
    EXPECT_EQ(lock.journals(), (std::vector<std::string>{"/one", "/two"}));
    lock.note_journals({});
  }
  EXPECT_FALSE(std::filesystem::exists(path));
}

}  // namespace
}  // namespace gyrator
