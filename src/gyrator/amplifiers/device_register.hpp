#pragma once

#include "gyrator/core/quantity.hpp"
#include "gyrator/modbus/register_value.hpp"

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace gyrator {

/// Some bits of a word, counted from the least significant one.
struct BitField {
  int first = 0;
  int count = 1;
};

/// A named value of a device: where it is, how it is written there, and what it may be.
///   value = (raw scale + offset) factor                                    (register-1)
/// raw is what the words hold, `factor` the register's unit in SI. Limits, step and values are in
/// SI units; a register with codes has the code as its value.
struct DeviceRegister {
  std::string name, group, caveat;
  std::string unit;                    ///< as the profile writes it: "mA"
  std::string symbol;                  ///< of the SI unit: "A"; empty for a pure number
  std::optional<Dimension> dimension;  ///< none for a pure number
  RegisterTable table = RegisterTable::holding;
  int address = 0;  ///< of the first word, from 0 as on the wire
  RegisterType type = RegisterType::u16;
  WordOrder order = WordOrder::abcd;
  std::optional<BitField> bits;
  double scale = 1, offset = 0, factor = 1;
  std::optional<double> low, high;  ///< what may be written, both inclusive [SI]
  std::optional<double> step;       ///< of what may be written, from `low` or 0 [SI]
  std::optional<double> safe;       ///< with the drive off [SI]
  std::optional<RawValue> not_implemented;
  std::vector<std::pair<std::string, std::int64_t>> codes;
  bool readable = true, writable = false;
  bool is_setting = false;  ///< kept by a backup and put back by a restore
  bool persistent = false;  ///< outlasts a power cycle, and wears with each write
  std::string write_cost;   ///< of a persistent one, in words
  double settle = 0;        ///< from a write until it can be read back [s]

  int words() const { return words_of(type); }
  /// "holding 0x0010 (40017)"
  std::string describe_place() const { return describe_address(table, address); }
};

/// Whether any of its words is among the `count` addresses of a table from `address` on.
bool overlaps(const DeviceRegister& place, RegisterTable table, int address, int count);

/// The value [SI]; none where the device says that it has none: the sentinel, or a float that is no
/// number.
std::optional<double> to_physical(const DeviceRegister& place, const RawValue& raw);

/// What to write for a value [SI]: the nearest that the register can hold, on its step. Reading it
/// gives the value again, exactly for integers up to 2^53 and for floats without scale, else to
/// the rounding of a double. Throws bad_input, with the register's name as place, for what is not
/// finite, below or above its limits or what the type holds, and for a code it does not have.
RawValue to_raw(const DeviceRegister& place, double value);

/// The nearest value [SI] that may be written: to_physical(to_raw(value)) with the value moved into
/// the limits first.
double find_nearest_value(const DeviceRegister& place, double value);

/// The largest and the smallest value [SI] that may be written, by limits and by type.
struct ValueRange {
  double low = 0, high = 0;
};
ValueRange range_of(const DeviceRegister& place);

/// The value in words as they are sent, and back. A coil is one word of 0 or 1; a bit field
/// changes only its bits of `words`, what stands there now.
RawValue take_raw(const DeviceRegister& place, std::span<const std::uint16_t> words);
std::vector<std::uint16_t> put_raw(const DeviceRegister& place, const RawValue& raw,
                                   std::span<const std::uint16_t> words = {});

std::optional<std::int64_t> find_code(const DeviceRegister& place, std::string_view name);
std::optional<std::string> find_code_name(const DeviceRegister& place, double value);

/// "0.5 A" in the profile's unit, or a code's name; for tables and messages.
std::string describe_value(const DeviceRegister& place, double value);

/// A value that a person gave for a register: "0.5A", a number in the register's unit, a code's
/// name; "on" and "off" for a bit. Throws bad_input without a place.
double parse_register_value(const DeviceRegister& place, std::string_view text);

}  // namespace gyrator
