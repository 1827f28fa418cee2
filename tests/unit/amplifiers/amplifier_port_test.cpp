#include "gyrator/amplifiers/amplifier_port.hpp"

#include "gyrator/amplifiers/amplifier_session.hpp"
#include "gyrator/core/error.hpp"
#include "gyrator/documents/json_text.hpp"

#include <algorithm>
#include <csignal>
#include <string>

#include <gtest/gtest.h>

#include "support/profile_bank.hpp"
#include "support/scratch_folder.hpp"

namespace gyrator {
namespace {

using amplifier_tests::ServedProfile;
using nlohmann::json;

const PortOptions applied{.apply = true, .persist = false, .limits = {}, .safe_patience = 1};

LinkOptions quick(const DeviceProfile& profile) {
  LinkOptions options = make_link_options(profile);
  options.response_timeout = 0.1;
  options.gap = 0;
  return options;
}

// A served profile with a port that writes, and a journal.
struct OpenPort {
  explicit OpenPort(PortOptions options = applied, const std::string& name = "gyrator_twin",
                    ServerHooks hooks = {})
      : device(name, std::move(hooks)),
        link(device.address(), quick(device.profile)),
        journal(folder / "journal", {{"schema", journal_schema_name}}),
        port(device.profile, link, std::move(options), &journal) {}

  std::vector<json> records() const {
    std::vector<json> lines;
    std::ifstream file(folder / "journal");
    for (std::string line; std::getline(file, line);) lines.push_back(json::parse(line));
    return lines;
  }

  ScratchFolder folder;
  ServedProfile device;
  ModbusLink link;
  SettingsJournal journal;
  AmplifierPort port;
};

template <class Function>
std::string refusal(const Function& function, ErrorCode code = ErrorCode::device) {
  try {
    function();
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), code) << error.what();
    return error.what();
  }
  return "nothing was refused";
}

void expect_words(const std::string& text, const std::vector<std::string>& words) {
  for (const std::string& word : words)
    EXPECT_NE(text.find(word), std::string::npos) << word << "\nis not in\n" << text;
}

// Loses the answer of the next write: it arrives, but nobody is told.
struct LostAnswer {
  std::shared_ptr<std::atomic<int>> left = std::make_shared<std::atomic<int>>(0);
  AnswerPlan::Fate fate = AnswerPlan::Fate::swallow;

  ServerHooks hooks() const {
    ServerHooks hooks;
    hooks.before_answer = [left = left, fate = fate](const ServerExchange& exchange) {
      AnswerPlan plan;
      const std::uint8_t function = exchange.request.front();
      const bool writes = function == 5 || function == 6 || function == 15 || function == 16;
      if (writes && left->load() > 0) {
        --*left;
        plan.fate = fate;
      }
      return plan;
    };
    return hooks;
  }
};

TEST(AmplifierPort, AWriteIsCheckedJournaledAndReadBack) {
  OpenPort open;
  open.port.write("current_limit", 1.234);
  EXPECT_NEAR(open.device.bank.get("current_limit"), 1.23, 1e-6);
  const auto records = open.records();
  ASSERT_EQ(records.size(), 3U);
  EXPECT_EQ(records[1]["write"], "current_limit");
  EXPECT_EQ(records[1]["address"], "holding 0x0010 (40017)");
  EXPECT_EQ(records[1]["old"], json({0, 0}));
  EXPECT_EQ(records[1]["new"][0], 0x3f9d);  // 1.23 as a float
  EXPECT_EQ(records[2]["done"], "current_limit");
}

TEST(AmplifierPort, WhatIsThereAlreadyIsNotWritten) {
  OpenPort open;
  open.port.write("damping_resistance", 10);
  const int before = open.device.bank.writes;
  open.port.write("damping_resistance", 10.1);  // the nearest step is the same
  EXPECT_EQ(open.device.bank.writes, before);
  EXPECT_EQ(open.port.statistics().skipped, 1U);
}

