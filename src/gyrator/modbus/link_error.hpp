#pragma once

#include "gyrator/core/error.hpp"

#include <cstdint>
#include <optional>
#include <string>

namespace gyrator {

/// What a Modbus device answers instead of data (Modbus application protocol 1.1b3, section 7).
enum class ModbusException : std::uint8_t {
  illegal_function = 1,
  illegal_data_address = 2,
  illegal_data_value = 3,
  device_failure = 4,
  acknowledge = 5,
  device_busy = 6,
  negative_acknowledge = 7,
  memory_parity = 8,
  gateway_path_unavailable = 10,
  gateway_target_failed = 11
};

/// "illegal data address (2)"; "unknown exception (42)" for a code of no name.
std::string describe(ModbusException exception);

enum class LinkFault {
  refused,   ///< no connection: nothing was sent
  timeout,   ///< no whole answer in time
  lost,      ///< the connection broke
  garbled,   ///< what came is no answer to what was asked
  exception  ///< the device answered with an exception
};

/// A request over Modbus that failed; an Error of code device.
///
/// After `timeout`, `lost` and `garbled` nobody knows whether a write has arrived: it is never sent
/// again by itself, so read back. Nor does an `exception` other than illegal_* and device_busy
/// promise that nothing was written.
class LinkError : public Error {
 public:
  LinkError(LinkFault fault, std::string place, std::string message,
            std::optional<ModbusException> exception = {});

  LinkFault fault() const { return fault_; }
  /// Of fault `exception` only.
  std::optional<ModbusException> exception() const { return exception_; }

 private:
  LinkFault fault_;
  std::optional<ModbusException> exception_;
};

}  // namespace gyrator
