#include "gyrator/amplifiers/amplifier_session.hpp"

#include "gyrator/core/error.hpp"
#include "gyrator/core/text.hpp"
#include "gyrator/version.hpp"

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <iterator>
#include <unistd.h>
#include <utility>

#include <fmt/core.h>

namespace gyrator {
namespace {

using nlohmann::json;

std::string user_name() {
  const char* name = std::getenv("USER");
  return name != nullptr ? name : fmt::format("user {}", ::getuid());
}

// Where nobody reads stderr any more, that must not end what puts a device in order.
void warn_on_stderr(const std::string& text) {
  const std::string line = fmt::format("gyrator: {}\n", text);
  std::fwrite(line.data(), 1, line.size(), stderr);
  std::fflush(stderr);
}

}  // namespace

LinkOptions make_link_options(const DeviceProfile& profile) {
  LinkOptions options;
  const DeviceLink& link = profile.link;
  options.unit = link.unit;
  options.response_timeout = link.response_timeout;
  options.byte_timeout = link.byte_timeout;
  options.gap = link.gap;
  options.read_retries = link.retries;
  options.backoff = link.backoff;
  options.max_read = link.max_read;
  options.max_write = link.max_write;
  options.single_register_writes = link.single_register_writes;
  return options;
}

std::vector<SettingChange> put_back(AmplifierPort& port, const SettingsBackup& backup,
                                    bool may_enable, bool was_there) {
  const DeviceProfile& profile = port.profile();
  std::vector<SettingChange> changes =
      order_safely(compare_settings(profile, port.read_settings(), backup));
  std::erase_if(changes, [&](const SettingChange& change) {
    const bool switches_on = change.place->name == "enable" && change.after->pattern != 0;
    return !change.after || (switches_on && !may_enable);
  });
  const DeviceRegister* enable = profile.find("enable");
  if (changes.empty()) return changes;
  // What is set under a running motor would be felt at once.
  if (enable != nullptr && enable->readable && port.read(enable->name).value_or(0) != 0) {
    port.write(enable->name, 0);
    const SettingValue* was = backup.find(enable->name);
    const bool comes_back = was != nullptr && was->pattern != 0 && may_enable;
    if (comes_back) {
      for (const SettingChange& change : changes)
        if (change.place != enable) port.write_content(*change.after, was_there);
      port.write(enable->name, 1);
      return changes;
    }
  }
  for (const SettingChange& change : changes) port.write_content(*change.after, was_there);
  return changes;
}

AmplifierSession::AmplifierSession(DeviceProfile profile, const LinkAddress& address,
                                   SessionOptions options)
    : profile_(std::move(profile)), options_(std::move(options)) {
  if (!options_.warn) options_.warn = warn_on_stderr;
  if (!options_.restores.empty()) options_.restores = name_journal(options_.restores);
  const std::string device = describe_device(address, options_.link.unit);
  // A serial line has room for one master; of a TCP device many may read.
  if (options_.port.apply || std::holds_alternative<SerialAddress>(address)) {
    lock_ = std::make_unique<SettingsLock>(describe_line(address, options_.link.unit));
    unfinished_ = find_unfinished_journals(device, lock_->journals());
  }
  link_ = std::make_unique<ModbusLink>(address, options_.link);
  port_ = std::make_unique<AmplifierPort>(profile_, *link_, options_.port);
  port_->check_identity();
  backup_ = port_->read_settings();
  if (options_.port.apply) begin_journal();
  if (!unfinished_.empty() && unfinished_.front().path != options_.restores) {
    options_.warn(
        fmt::format("{}: an earlier session did not end; this puts its settings back: "
                    "gyrator restore --journal {} --apply",
                    device, unfinished_.front().path));
  }
  if (options_.port.apply) clear_old_fault();
}

// Of an earlier session; an amplifier with a fault has switched itself off.
void AmplifierSession::clear_old_fault() {
  if (!profile_.fault || !profile_.fault->clear) return;
  const std::vector<std::string> faults = port_->read_faults();
  if (faults.empty()) return;
  options_.warn(
      fmt::format("{}: a fault from before is cleared: {}", backup_.device, join(faults, ", ")));
  port_->clear_fault();
}

void AmplifierSession::begin_journal() {
  const std::filesystem::path path =
      options_.journal.empty() ? choose_journal_path(backup_.device) : options_.journal;
  const auto now = std::chrono::system_clock::now().time_since_epoch();
  json header{{"schema", journal_schema_name},
              {"program", fmt::format("gyrator {}", version)},
              {"command", options_.command},
              {"profile", profile_.name},
              {"digest", profile_.digest},
              {"profile_document", profile_.source},
              {"connect", describe(link_->address())},
              {"unit", link_->options().unit},
              {"device", backup_.device},
              {"time", backup_.time},
              {"begun", std::chrono::nanoseconds(now).count()},
              {"user", user_name()},
              {"backup", describe_backup(backup_, profile_)}};
  // One that cannot be written, another user's, is restored all the same.
  const bool reopens = !options_.restores.empty() && ::access(options_.restores.c_str(), W_OK) == 0;
  if (reopens) header["restores"] = options_.restores;
  journal_ = std::make_unique<SettingsJournal>(path, header);
  if (reopens) {
    reopen_settings_journal(options_.restores);
    std::vector<std::string> known = lock_->journals();
    known.push_back(options_.restores);
    unfinished_ = find_unfinished_journals(backup_.device, known);
  }
  note_journals();
  port_->use_journal(journal_.get());
}

// Other units' on the same line stay; what has ended meanwhile goes.
void AmplifierSession::note_journals() {
  std::vector<std::string> paths = lock_->journals();
  for (const UnfinishedJournal& each : unfinished_) paths.push_back(each.path);
  paths.push_back(name_journal(journal_->path()));
  std::sort(paths.begin(), paths.end());
  paths.erase(std::unique(paths.begin(), paths.end()), paths.end());
  std::erase_if(paths, [](const std::string& path) { return !is_unfinished_journal(path); });
  lock_->note_journals(std::move(paths));
}

std::string AmplifierSession::describe_way_back() const {
  return fmt::format("gyrator restore --journal {} --apply{}",
                     options_.restores.empty() ? journal_path() : options_.restores,
                     options_.port.persist ? " --persist" : "");
}

std::string AmplifierSession::journal_path() const {
  return journal_ ? journal_->path().string() : std::string();
}

void AmplifierSession::finish(const SessionEnd& end) {
  ended_ = true;
  if (!journal_) return;
  journal_->finish(end.state, end.failed.empty());
  note_journals();
}

// What began later knows only what the restored session had left behind.
void AmplifierSession::close_restored() {
  const auto restored =
      std::find_if(unfinished_.begin(), unfinished_.end(),
                   [&](const UnfinishedJournal& each) { return each.path == options_.restores; });
  std::vector<std::string> over{options_.restores};
  for (auto each = restored; each != unfinished_.end(); ++each)
    if (each != restored) over.push_back(each->path);
  for (const std::string& path : over) {
    try {
      close_settings_journal(path);
    } catch (const Error& error) {
      options_.warn(fmt::format("the settings are put back, but {}", error.what()));
    }
  }
  note_journals();
}

SessionEnd AmplifierSession::restore() {
  SessionEnd end{DeviceState::safe, {}, journal_path()};
  if (!options_.port.apply) {
    ended_ = true;
    return end;
  }
  if (profile_.excitation) port_->perform(profile_.excitation->stop, true);
  put_back(*port_, backup_, true, true);
  finish(end);
  return end;
}

SessionEnd AmplifierSession::keep() {
  const bool changed = port_->has_written();
  const SessionEnd end{changed ? DeviceState::changed : DeviceState::safe, {}, journal_path()};
  finish(end);
  if (journal_ && !options_.restores.empty()) close_restored();
  return end;
}

SessionEnd AmplifierSession::abandon() noexcept {
  SessionEnd end;
  ended_ = true;
  if (!options_.port.apply || !port_ || !journal_) return end;
  try {
    end.journal = journal_path();
    AmplifierPort::SafeResult safe = port_->make_safe();
    end.state = safe.state;
    end.failed = std::move(safe.failed);
    if (end.state == DeviceState::safe && !options_.restores.empty()) {
      end.failed.emplace_back("the restore did not come to its end: not all settings are put back");
    } else if (end.state == DeviceState::safe) {
      put_back(*port_, backup_, false, true);
      if (!compare_settings(profile_, port_->read_settings(), backup_).empty()) {
        end.failed.emplace_back(
            "the drive was on before and is off now; all else is as it was, or could not be read");
      }
    }
  } catch (const std::exception& error) {
    end.failed.push_back(fmt::format("settings could not be put back: {}", error.what()));
    AmplifierPort::SafeResult again = port_->make_safe();
    end.state = again.state;
    std::move(again.failed.begin(), again.failed.end(), std::back_inserter(end.failed));
  }
  try {
    finish(end);
  } catch (const std::exception& error) {
    end.failed.emplace_back(error.what());
  }
  return end;
}

AmplifierSession::~AmplifierSession() {
  if (ended_ || !options_.port.apply || !journal_) return;
  const SessionEnd end = abandon();
  try {
    if (end.state == DeviceState::unknown) {
      options_.warn(fmt::format(
          "THE DEVICE IS NOT IN ITS SAFE STATE, or could not be asked: {}. Switch its power off, "
          "or put everything back: {}",
          join(end.failed, "; "), describe_way_back()));
    } else if (!end.failed.empty()) {
      options_.warn(
          fmt::format("the device is in its safe state; {}. This puts everything back: {}",
                      join(end.failed, "; "), describe_way_back()));
    } else {
      options_.warn("the device is in its safe state, its settings as they were");
    }
  } catch (const std::exception&) {  // nobody is left to be told
  }
}

}  // namespace gyrator