TEST(AmplifierPort, LimitsAreCheckedBeforeAnythingIsSent) {
  PortOptions options = applied;
  options.limits["current_limit"] = 0.5;
  OpenPort open(options);
  expect_words(refusal([&] { open.port.write("current_limit", 0.6); }),
               {"current_limit (holding 0x0010 (40017))", "0.6 A", "--limit allows at most 0.5 A"});
  expect_words(refusal([&] { open.port.write("damping_resistance", 1); }),
               {"1 ohm: must be at least 2 ohm"});
  expect_words(refusal([&] { open.port.write("current", 1); }), {"can only be read"});
  expect_words(refusal([&] { open.port.write("label", 1); }), {"persistent memory", "--persist"});
  expect_words(refusal([&] { open.port.write("labell", 1); }, ErrorCode::bad_input),
               {"did you mean 'label'"});
  EXPECT_EQ(open.device.bank.writes, 0);
  EXPECT_EQ(open.records().size(), 1U);
  open.port.write("current_limit", 0.5);
  EXPECT_EQ(open.port.upper_limit("current_limit"), 0.5);
}

TEST(AmplifierPort, AStuckRegisterIsNamedWithWhatWasWantedAndFound) {
  OpenPort open;
  open.device.bank.put("damping_resistance", 10);
  open.device.bank.stuck = {26, 27};
  expect_words(refusal([&] { open.port.write("damping_resistance", 20); }),
               {"damping_resistance (holding 0x001A (40027))", "wrote 20 ohm", "reads 10 ohm"});
}

TEST(AmplifierPort, ABitFieldIsWrittenIntoItsWord) {
  OpenPort open;
  open.port.write("status_light", 2);
  open.port.write("drive_mode", 1);
  EXPECT_EQ(open.device.bank.get("status_light"), 2);
  EXPECT_EQ(open.device.bank.get("drive_mode"), 1);
}

TEST(AmplifierPort, AWriteWhoseAnswerIsLostIsReadBackAndNotRepeated) {
  for (const auto fate : {AnswerPlan::Fate::swallow, AnswerPlan::Fate::halve,
                          AnswerPlan::Fate::garble, AnswerPlan::Fate::cut}) {
    const LostAnswer lost{.fate = fate};
    OpenPort open(applied, "gyrator_twin", lost.hooks());
    open.port.read("current_limit");  // the watchdog is fed
    *lost.left = 1;
    open.port.write("current_limit", 2);
    EXPECT_NEAR(open.device.bank.get("current_limit"), 2, 1e-9);
    EXPECT_EQ(open.port.statistics().recovered, 1U) << static_cast<int>(fate);
    EXPECT_EQ(open.port.statistics().repeated, 0U);
  }
}

TEST(AmplifierPort, AWriteThatIsKnownNotToHaveArrivedGoesOutAgain) {
  // The request is answered by nothing, and nothing is done.
  auto busy = std::make_shared<std::atomic<int>>(0);
  ServerHooks hooks;
  hooks.before_request =
      [busy](std::span<const std::uint8_t> request) -> std::optional<ModbusException> {
    const bool writes = request.front() == 16;
    if (!writes || busy->load() == 0) return {};
    --*busy;
    return ModbusException::device_busy;
  };
  OpenPort open(applied, "gyrator_twin", hooks);
  open.port.read("current_limit");
  *busy = 2;
  open.port.write("current_limit", 2);
  EXPECT_NEAR(open.device.bank.get("current_limit"), 2, 1e-9);
}

TEST(AmplifierPort, AnActionWhoseAnswerIsLostIsNotRepeated) {
  const LostAnswer lost;
  OpenPort open(applied, "integer_drive", lost.hooks());
  open.port.read("current_limit");
  const int before = open.device.bank.writes;
  *lost.left = 1;
  EXPECT_THROW(open.port.perform(open.device.profile.excitation->start), LinkError);
  EXPECT_EQ(open.device.bank.writes, before + 1);
}

