#include "gyrator/amplifiers/amplifier_session.hpp"

#include "gyrator/core/error.hpp"
#include "gyrator/core/text.hpp"
#include "gyrator/version.hpp"

#include <cstdio>
#include <cstdlib>
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

void warn_on_stderr(const std::string& text) {
  fmt::print(stderr, "gyrator: {}\n", text);
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
  const std::string device = describe_device(address, options_.link.unit);
  // A serial line has room for one master; of a TCP device many may read.
  if (options_.port.apply || std::holds_alternative<SerialAddress>(address)) {
    lock_ = std::make_unique<SettingsLock>(device);
    unfinished_ = lock_->unfinished_journal();
    if (unfinished_ && !is_unfinished_journal(*unfinished_)) unfinished_.reset();
  }
  link_ = std::make_unique<ModbusLink>(address, options_.link);
  port_ = std::make_unique<AmplifierPort>(profile_, *link_, options_.port);
  port_->check_identity();
  backup_ = port_->read_settings();
  if (unfinished_ && options_.restores.empty()) {
    options_.warn(
        fmt::format("{}: an earlier session did not end; this puts its settings back: "
                    "gyrator restore --journal {} --apply",
                    device, *unfinished_));
  }
  if (options_.port.apply) begin_journal();
}

void AmplifierSession::begin_journal() {
  const std::filesystem::path path =
      options_.journal.empty() ? choose_journal_path(backup_.device) : options_.journal;
  const json header{{"schema", journal_schema_name},
                    {"program", fmt::format("gyrator {}", version)},
                    {"command", options_.command},
                    {"profile", profile_.name},
                    {"digest", profile_.digest},
                    {"profile_document", profile_.source},
                    {"connect", describe(link_->address())},
                    {"unit", link_->options().unit},
                    {"device", backup_.device},
                    {"time", backup_.time},
                    {"user", user_name()},
                    {"backup", describe_backup(backup_, profile_)}};
  journal_ = std::make_unique<SettingsJournal>(path, header);
  // Of several sessions that were cut off, the first knows what was there before.
  lock_->note_journal(!options_.restores.empty() ? options_.restores
                                                 : unfinished_.value_or(absolute(path).string()));
  port_->use_journal(journal_.get());
}

std::string AmplifierSession::journal_path() const {
  return journal_ ? journal_->path().string() : std::string();
}

void AmplifierSession::finish(DeviceState state, bool nothing_left) {
  ended_ = true;
  if (!journal_) return;
  journal_->finish(state);
  if (nothing_left && !(unfinished_ && options_.restores.empty())) lock_->finish();
}

SessionEnd AmplifierSession::restore() {
  SessionEnd end{DeviceState::safe, {}, journal_path()};
  if (!options_.port.apply) {
    ended_ = true;
    return end;
  }
  if (profile_.excitation) port_->perform(profile_.excitation->stop, true);
  put_back(*port_, backup_, true, true);
  finish(end.state, true);
  return end;
}

SessionEnd AmplifierSession::keep() {
  const bool changed = port_->has_written();
  const SessionEnd end{changed ? DeviceState::changed : DeviceState::safe, {}, journal_path()};
  finish(end.state, true);
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
    if (end.state == DeviceState::safe) {
      put_back(*port_, backup_, false, true);
      if (!compare_settings(profile_, port_->read_settings(), backup_).empty()) {
        end.failed.emplace_back(
            "the drive was on before and is off now; all else is as it was, or could not be read");
      }
    }
  } catch (const std::exception& error) {
    end.failed.push_back(fmt::format("settings could not be put back: {}", error.what()));
    const AmplifierPort::SafeResult again = port_->make_safe();
    end.state = again.state;
  }
  try {
    finish(end.state, end.state == DeviceState::safe && end.failed.empty());
  } catch (const std::exception& error) {
    end.failed.emplace_back(error.what());
  }
  return end;
}

AmplifierSession::~AmplifierSession() {
  if (ended_ || !options_.port.apply || !journal_) return;
  const bool wrote = port_->has_written();
  const SessionEnd end = abandon();
  try {
    if (end.state == DeviceState::unknown) {
      options_.warn(fmt::format(
          "THE DEVICE IS NOT IN ITS SAFE STATE, or could not be asked: {}. Switch its power off, "
          "or put everything back: gyrator restore --journal {} --apply",
          join(end.failed, "; "), end.journal));
    } else if (!end.failed.empty()) {
      options_.warn(fmt::format("the device is in its safe state; {}. Its journal: {}",
                                join(end.failed, "; "), end.journal));
    } else if (wrote) {
      options_.warn("the device is in its safe state, its settings as they were");
    }
  } catch (const std::exception&) {  // nobody is left to be told
  }
}

}  // namespace gyrator
