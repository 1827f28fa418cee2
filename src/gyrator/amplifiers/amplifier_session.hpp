#pragma once

#include "gyrator/amplifiers/amplifier_port.hpp"
#include "gyrator/amplifiers/settings_journal.hpp"
#include "gyrator/amplifiers/settings_lock.hpp"

#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <vector>

namespace gyrator {

struct SessionOptions {
  PortOptions port;
  LinkOptions link;               ///< of make_link_options, with what the command line says
  std::string command;            ///< "identify", for the journal
  std::filesystem::path journal;  ///< empty: choose_journal_path
  /// Of a restore, the journal whose backup is put back: it counts as unfinished until keep().
  std::string restores;
  /// Takes what a person must know at once; by default stderr.
  std::function<void(const std::string&)> warn;
};

/// The profile's own options for the link.
LinkOptions make_link_options(const DeviceProfile& profile);

struct SessionEnd {
  DeviceState state = DeviceState::safe;
  std::vector<std::string> failed;  ///< what could not be done, and why
  std::string journal;              ///< empty: nothing was to be written
};

/// A device that is worked on, from the connection to the state it is left in.
///
/// With `apply`: takes the lock, checks the identity, reads all settings and begins the journal
/// with them, before anything is written. Then either restore() or keep() ends it; if neither is
/// called, as after any exception, the destructor makes the device safe, puts the settings back
/// with the drive off, and says loudly what it could not do and how to go on. A restore that fails
/// does not go back to what the crash had left: it ends in the safe state, to be done again.
class AmplifierSession {
 public:
  /// Throws what AmplifierPort, ModbusLink and SettingsLock throw.
  AmplifierSession(DeviceProfile profile, const LinkAddress& address, SessionOptions options);
  ~AmplifierSession();

  AmplifierSession(const AmplifierSession&) = delete;
  AmplifierSession& operator=(const AmplifierSession&) = delete;
  AmplifierSession(AmplifierSession&&) = delete;
  AmplifierSession& operator=(AmplifierSession&&) = delete;

  AmplifierPort& port() { return *port_; }
  const DeviceProfile& profile() const { return profile_; }
  /// All settings as they were at the session's begin.
  const SettingsBackup& backup() const { return backup_; }
  /// Empty without `apply`.
  std::string journal_path() const;
  /// The journals of earlier sessions with this device that did not end, the oldest first: it
  /// knows what was there before.
  const std::vector<UnfinishedJournal>& unfinished_journals() const { return unfinished_; }

  /// Ends the session with every setting as it was, the drive too. Throws like a write; then the
  /// destructor does what it can.
  SessionEnd restore();
  /// Ends the session with the settings as they are now. Of a restore, they are as its journal has
  /// them: that one and those begun later have nothing left to put back.
  SessionEnd keep();
  /// Ends the session as after an exception: safe, and the settings put back with the drive off.
  SessionEnd abandon() noexcept;

 private:
  void begin_journal();
  void clear_old_fault();
  void finish(const SessionEnd& end);
  void close_restored();
  void note_journals();
  std::string describe_way_back() const;

  DeviceProfile profile_;
  SessionOptions options_;
  std::unique_ptr<SettingsLock> lock_;
  std::unique_ptr<ModbusLink> link_;
  std::unique_ptr<SettingsJournal> journal_;
  std::unique_ptr<AmplifierPort> port_;
  SettingsBackup backup_;
  std::vector<UnfinishedJournal> unfinished_;
  bool ended_ = false;
};

/// Writes what differs between the device and a backup, the drive off first; `enable` is switched
/// on again only if `may_enable`. `was_there`: as of AmplifierPort::write_content. Returns what was
/// (or is planned to be) changed.
std::vector<SettingChange> put_back(AmplifierPort& port, const SettingsBackup& backup,
                                    bool may_enable, bool was_there = false);

}  // namespace gyrator