TEST(AmplifierPort, SettingsAreReadInBlocksAndARefusedOneIsNamed) {
  OpenPort open(applied, "gyrator_twin");
  EXPECT_EQ(open.port.read_settings().settings.size(), 13U);
  open.device.bank.refused = {20};
  const SettingsBackup backup = open.port.read_settings();
  EXPECT_EQ(backup.settings.size(), 12U);
  ASSERT_EQ(backup.unreadable.size(), 1U);
  expect_words(backup.unreadable.front(),
               {"temperature_limit (holding 0x0014 (40021))", "illegal data address"});
}

TEST(AmplifierPort, WithoutApplyWritesArePlannedAndReadsAnswerAsIfDone) {
  PortOptions options = applied;
  options.apply = false;
  OpenPort open(options);
  open.port.write("current_limit", 2);
  open.port.write("current_limit", 2);
  open.port.perform(open.device.profile.excitation->start);
  EXPECT_EQ(open.device.bank.writes, 0);
  ASSERT_EQ(open.port.plan().size(), 1U);
  EXPECT_EQ(open.port.plan()[0].after->value, 2);
  EXPECT_EQ(open.port.read("current_limit"), 2);
  EXPECT_EQ(open.port.make_safe().state, DeviceState::safe);
  EXPECT_EQ(open.device.bank.writes, 0);
}

TEST(AmplifierPort, TheSafeStateHasTheDriveOffFirst) {
  OpenPort open;
  open.device.bank.put("enable", 1);
  open.device.bank.put("cancellation_resistance", 3);
  open.device.bank.put("current_limit", 5);
  open.device.bank.put("damping_resistance", 40);
  const auto result = open.port.make_safe();
  EXPECT_EQ(result.state, DeviceState::safe);
  ASSERT_FALSE(open.device.bank.written.empty());
  EXPECT_EQ(open.device.bank.written.front(), 0);  // the coil of enable
  EXPECT_EQ(open.device.bank.get("enable"), 0);
  EXPECT_EQ(open.device.bank.get("cancellation_resistance"), 0);
  EXPECT_EQ(open.device.bank.get("current_limit"), 0.5);
  EXPECT_EQ(open.device.bank.get("damping_resistance"), 40) << "has no safe value";
}

DeviceRegister& register_of(DeviceProfile& profile, const std::string& name) {
  return *std::find_if(profile.registers.begin(), profile.registers.end(),
                       [&](const DeviceRegister& place) { return place.name == name; });
}

TEST(AmplifierPort, TheDriveIsSwitchedOffBeforeAnythingIsRead) {
  auto functions = std::make_shared<std::vector<int>>();
  ServerHooks hooks;
  hooks.before_request =
      [functions](std::span<const std::uint8_t> request) -> std::optional<ModbusException> {
    functions->push_back(request.front());
    // No register can be read.
    return request.front() <= 4 ? std::optional(ModbusException::device_failure) : std::nullopt;
  };
  OpenPort open(applied, "gyrator_twin", hooks);
  open.device.bank.put("enable", 1);
  EXPECT_EQ(open.port.make_safe().state, DeviceState::unknown);
  ASSERT_FALSE(functions->empty());
  EXPECT_EQ(functions->front(), 5);
  EXPECT_EQ(open.device.bank.get("enable"), 0);
}

TEST(AmplifierPort, ABusyDeviceIsMadeSafeOnceItHasTime) {
  constexpr int busy_answers = 12;  // more often than a device may disobey
  auto busy = std::make_shared<std::atomic<int>>(busy_answers);
  ServerHooks hooks;
  hooks.before_request =
      [busy](std::span<const std::uint8_t> request) -> std::optional<ModbusException> {
    if (request.front() != 5 || busy->load() == 0) return {};
    --*busy;
    return ModbusException::device_busy;
  };
  PortOptions options = applied;
  options.safe_patience = 5;
  OpenPort open(options, "gyrator_twin", hooks);
  open.device.bank.put("enable", 1);
  const auto result = open.port.make_safe();
  EXPECT_EQ(result.state, DeviceState::safe)
      << (result.failed.empty() ? "" : result.failed.front());
  EXPECT_EQ(open.device.bank.get("enable"), 0);
}

