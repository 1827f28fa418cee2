// backup, diff, restore: all settings of an amplifier, kept, compared and put back.
#include "gyrator/amplifiers/settings.hpp"
#include "gyrator/core/error.hpp"
#include "gyrator/core/text.hpp"
#include "gyrator/documents/json_text.hpp"
#include "gyrator/documents/output_file.hpp"
#include "gyrator/version.hpp"

#include <memory>

#include <fmt/core.h>

#include "commands.hpp"
#include "common_options.hpp"
#include "device_options.hpp"
#include "usage_errors.hpp"

namespace gyrator::app {
namespace {

using nlohmann::json;

constexpr const char* exit_codes =
    "\n\nExit codes: 0 done, 2 bad input, 4 device or communication failure, or refused for "
    "safety.";

struct SettingsOptions {
  DeviceOptions device;
  std::string file, other, output;
  bool json = false, quiet = false;
};

void add_text_options(CLI::App& command, SettingsOptions& options) {
  command.add_flag("--json", options.json, "Print one JSON object and nothing else");
  command.add_flag("--quiet", options.quiet, "No text, only files and the exit code");
}

void print(const SettingsOptions& options, json result, const char* command,
           const std::string& text) {
  CommonOptions common;
  common.json = options.json;
  common.quiet = options.quiet;
  result["command"] = command;
  result["program"] = fmt::format("gyrator {}", version);
  deliver(common, std::move(result), text);
}

void warn_of_unreadable(const SettingsBackup& backup) {
  for (const std::string& each : backup.unreadable)
    print_note(fmt::format("gyrator: warning: could not be read: {}\n", each));
}

// As changes from nothing, so that backups and differences look alike.
std::vector<SettingChange> as_changes(const SettingsBackup& backup, const DeviceProfile& profile) {
  return compare_settings(profile, SettingsBackup{}, backup);
}

void run_backup(const SettingsOptions& options) {
  check_files({{"the profile", options.device.profile}}, {{"--output", options.output}});
  const auto session = open_session(make_device_setup(options.device, "backup"));
  const SettingsBackup& backup = session->backup();
  const SessionEnd end = session->restore();
  warn_of_unreadable(backup);
  json document = describe_backup(backup, session->profile());
  document["program"] = fmt::format("gyrator {}", version);
  if (!options.output.empty()) write_text_file(options.output, document.dump(1) + "\n");
  json result = describe_session({}, false, end);
  result["backup"] = std::move(document);
  result["output"] = options.output.empty() ? json(nullptr) : json(options.output);
  std::string text = fmt::format("{}, {}: {}\n", backup.profile, backup.device,
                                 describe_count(backup.settings.size(), "setting"));
  if (options.output.empty()) {
    text += "\n" + describe_contents(as_changes(backup, session->profile()));
  } else {
    text += options.output + "\n";
  }
  print(options, std::move(result), "backup", text);
}

SettingsBackup read_device(const SettingsOptions& options) {
  const auto session = open_session(make_device_setup(options.device, "diff"));
  session->restore();
  warn_of_unreadable(session->backup());
  return session->backup();
}

void check_profile_name(const SettingsBackup& backup, const DeviceProfile& profile,
                        const std::string& file) {
  if (backup.profile == profile.name) return;
  throw Error(ErrorCode::bad_input, file,
              fmt::format("is of a {}, by its profile: the profile given is of a {}",
                          backup.profile, profile.name));
}

void run_diff(const SettingsOptions& options, int& exit_code) {
  if (options.device.profile.empty())
    throw Error(ErrorCode::bad_input, "--profile", "is missing: such as --profile gyrator_twin");
  if (options.other.empty() == options.device.connect.empty()) {
    throw Error(ErrorCode::bad_input, "diff",
                "a backup and either a second one or --connect URL are expected");
  }
  const DeviceProfile profile = load_device_profile(options.device.profile);
  const SettingsBackup before = load_backup(options.file, profile);
  check_profile_name(before, profile, options.file);
  const SettingsBackup after =
      options.other.empty() ? read_device(options) : load_backup(options.other, profile);
  check_profile_name(after, profile, options.other);
  const std::vector<SettingChange> changes = compare_settings(profile, before, after);
  exit_code = changes.empty() ? 0 : 1;
  json result = describe_session(changes, false, {});
  result["equal"] = changes.empty();
  print(options, std::move(result), "diff",
        changes.empty() ? "equal\n" : describe_changes(changes));
}

struct RestoreTask {
  DeviceSetup setup;
  SettingsBackup backup;
};

// From a journal everything is known; from a backup, where the device is must be said.
RestoreTask read_task(const SettingsOptions& options) {
  if (options.file.empty() == options.device.journal.empty())
    throw Error(ErrorCode::bad_input, "restore", "either a backup or --journal FILE is expected");
  DeviceOptions device = options.device;
  device.journal.clear();  // of this session itself
  if (!options.file.empty()) {
    DeviceSetup setup = make_device_setup(device, "restore");
    SettingsBackup backup = load_backup(options.file, setup.profile);
    check_profile_name(backup, setup.profile, options.file);
    return {std::move(setup), std::move(backup)};
  }
  const std::string& journal = options.device.journal;
  SettingsJournalContent content = read_settings_journal(journal);
  if (device.connect.empty()) device.connect = content.connect;
  if (device.unit < 0) device.unit = content.unit;
  if (!device.profile.empty()) {
    check_profile_name(content.backup, load_device_profile(device.profile), journal);
  }
  DeviceSetup setup = make_device_setup(device, "restore", std::move(content.profile));
  setup.session.restores = journal;
  return {std::move(setup), std::move(content.backup)};
}

void run_restore(const SettingsOptions& options) {
  RestoreTask task = read_task(options);
  const bool apply = options.device.apply;
  const auto session = open_session(std::move(task.setup));
  AmplifierPort& port = session->port();
  if (apply && session->profile().excitation)
    port.perform(session->profile().excitation->stop, true);
  const bool by_journal = !options.device.journal.empty();
  // What a session had found goes back whatever the profile allows; --limit still holds if given.
  const bool was_there = by_journal && options.device.limits.empty();
  const std::vector<SettingChange> plan = put_back(port, task.backup, true, was_there);
  SessionEnd end = apply ? session->keep() : session->restore();
  // Of a journal: everything is as it was. Of a backup: it is as was wanted now.
  end.state = apply && !by_journal && !plan.empty() ? DeviceState::changed : DeviceState::safe;
  std::string text;
  if (plan.empty()) {
    text = "nothing differs: nothing to write\n";
  } else {
    text = describe_changes(plan);
    text +=
        apply ? fmt::format("\n{} written and read back.\n", describe_count(plan.size(), "setting"))
              : "\nDry run: nothing was written. With --apply it is.\n";
  }
  if (!end.journal.empty()) text += "Journal: " + end.journal + "\n";
  json result = describe_session(plan, apply, end);
  result["statistics"] = describe_statistics(port.statistics());
  print(options, std::move(result), "restore", text);
}

}  // namespace

void add_backup_command(CLI::App& app, int&) {
  auto options = std::make_shared<SettingsOptions>();
  CLI::App* command = app.add_subcommand("backup", "Keep all settings of an amplifier in a file");
  add_device_options(*command, options->device);
  command->add_option("-o,--output", options->output, "Backup file (JSON); without it, a table")
      ->type_name("FILE")
      ->check(not_empty());
  add_text_options(*command, *options);
  command->footer(std::string("Example:\n  gyrator backup --connect tcp://127.0.0.1:1502 "
                              "--profile gyrator_twin -o before.json") +
                  exit_codes);
  command->callback([options] { run_backup(*options); });
}

void add_diff_command(CLI::App& app, int& exit_code) {
  auto options = std::make_shared<SettingsOptions>();
  CLI::App* command =
      app.add_subcommand("diff", "What differs between a backup and an amplifier, or two backups");
  command->add_option("BACKUP", options->file, "Backup file (JSON): the old values")
      ->required()
      ->check(not_empty());
  command->add_option("OTHER", options->other, "Backup with the new values, instead of --connect")
      ->check(not_empty());
  add_device_options(*command, options->device);
  add_text_options(*command, *options);
  command->footer(std::string("Example:\n  gyrator diff before.json --connect "
                              "tcp://127.0.0.1:1502 --profile gyrator_twin") +
                  "\n\nExit codes: 0 equal, 1 different, 2 bad input, 4 device or communication "
                  "failure.");
  command->callback([options, &exit_code] { run_diff(*options, exit_code); });
}

void add_restore_command(CLI::App& app, int&) {
  auto options = std::make_shared<SettingsOptions>();
  CLI::App* command = app.add_subcommand(
      "restore", "Put an amplifier's settings back, from a backup or from a session's journal");
  command->add_option("BACKUP", options->file, "Backup file (JSON)")->check(not_empty());
  command
      ->add_option("--journal", options->device.journal,
                   "Journal of a session that was cut off, instead of a backup: device and profile "
                   "stand in it")
      ->type_name("FILE")
      ->check(not_empty());
  add_writing_device_options(*command, options->device, false);
  add_text_options(*command, *options);
  command->footer(
      std::string(
          "Example:\n  gyrator restore before.json --connect tcp://127.0.0.1:1502 "
          "--profile gyrator_twin --apply\n\nThe drive is switched off first; if the backup "
          "has it on, it is switched on last.") +
      exit_codes);
  command->callback([options] { run_restore(*options); });
}

}  // namespace gyrator::app
