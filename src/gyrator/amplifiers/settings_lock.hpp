#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace gyrator {

/// One process at a time may write to a device, of whichever user: a lock file per device address
/// or serial line in /run/lock, or in /tmp where not everybody may write there. The lock ends with
/// the process, however that ends. The file may name journals of sessions that were cut off, as a
/// hint until the next restart; without any, it goes with the lock.
class SettingsLock {
 public:
  /// `what` as describe_line gives it. Throws device, naming the process that has it, where
  /// another one does; device with the system's reason where the file cannot be made.
  explicit SettingsLock(const std::string& what);
  ~SettingsLock();

  SettingsLock(const SettingsLock&) = delete;
  SettingsLock& operator=(const SettingsLock&) = delete;
  SettingsLock(SettingsLock&&) = delete;
  SettingsLock& operator=(SettingsLock&&) = delete;

  /// The journals that the holders before have noted.
  const std::vector<std::string>& journals() const { return journals_; }
  /// Notes them for whoever comes after a crash, instead of those before. Costs only the hint where
  /// the file is another user's and cannot be written.
  void note_journals(std::vector<std::string> journals);

  const std::filesystem::path& path() const { return path_; }

 private:
  void write_note() const;

  std::filesystem::path path_;
  int file_ = -1;
  std::vector<std::string> journals_;
};

}  // namespace gyrator