TEST(AmplifierPort, TheSafeStateKeepsToTheLimitsAndRaisesNone) {
  for (const double limit : {0.3, 0.306}) {  // the steps are 0.01 A
    PortOptions options = applied;
    options.limits["current_limit"] = limit;
    OpenPort open(options);
    open.device.bank.put("current_limit", 5);
    EXPECT_EQ(open.port.make_safe().state, DeviceState::safe);
    EXPECT_NEAR(open.device.bank.get("current_limit"), 0.3, 1e-6) << limit;
    EXPECT_EQ(open.records().back()["write"], "current_limit");
    EXPECT_EQ(open.records().back()["old"], json({0x40a0, 0}));  // 5 as a float
  }
  OpenPort lower;
  lower.device.bank.put("current_limit", 0.2);
  EXPECT_EQ(lower.port.make_safe().state, DeviceState::safe);
  EXPECT_NEAR(lower.device.bank.get("current_limit"), 0.2, 1e-6);
}

TEST(AmplifierPort, TheSafeStateWritesPersistentRegistersOnlyIfAllowed) {
  for (const bool persist : {false, true}) {
    PortOptions options = applied;
    options.persist = persist;
    OpenPort open(options);
    register_of(open.device.profile, "label").safe = 7;
    open.device.bank.put("label", 3);
    EXPECT_EQ(open.port.make_safe().state, DeviceState::safe);
    EXPECT_EQ(open.device.bank.get("label"), persist ? 7 : 3);
  }
}

TEST(AmplifierPort, AnotherCtrlCDoesNotCutTheSafeStateOff) {
  OpenPort open;
  open.port.make_safe();
  testing::internal::CaptureStderr();
  std::raise(SIGINT);  // by default the end of this program
  expect_words(testing::internal::GetCapturedStderr(), {"one moment"});
  EXPECT_EQ(open.port.make_safe().state, DeviceState::safe);
}

TEST(AmplifierPort, ADeviceThatDoesNotObeyOrAnswerIsNotCalledSafe) {
  OpenPort open;
  open.device.bank.put("cancellation_resistance", 3);
  open.device.bank.stuck = {24, 25};
  auto result = open.port.make_safe();
  EXPECT_EQ(result.state, DeviceState::unknown);
  ASSERT_EQ(result.failed.size(), 1U);
  expect_words(result.failed[0], {"cancellation_resistance = 0 ohm", "does not keep"});
  open.device.stop();
  result = open.port.make_safe();
  EXPECT_EQ(result.state, DeviceState::unknown);
  EXPECT_FALSE(result.failed.empty());
}

TEST(AmplifierPort, TheWatchdogIsFedWhileItWaits) {
  OpenPort open(applied, "integer_drive");
  open.port.wait(0.9);
  EXPECT_GE(open.port.statistics().fed, 2U);  // 1 s is its period
  EXPECT_EQ(open.device.bank.get("watchdog"), 21845);
}

// Of a session that writes, with its journal in the folder; `said` has what a person is told.
SessionOptions make_options(const DeviceProfile& profile, const ScratchFolder& folder,
                            std::vector<std::string>& said) {
  SessionOptions options;
  options.port = applied;
  options.link = quick(profile);
  options.journal = folder / "journal";
  options.warn = [&said](const std::string& text) { said.push_back(text); };
  return options;
}

TEST(AmplifierSession, ADestructorPutsEverythingBackAndSaysSo) {
  ScratchFolder folder;
  ServedProfile device("gyrator_twin");
  device.bank.put("current_limit", 3);
  device.bank.put("cancellation_resistance", 1.5);
  device.bank.put("damping_resistance", 12);
  const auto before = device.bank.content();
  std::vector<std::string> said;
  const SessionOptions options = make_options(device.profile, folder, said);
  {
    AmplifierSession session(device.profile, device.address(), options);
    session.port().write("current_limit", 5);
    session.port().write("damping_resistance", 60);
    session.port().write("enable", 1);
  }
  auto after = device.bank.content();
  after[{RegisterTable::holding, 40}] = 0;  // the watchdog
  EXPECT_EQ(after, before);
  ASSERT_EQ(said.size(), 1U);
  expect_words(said[0], {"safe state", "as they were"});
  const SettingsJournalContent journal = read_settings_journal(folder / "journal");
  EXPECT_EQ(journal.state, "safe");
  EXPECT_EQ(journal.written.front(), "current_limit");
  EXPECT_FALSE(is_unfinished_journal(folder / "journal"));
}

