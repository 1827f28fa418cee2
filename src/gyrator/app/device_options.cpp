#include "device_options.hpp"

#include "gyrator/core/error.hpp"
#include "gyrator/core/quantity.hpp"

#include <algorithm>
#include <utility>

#include <fmt/core.h>

#include "common_options.hpp"
#include "usage_errors.hpp"

namespace gyrator::app {
namespace {

std::pair<std::string, double> parse_limit(const std::string& text, const DeviceProfile& profile) {
  const std::size_t equals = text.find('=');
  if (equals == std::string::npos || equals == 0) {
    throw Error(ErrorCode::bad_input, "--limit",
                fmt::format("'{}': NAME=VALUE is expected, such as current_limit=0.5A", text));
  }
  try {
    const DeviceRegister& place = profile.at(text.substr(0, equals));
    const double value = parse_register_value(place, text.substr(equals + 1));
    if (!place.writable)
      throw Error(ErrorCode::bad_input, "", place.name + ": is only read: nothing writes it");
    if (value > range_of(place).high)
      throw Error(
          ErrorCode::bad_input, "",
          fmt::format("{}: the profile allows at most {}: a limit may be tighter, not wider", text,
                      describe_value(place, range_of(place).high)));
    return {place.name, value};
  } catch (const Error& error) {
    throw Error(ErrorCode::bad_input, "--limit", error.message());
  }
}

void require(const std::string& value, const char* name, const char* example) {
  if (!value.empty()) return;
  throw Error(ErrorCode::bad_input, name, fmt::format("is missing: such as {} {}", name, example));
}

}  // namespace

void add_device_options(CLI::App& command, DeviceOptions& options) {
  command
      .add_option("--connect", options.connect,
                  "Where the amplifier is:\n"
                  "  tcp://HOST[:PORT]\n"
                  "  rtu://DEVICE[?baud=B&parity=N|E|O&stop=1|2]")
      ->type_name("URL")
      ->check(not_empty());
  command
      .add_option("--profile", options.profile,
                  "Profile of the amplifier (JSON), or the name of a shipped one: gyrator_twin, "
                  "integer_drive")
      ->type_name("FILE|NAME")
      ->check(not_empty());
  command.add_option("--unit", options.unit, "Modbus address; by default the profile's")
      ->type_name("N")
      ->check(whole_number_between(0, 255));
  command
      .add_option("--timeout", options.timeout, "Until an answer begins; by default the profile's")
      ->type_name("SECONDS")
      ->check(not_empty());
  command.add_option("--log", options.log, "Write every byte on the wire into this file")
      ->type_name("FILE")
      ->check(not_empty());
}

void add_writing_device_options(CLI::App& command, DeviceOptions& options, bool journal) {
  add_device_options(command, options);
  command.add_flag("--apply", options.apply,
                   "Write to the amplifier; without it the plan is only shown");
  command.add_flag("--persist", options.persist,
                   "Registers in persistent memory may be written too");
  command
      .add_option("--limit", options.limits,
                  "NAME=VALUE, a bound tighter than the profile's, such as current_limit=0.5A; "
                  "once for each")
      ->type_name("TEXT")
      ->allow_extra_args(false)
      ->check(not_empty());
  if (!journal) return;
  command
      .add_option("--journal", options.journal,
                  "Where to keep what everything can be put back from; by default a new file in "
                  "~/.local/state/gyrator")
      ->type_name("FILE")
      ->check(not_empty());
}

DeviceSetup make_device_setup(const DeviceOptions& options, const std::string& command) {
  require(options.connect, "--connect", "tcp://127.0.0.1:1502");
  require(options.profile, "--profile", "gyrator_twin");
  return make_device_setup(options, command, load_device_profile(options.profile));
}

DeviceSetup make_device_setup(const DeviceOptions& options, const std::string& command,
                              DeviceProfile profile) {
  DeviceSetup setup{std::move(profile), {}, {}};
  try {
    setup.address = parse_link_address(options.connect);
  } catch (const Error& error) {
    throw Error(error.code(), "--connect", error.what());
  }
  // Not after the tuning.
  if (options.persist && command == "tune" && !setup.profile.persist) {
    throw Error(ErrorCode::bad_input, "--persist",
                setup.profile.name + ": its profile knows no way to keep settings (persist)");
  }
  setup.session.command = command;
  setup.session.journal = options.journal;
  setup.session.link = make_link_options(setup.profile);
  setup.session.link.wire_log = options.log;
  if (options.unit >= 0) setup.session.link.unit = static_cast<int>(options.unit);
  if (!options.timeout.empty()) {
    setup.session.link.response_timeout =
        parse_option_time("--timeout", options.timeout).to_double();
  }
  setup.session.port.apply = options.apply;
  setup.session.port.persist = options.persist;
  for (const std::string& text : options.limits) {
    const auto [name, limit] = parse_limit(text, setup.profile);
    const auto [known, is_new] = setup.session.port.limits.emplace(name, limit);
    if (!is_new) known->second = std::min(known->second, limit);
  }
  return setup;
}

std::unique_ptr<AmplifierSession> open_session(DeviceSetup setup) {
  return std::make_unique<AmplifierSession>(std::move(setup.profile), setup.address,
                                            std::move(setup.session));
}

nlohmann::json describe_statistics(const PortStatistics& statistics) {
  return {{"written", statistics.written},
          {"skipped", statistics.skipped},
          {"recovered", statistics.recovered}};
}

nlohmann::json describe_session(const std::vector<SettingChange>& plan, bool applied,
                                const SessionEnd& end) {
  nlohmann::json rows = nlohmann::json::array();
  for (const SettingChange& change : plan) rows.push_back(describe_change(change));
  return {{"plan", std::move(rows)},
          {"applied", applied},
          {"state", name_of(end.state)},
          {"journal", end.journal.empty() ? nlohmann::json(nullptr) : nlohmann::json(end.journal)}};
}

}  // namespace gyrator::app
