#pragma once

#include "gyrator/amplifiers/device_profile.hpp"
#include "gyrator/modbus/link_address.hpp"

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <nlohmann/json.hpp>

namespace gyrator {

inline constexpr const char* backup_schema_name = "gyrator/backup/1";

/// A register's content, as the device has it.
struct SettingValue {
  std::string name;
  std::vector<std::uint16_t> words;  ///< of a bit field, the whole word
  std::uint64_t pattern = 0;         ///< its own bits
  std::optional<double> value;       ///< [SI]; none where the device says that it has none
};

/// All settings of a device at one time.
struct SettingsBackup {
  std::string profile, digest;  ///< name and digest of the profile that they were read by
  std::string device;           ///< "tcp://127.0.0.1:1502 unit 1"
  std::string time;             ///< UTC, ISO 8601
  std::vector<SettingValue> settings;
  std::vector<std::string> unreadable;  ///< names, with the reason

  const SettingValue* find(std::string_view name) const;
};

/// What words hold, by the register's type.
SettingValue take_value(const DeviceRegister& place, std::vector<std::uint16_t> words);

/// One row of a plan or of a difference.
struct SettingChange {
  const DeviceRegister* place = nullptr;
  std::optional<SettingValue> before, after;  ///< none where that side does not have it
};

/// The settings whose content differs, in the order of the profile.
std::vector<SettingChange> compare_settings(const DeviceProfile& profile,
                                            const SettingsBackup& before,
                                            const SettingsBackup& after);

/// The changes in an order in which the motor is safe at each step: the drive off first, what it is
/// to be last.
std::vector<SettingChange> order_safely(std::vector<SettingChange> changes);

/// The backup as a JSON document, and back. parse_backup throws bad_input with file and JSON
/// pointer for what is none, for a register that the profile does not have, and for words that are
/// not of its type.
nlohmann::json describe_backup(const SettingsBackup& backup, const DeviceProfile& profile);
SettingsBackup parse_backup(const nlohmann::json& document, const DeviceProfile& profile,
                            const std::string& file);
SettingsBackup load_backup(const std::string& path, const DeviceProfile& profile);

/// {register, address, old, new, unit}; values in SI, switches and codes as numbers.
nlohmann::json describe_change(const SettingChange& change);
/// A table for people: register, address, old, new in the profile's units.
std::string describe_changes(const std::vector<SettingChange>& changes);
/// The same without the old values.
std::string describe_contents(const std::vector<SettingChange>& contents);

/// "tcp://127.0.0.1:1502 unit 1": the same for the same device, where that can be known; a serial
/// line without its settings.
std::string describe_device(const LinkAddress& address, int unit);
/// What only one process may use at a time: a serial line whatever the unit, for it has room for
/// one master; of TCP, the device.
std::string describe_line(const LinkAddress& address, int unit);

/// "2026-11-21T20:15:00Z"
std::string describe_time_now();

}  // namespace gyrator
