#pragma once

#include "gyrator/amplifiers/settings.hpp"

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <nlohmann/json.hpp>

namespace gyrator {

inline constexpr const char* journal_schema_name = "gyrator/amplifier-journal/1";

/// What became of a device when a session ended.
enum class DeviceState {
  safe,     ///< the drive off or as it was found, nothing left changed, or only to safe values
  changed,  ///< what was wanted is set
  unknown   ///< it could not be reached or does not obey
};
std::string_view name_of(DeviceState state);

/// A file of JSON lines from which everything can be put back after a crash: first the whole
/// backup, then each write before it goes out, on the disk before it does, and how it went.
///
///     {"schema": "gyrator/amplifier-journal/1", …, "backup": {…}}
///     {"write": "current_limit", "address": "holding 0x0010 (40017)", "old": [...], "new": [...]}
///     {"done": "current_limit"}
///     {"state": "safe"}
class SettingsJournal {
 public:
  /// Begins a new file with the header. Throws device where it cannot be written: nothing is then
  /// written to the device either.
  SettingsJournal(const std::filesystem::path& path, const nlohmann::json& header);
  ~SettingsJournal();

  SettingsJournal(const SettingsJournal&) = delete;
  SettingsJournal& operator=(const SettingsJournal&) = delete;
  SettingsJournal(SettingsJournal&&) = delete;
  SettingsJournal& operator=(SettingsJournal&&) = delete;

  /// On the disk when it returns.
  void intend(const DeviceRegister& place, const std::vector<std::uint16_t>& before,
              const std::vector<std::uint16_t>& after);
  /// How it went; lost with the power, which costs nothing. Never throws.
  void note(const nlohmann::json& record) noexcept;
  /// The last line.
  void finish(DeviceState state);

  const std::filesystem::path& path() const { return path_; }

 private:
  void append(const nlohmann::json& record, bool sync) const;

  std::filesystem::path path_;
  int file_ = -1;
};

/// A new file's path in $XDG_STATE_HOME/gyrator or ~/.local/state/gyrator, which is made.
std::filesystem::path choose_journal_path(const std::string& device);

/// A journal as it stands; a last line that is torn is passed over.
struct SettingsJournalContent {
  DeviceProfile profile;
  std::string connect;  ///< "tcp://127.0.0.1:1502"
  int unit = 1;
  std::string command;  ///< whose journal it is
  SettingsBackup backup;
  std::vector<std::string> written;  ///< names, in order
  std::optional<std::string> state;  ///< none: the session did not end
};
/// By the profile that stands in it. Throws bad_input for a file that is none, or whose profile or
/// backup is not as it must be.
SettingsJournalContent read_settings_journal(const std::string& path);

/// Appends that everything was put back. Throws bad_input where that cannot be written.
void close_settings_journal(const std::string& path);
/// Whether the file exists, is a journal and its session did not end.
bool is_unfinished_journal(const std::string& path);

}  // namespace gyrator
