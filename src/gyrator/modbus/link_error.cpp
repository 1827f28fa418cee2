#include "gyrator/modbus/link_error.hpp"

#include <string_view>
#include <utility>

#include <fmt/core.h>

namespace gyrator {
namespace {

std::string_view name_of(ModbusException exception) {
  switch (exception) {
    case ModbusException::illegal_function:
      return "illegal function";
    case ModbusException::illegal_data_address:
      return "illegal data address";
    case ModbusException::illegal_data_value:
      return "illegal data value";
    case ModbusException::device_failure:
      return "device failure";
    case ModbusException::acknowledge:
      return "acknowledge";
    case ModbusException::device_busy:
      return "device busy";
    case ModbusException::negative_acknowledge:
      return "negative acknowledge";
    case ModbusException::memory_parity:
      return "memory parity error";
    case ModbusException::gateway_path_unavailable:
      return "gateway path unavailable";
    case ModbusException::gateway_target_failed:
      return "gateway target failed to respond";
  }
  return "unknown exception";
}

}  // namespace

std::string describe(ModbusException exception) {
  return fmt::format("{} ({})", name_of(exception), static_cast<int>(exception));
}

LinkError::LinkError(LinkFault fault, std::string place, std::string message,
                     std::optional<ModbusException> exception)
    : Error(ErrorCode::device, std::move(place), std::move(message)),
      fault_(fault),
      exception_(exception) {}

}  // namespace gyrator
