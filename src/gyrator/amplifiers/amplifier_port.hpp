#pragma once

#include "gyrator/amplifiers/device_profile.hpp"
#include "gyrator/amplifiers/settings.hpp"
#include "gyrator/amplifiers/settings_journal.hpp"
#include "gyrator/core/interrupt.hpp"
#include "gyrator/modbus/modbus_link.hpp"

#include <chrono>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace gyrator {

/// What may be done to a device.
struct PortOptions {
  bool apply = false;    ///< false: writes are only planned
  bool persist = false;  ///< persistent registers may be written
  /// Tighter than the profile: no larger magnitude is written, nor allowed to flow [SI].
  std::map<std::string, double> limits;
  double safe_patience = 5;  ///< how long a lost device is tried to be made safe [s]
};

struct PortStatistics {
  std::uint64_t written = 0;    ///< settings and actions that went out
  std::uint64_t skipped = 0;    ///< the register had the value already
  std::uint64_t recovered = 0;  ///< whose answer was lost, and that read back as written
  std::uint64_t repeated = 0;   ///< whose answer was lost, that had not arrived, and went out again
  std::uint64_t fed = 0;        ///< of the watchdog
};

/// The way to an amplifier's registers, and the only one: nothing else writes.
///
/// A write is checked against access, the profile's limits, the command line's, and step; is
/// skipped where the register has the value already; stands in the journal before it goes out; is
/// sent once, in one request; and is read back after the settling time. A write whose answer is
/// lost is read back too: it has arrived, or it is sent again after it is known that it has not, or
/// it has become something else, which ends in an error. What cannot be read back is not repeated.
/// Without `apply` it is entered into the plan instead, and reads answer as if it had been done.
///
/// Errors: device for a refused value (naming the register, what was asked for and what is
/// allowed), a register that does not keep what was written (wanted and found), and for the link
/// (LinkError); bad_input for a name that the profile does not have; interrupted after Ctrl-C.
/// After any of them make_safe() is to be called, which AmplifierSession does.
class AmplifierPort {
 public:
  /// The journal is none without `apply`; profile and link outlive the port.
  AmplifierPort(const DeviceProfile& profile, ModbusLink& link, PortOptions options,
                SettingsJournal* journal = nullptr);

  const DeviceProfile& profile() const { return profile_; }
  const PortOptions& options() const { return options_; }
  const PortStatistics& statistics() const { return statistics_; }
  ModbusLink& link() { return link_; }
  void use_journal(SettingsJournal* journal) { journal_ = journal; }

  /// Throws device where a register of `identity` reads otherwise.
  void check_identity();

  /// [SI]; none where the device says that it has no such value.
  std::optional<double> read(std::string_view name);
  /// The same, where there must be one.
  double read_value(std::string_view name);
  /// All settings, in blocks of neighbours; those that the device refuses are named, not fatal.
  SettingsBackup read_settings();
  /// Registers by name in as few requests as may be; none for what has no value or is refused.
  std::map<std::string, std::optional<double>> read_several(const std::vector<std::string>& names);
  /// `samples` numbers of a capture's window from its first address on [SI].
  std::vector<double> read_window(const DeviceRegister& first, int samples);

  void write(std::string_view name, double value);
  /// A content word by word; its own bits, of a bit field. What was read from the device itself
  /// (`was_there`) is put back whatever the limits are. Any other must have a value within them:
  /// words that stand for none are refused, unless the register has them already.
  void write_content(const SettingValue& content, bool was_there = false);
  /// A write that makes something happen: it always goes out, and is not read back. Where doing it
  /// twice is as good as once (`repeatable`), it goes out again if its answer is lost.
  void perform(const DeviceAction& action, bool repeatable = false);
  /// Makes the device keep its settings over a power cycle; needs `persist`.
  void keep_settings();

  /// What the fault register says, in words; empty where all is well.
  std::vector<std::string> read_faults();
  void clear_fault();

  /// Lets device time pass [s]: moves its clock, or sleeps; feeds the watchdog meanwhile.
  void wait(double seconds);
  /// Feeds the watchdog if it is due; every other function does so too.
  void feed_watchdog();

  /// The largest that may be written [SI], by profile and command line.
  double upper_limit(std::string_view name) const;

  /// What was to be written, without `apply`.
  const std::vector<SettingChange>& plan() const { return plan_; }
  /// Whether anything has been written.
  bool has_written() const { return statistics_.written > 0; }

  struct SafeResult {
    DeviceState state = DeviceState::safe;
    std::vector<std::string> failed;  ///< what could not be done, and why
    bool answers = true;              ///< to the last request
  };
  /// Drive off first, before anything is read, then the generator, then every register's safe
  /// value, each read back; tries over new connections, and while the device is busy, for
  /// safe_patience. A safe value is cut to --limit; a register `..._limit` that stands lower
  /// already and, without `persist`, persistent ones stay as they are. Never throws; from here on,
  /// as long as the port lives, Ctrl-C, SIGTERM and SIGHUP are only answered (InterruptShield).
  SafeResult make_safe() noexcept;

 private:
  using Words = std::vector<std::uint16_t>;

  Words read_words(const DeviceRegister& place);
  Words read_from_device(const DeviceRegister& place);
  std::vector<std::optional<SettingValue>> read_places(
      const std::vector<const DeviceRegister*>& places, std::vector<std::string>& refused);
  void send_words(const DeviceRegister& place, const Words& words);
  RawValue check_value(const DeviceRegister& place, double value) const;
  void check_access(const DeviceRegister& place) const;
  void write_raw(const DeviceRegister& place, const RawValue& raw);
  void send_until_known(const DeviceRegister& place, const Words& before, const Words& after,
                        bool can_look, bool repeatable = false);
  void verify(const DeviceRegister& place, const Words& wanted);
  void reconnect_patiently(std::chrono::steady_clock::time_point until);
  enum class SafeStep { drive_off, action, setting };
  void make_safe_step(const DeviceRegister& place, double value, SafeStep step,
                      std::chrono::steady_clock::time_point until, SafeResult& result);
  bool try_safe_step(const DeviceRegister& place, double value, SafeStep step);
  void journal_safe_step(const DeviceRegister& place, const Words& before, const Words& wanted,
                         SafeStep step) noexcept;
  double find_safe_value(const DeviceRegister& place) const;
  bool advance_clock(double seconds);

  const DeviceProfile& profile_;
  ModbusLink& link_;
  PortOptions options_;
  SettingsJournal* journal_;
  PortStatistics statistics_;
  std::vector<SettingChange> plan_;
  std::map<std::pair<RegisterTable, int>, Words> planned_;  // contents, by address
  std::chrono::steady_clock::time_point fed_{};
  int since_fed_ = 0;        // requests
  bool clock_moves_ = true;  // what is written to it moves the device's time
  bool feeding_ = false;
  std::optional<InterruptShield> shield_;
};

}  // namespace gyrator
