#pragma once

#include <filesystem>
#include <optional>
#include <string>

namespace gyrator {

/// One process at a time may write to a device: a lock file per device address, in
/// $XDG_RUNTIME_DIR or /tmp. It ends with the process, however that ends; what the file says of its
/// last holder stays, so that the next one knows of a session that was cut off.
class SettingsLock {
 public:
  /// `device` as describe_device gives it. Throws device, naming the process that has it, where
  /// another one does; device with the system's reason where the file cannot be made.
  explicit SettingsLock(const std::string& device);
  ~SettingsLock();

  SettingsLock(const SettingsLock&) = delete;
  SettingsLock& operator=(const SettingsLock&) = delete;
  SettingsLock(SettingsLock&&) = delete;
  SettingsLock& operator=(SettingsLock&&) = delete;

  /// The journal of the holder before, where it did not end as it should.
  const std::optional<std::string>& unfinished_journal() const { return unfinished_; }

  /// Notes where this session's journal is, for whoever comes after a crash.
  void note_journal(const std::string& journal);
  /// The session has ended and left nothing to put back; without it the note stays.
  void finish();

  const std::filesystem::path& path() const { return path_; }

 private:
  void write_note(const std::string& journal) const;

  std::filesystem::path path_;
  int file_ = -1;
  std::optional<std::string> unfinished_;
};

}  // namespace gyrator
