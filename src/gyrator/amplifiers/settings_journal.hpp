#pragma once

#include "gyrator/amplifiers/settings.hpp"

#include <cstdint>
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
  safe,     ///< the drive off or as it was found; what is left changed has a safe value
  changed,  ///< what was wanted is set
  unknown   ///< it could not be reached or does not obey
};
std::string_view name_of(DeviceState state);

/// A file of JSON lines from which everything can be put back after a crash: first the whole
/// backup, then each setting and each action before it goes out, on the disk before it does, and
/// how it went. What makes the device safe is only noted, for safety waits for no disk; feeding a
/// watchdog and moving a simulated clock are not entered.
///
///     {"schema": "gyrator/amplifier-journal/1", …, "backup": {…}}
///     {"write": "current_limit", "address": "holding 0x0010 (40017)", "old": [...], "new": [...]}
///     {"done": "current_limit"}
///     {"write": "enable", "new": [0], "safe": true}
///     {"state": "safe"}
///
/// The last state counts. With "restored": false, settings were left changed; "unknown" and
/// "restoring", or none, are of a session that did not end.
class SettingsJournal {
 public:
  /// Begins a new file with the header, on the disk when it returns. Throws device where it cannot
  /// be written, or is there already: no setting may then be written.
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
  /// The session's last line. `restored`: nothing is left changed that should not be.
  void finish(DeviceState state, bool restored = true);

  const std::filesystem::path& path() const { return path_; }

 private:
  void append(const nlohmann::json& record, bool sync) const;

  std::filesystem::path path_;
  int file_ = -1;
};

/// A new file's path in $XDG_STATE_HOME/gyrator or ~/.local/state/gyrator, which is made.
std::filesystem::path choose_journal_path(const std::string& device);
/// The one name of a journal's file: absolute, without links.
std::string name_journal(const std::filesystem::path& path);

/// A journal as it stands; a last line that is torn is passed over.
struct SettingsJournalContent {
  DeviceProfile profile;
  std::string connect;  ///< "tcp://127.0.0.1:1502"
  int unit = 1;
  std::string command;  ///< whose journal it is
  SettingsBackup backup;
  std::vector<std::string> written;  ///< names, in order
  std::optional<std::string> state;  ///< the last; none: the session did not end
};
/// By the profile that stands in it. Throws bad_input for a file that is none, with the line's
/// number for one that is not as it must be, and for a profile or a backup that is not.
SettingsJournalContent read_settings_journal(const std::string& path);

/// Appends that its backup is about to be put back: until it is closed, it counts as unfinished.
/// Throws bad_input where that cannot be written.
void reopen_settings_journal(const std::string& path);
/// Appends that everything was put back. Throws bad_input where that cannot be written.
void close_settings_journal(const std::string& path);

/// The journal of a session that was cut off, or that left settings changed against its will.
struct UnfinishedJournal {
  std::string path;        ///< of name_journal
  std::string device;      ///< of describe_device
  std::string time;        ///< of its begin, UTC
  std::int64_t begun = 0;  ///< the same [ns], of those of one second
};
/// Whether the file can be read and is such a journal; never throws.
bool is_unfinished_journal(const std::string& path);
/// Those of one device, the oldest first: of the newest 200 that choose_journal_path has named for
/// it, and of the `known` paths.
std::vector<UnfinishedJournal> find_unfinished_journals(const std::string& device,
                                                        const std::vector<std::string>& known = {});

}  // namespace gyrator