TEST(AmplifierSession, ALeaveBeforeTheFirstWriteSaysHowTheDeviceIsToo) {
  ScratchFolder folder;
  ServedProfile device("gyrator_twin");
  const auto before = device.bank.content();
  std::vector<std::string> said;
  const SessionOptions options = make_options(device.profile, folder, said);
  { const AmplifierSession session(device.profile, device.address(), options); }
  auto after = device.bank.content();
  after[{RegisterTable::holding, 40}] = 0;  // the watchdog
  EXPECT_EQ(after, before);
  ASSERT_EQ(said.size(), 1U);
  expect_words(said[0], {"safe state", "as they were"});
}

TEST(AmplifierSession, ALostDeviceIsLoudAndItsJournalRestoresIt) {
  ScratchFolder folder;
  SessionOptions options;
  options.port = applied;
  options.port.safe_patience = 0.3;
  options.journal = folder / "journal";
  std::vector<std::string> said;
  options.warn = [&](const std::string& text) { said.push_back(text); };
  {
    ServedProfile device("gyrator_twin");
    options.link = quick(device.profile);
    AmplifierSession session(device.profile, device.address(), options);
    session.port().write("damping_resistance", 60);
    device.stop();
  }
  ASSERT_EQ(said.size(), 1U);
  expect_words(said[0], {"THE DEVICE IS NOT IN ITS SAFE STATE", "gyrator restore --journal"});
  EXPECT_TRUE(is_unfinished_journal(folder / "journal"));
  const SettingsJournalContent journal = read_settings_journal(folder / "journal");
  EXPECT_EQ(journal.backup.settings.size(), 13U);
  close_settings_journal(folder / "journal");
  EXPECT_FALSE(is_unfinished_journal(folder / "journal"));
}

TEST(AmplifierSession, OfTwoWritersTheSecondIsToldWhoTheFirstIs) {
  ScratchFolder folder;
  ServedProfile device("gyrator_twin");
  SessionOptions options;
  options.port = applied;
  options.link = quick(device.profile);
  options.journal = folder / "one";
  AmplifierSession first(device.profile, device.address(), options);
  options.journal = folder / "two";
  expect_words(refusal([&] { AmplifierSession second(device.profile, device.address(), options); }),
               {"in use by process " + std::to_string(::getpid())});
  first.restore();
}

TEST(AmplifierSession, AnotherDeviceIsNotTouched) {
  ScratchFolder folder;
  ServedProfile device("gyrator_twin");
  SessionOptions options;
  options.port = applied;
  options.link = quick(device.profile);
  options.journal = folder / "journal";
  DeviceProfile other = device.profile;
  other.identity.front().value = 4;
  expect_words(refusal([&] { AmplifierSession session(other, device.address(), options); }),
               {"device_id", "reads 26489", "has 4 there"});
  EXPECT_EQ(folder.count(), 0U);
}

TEST(SettingsJournal, ATornLastLineCostsNothing) {
  ScratchFolder folder;
  ServedProfile device("gyrator_twin");
  SessionOptions options;
  options.port = applied;
  options.link = quick(device.profile);
  options.journal = folder / "journal";
  AmplifierSession session(device.profile, device.address(), options);
  session.port().write("damping_resistance", 60);
  std::string text = read_text(folder / "journal");
  std::ofstream(folder / "torn", std::ios::binary) << text.substr(0, text.size() - 7);
  EXPECT_EQ(read_settings_journal(folder / "torn").written,
            std::vector<std::string>{"damping_resistance"});
  EXPECT_TRUE(is_unfinished_journal(folder / "torn"));
  EXPECT_EQ(session.restore().state, DeviceState::safe);
  EXPECT_EQ(device.bank.get("damping_resistance"), 2);
}

}  // namespace
}  // namespace gyrator
