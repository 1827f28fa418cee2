#pragma once

#include "gyrator/modbus/link_error.hpp"
#include "gyrator/modbus/register_value.hpp"

#include <cstdint>
#include <optional>
#include <span>
#include <variant>
#include <vector>

namespace gyrator {

/// What a Modbus server serves: the device's side of its four tables.
///
/// Addresses are from 0, and address + count is at most 65536; counts are those of the Modbus
/// specification, checked before. A write is done whole or not at all. The functions must not throw
/// but what ends the server.
class RegisterBank {
 public:
  template <class T>
  using Answer = std::variant<T, ModbusException>;

  RegisterBank() = default;
  RegisterBank(const RegisterBank&) = delete;
  RegisterBank& operator=(const RegisterBank&) = delete;
  RegisterBank(RegisterBank&&) = delete;
  RegisterBank& operator=(RegisterBank&&) = delete;
  virtual ~RegisterBank() = default;

  /// Of coils or discrete inputs; `count` of them.
  virtual Answer<std::vector<bool>> read_bits(RegisterTable table, int address, int count) = 0;
  /// Of input or holding registers; `count` of them.
  virtual Answer<std::vector<std::uint16_t>> read_registers(RegisterTable table, int address,
                                                            int count) = 0;
  /// Nothing where it was done.
  virtual std::optional<ModbusException> write_coils(int address,
                                                     const std::vector<bool>& values) = 0;
  virtual std::optional<ModbusException> write_registers(int address,
                                                         std::span<const std::uint16_t> words) = 0;
};

/// The answer to a request, both from the function code on, without unit and check sum (a protocol
/// data unit): functions 1-6, 15, 16, 22 (mask write) and 23 (write and read registers). Illegal
/// requests are answered by an exception and do not reach the bank; nothing is answered to fewer
/// than one byte or more than 253, or to a function code of 0 or above 127.
std::vector<std::uint8_t> answer_request(std::span<const std::uint8_t> request, RegisterBank& bank);

/// The answer that refuses a request.
std::vector<std::uint8_t> make_exception_answer(std::uint8_t function, ModbusException exception);

}  // namespace gyrator
