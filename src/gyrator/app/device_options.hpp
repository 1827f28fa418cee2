#pragma once

#include "gyrator/amplifiers/amplifier_session.hpp"

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>

namespace gyrator::app {

/// What every command that talks to an amplifier offers.
struct DeviceOptions {
  std::string connect;  ///< "tcp://127.0.0.1:1502"
  std::string profile;  ///< path, or name of a shipped one
  long unit = -1;       ///< -1: the profile's
  std::string timeout;  ///< empty: the profile's
  std::string log;      ///< every byte on the wire
  std::string journal;  ///< empty: a new file among the user's state
  bool apply = false, persist = false;
  std::vector<std::string> limits;  ///< "current_limit=0.5A"
};

/// --connect, --profile, --unit, --timeout, --log: for reading.
void add_device_options(CLI::App& command, DeviceOptions& options);
/// The same and --apply, --persist, --limit: for commands that write. `journal`: also --journal
/// FILE, where to keep what everything can be put back from.
void add_writing_device_options(CLI::App& command, DeviceOptions& options, bool journal = true);

/// Profile, address and options for a session, all checked. `command` is for the journal. Throws
/// bad_input, naming the option.
struct DeviceSetup {
  DeviceProfile profile;
  LinkAddress address;
  SessionOptions session;
};
DeviceSetup make_device_setup(const DeviceOptions& options, const std::string& command);
/// With a profile that is known already.
DeviceSetup make_device_setup(const DeviceOptions& options, const std::string& command,
                              DeviceProfile profile);

/// Connects. Errors as of AmplifierSession.
std::unique_ptr<AmplifierSession> open_session(DeviceSetup setup);

/// What was written, as {written, skipped, recovered}: the key "statistics" of such a JSON.
nlohmann::json describe_statistics(const PortStatistics& statistics);

/// The keys that every such command's JSON has: plan, applied, state, journal.
nlohmann::json describe_session(const std::vector<SettingChange>& plan, bool applied,
                                const SessionEnd& end);

}  // namespace gyrator::app
