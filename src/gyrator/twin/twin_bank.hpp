#pragma once

#include "gyrator/amplifiers/device_profile.hpp"
#include "gyrator/modbus/register_bank.hpp"
#include "gyrator/twin/simulated_amplifier.hpp"

#include <chrono>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace gyrator {

struct TwinBankOptions {
  /// Device seconds per second of the wall clock. None: time passes only by requests (pass()), by
  /// writing the clock's register, and when the capture's state is read while it is busy, which is
  /// its end then. The watchdog sleeps: nobody could feed it in time.
  std::optional<double> pace = 1.0;
  /// A register that takes every write and keeps its value; empty for none.
  std::string stuck;
};

/// The registers of any device profile on a simulated amplifier.
///
/// Registers of a well-known name (SimulatedAmplifier::setting_names, actual_names) act on it, as
/// do those that the profile's fault, watchdog, persist, clock, excitation and capture blocks name;
/// identity registers have their value, and all others are plain memory. Settings start at the
/// nearest value that their registers can hold.
///
/// What the profile says is enforced. Exception 2: no such register, or not readable or writable;
/// holes of up to max_hole between registers read as zero. Exception 3: more registers than
/// max_read or max_write, a part of a number of several words, a value outside the limits, off the
/// step or of no code, and what the circuit cannot be. Exception 4: what the amplifier refuses, as
/// to enable with a fault. A write is done whole or not at all. Times are rounded to ticks.
class TwinBank final : public RegisterBank {
 public:
  /// All three outlive the bank but the options. Throws bad_input for an unknown stuck register.
  TwinBank(SimulatedAmplifier& amplifier, const DeviceProfile& profile, TwinBankOptions options);

  Answer<std::vector<bool>> read_bits(RegisterTable table, int address, int count) override;
  Answer<std::vector<std::uint16_t>> read_registers(RegisterTable table, int address,
                                                    int count) override;
  std::optional<ModbusException> write_coils(int address, const std::vector<bool>& values) override;
  std::optional<ModbusException> write_registers(int address,
                                                 std::span<const std::uint16_t> words) override;

  /// Brings the amplifier to the wall clock; to be called now and then. Nothing without a pace.
  void keep_pace();
  /// A request with its answer took so long [s]; nothing with a pace.
  void pass(double seconds);

  /// How often each register was written, equal values included.
  const std::map<std::string, long>& write_counts() const { return write_counts_; }
  /// How often the settings were made to outlast a power cycle.
  long persist_count() const { return persist_count_; }

 private:
  using Words = std::vector<std::uint16_t>;
  // A register that a write covers, and what it is to be.
  struct Change {
    std::size_t index;
    RawValue raw;
    double value;
  };

  std::optional<ModbusException> read_words(RegisterTable table, int address, int count, Words& to);
  void put_capture(RegisterTable table, int address, Words& words);
  bool is_readable(RegisterTable table, int address, int count) const;
  std::optional<ModbusException> write_words(RegisterTable table, int address,
                                             std::span<const std::uint16_t> words);
  std::optional<ModbusException> find_changes(RegisterTable table, int address,
                                              std::span<const std::uint16_t> words,
                                              std::vector<Change>& changes);
  std::optional<ModbusException> apply(const std::vector<Change>& changes);
  void act(const DeviceRegister& place, double value);
  void start();
  void arm();

  RawValue raw_of(std::size_t index);
  std::optional<double> value_of(const DeviceRegister& place);
  double fault_bits() const;
  double capture_code(const DeviceRegister& place) const;
  double memory_of(const std::string& name, double otherwise) const;
  bool is(const std::optional<DeviceAction>& action, const DeviceRegister& place,
          double value) const;

  SimulatedAmplifier& amplifier_;
  const DeviceProfile& profile_;
  TwinBankOptions options_;
  std::vector<RawValue> memory_;  ///< of each register
  std::map<RegisterTable, std::vector<bool>> readable_;
  std::map<std::string, long> write_counts_;
  long persist_count_ = 0;
  std::chrono::steady_clock::time_point began_;
  std::int64_t paced_ = 0;  ///< ticks that the wall clock has brought
  double passed_ = 0;       ///< by requests, less than a tick [s]
};

}  // namespace gyrator
