#pragma once

#include "gyrator/modbus/link_error.hpp"
#include "gyrator/modbus/register_value.hpp"

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace gyrator {

using Bytes = std::vector<std::uint8_t>;
using ByteSpan = std::span<const std::uint8_t>;

/// Function codes of the Modbus application protocol 1.1b3.
enum class ModbusFunction : std::uint8_t {
  read_coils = 1,
  read_discrete = 2,
  read_holding = 3,
  read_input = 4,
  write_coil = 5,
  write_register = 6,
  write_coils = 15,
  write_registers = 16,
  mask_write_register = 22,
  read_write_registers = 23
};

/// Set in the function code of an answer that is an exception.
constexpr std::uint8_t exception_flag = 0x80;

/// The specification's limits of one request.
constexpr int most_read_bits = 2000, most_written_bits = 1968;
constexpr int most_read_registers = 125, most_written_registers = 123,
              most_exchanged_registers = 121;
constexpr std::size_t longest_pdu = 253;  ///< bytes from the function code on
constexpr int register_count = 65536;     ///< of a table

/// The check sum of serial frames; its low byte is sent first.
///   polynomial x^16 + x^15 + x^2 + 1, bits reversed, from 0xFFFF                   (crc-1)
/// Source: Modbus over serial line 1.02, appendix B.
std::uint16_t compute_crc16(ByteSpan bytes);

/// Unit, what is said, check sum.
Bytes make_serial_frame(std::uint8_t unit, ByteSpan pdu);

/// Whether the last two bytes are the check sum of those before.
bool has_valid_crc(ByteSpan frame);

/// What stands before each message over TCP (MBAP header).
struct TcpHeader {
  std::uint16_t transaction = 0;
  std::uint16_t protocol = 0;  ///< 0: Modbus
  std::uint16_t length = 0;    ///< bytes that follow, the unit with them
  std::uint8_t unit = 0;
};
constexpr std::size_t tcp_header_bytes = 7;

Bytes make_tcp_frame(std::uint16_t transaction, std::uint8_t unit, ByteSpan pdu);
/// Of at least tcp_header_bytes bytes.
TcpHeader read_tcp_header(ByteSpan frame);

/// Bytes of the request that begins so, from the function code on; nothing while too few are known,
/// or where the function is not one of ModbusFunction.
std::optional<std::size_t> find_request_length(ByteSpan begin);

/// Big-endian, as all of Modbus.
std::uint16_t read_word(ByteSpan bytes, std::size_t at);
void append_word(Bytes& bytes, std::uint16_t word);
/// Eight to a byte, the first in the lowest bit.
void append_bits(Bytes& bytes, const std::vector<bool>& bits);
std::vector<bool> read_bit_field(ByteSpan bytes, std::size_t count);

/// A request, from the function code on.
Bytes make_read_request(RegisterTable table, int address, int count);
Bytes make_coil_request(int address, bool value);
Bytes make_coils_request(int address, const std::vector<bool>& values);
Bytes make_register_request(int address, std::uint16_t word);
Bytes make_registers_request(int address, std::span<const std::uint16_t> words);

/// What is wrong with an answer to one of these requests, both from the function code on; empty
/// for the right one and for an exception.
std::string find_answer_mistake(ByteSpan request, ByteSpan answer);
/// The exception that an answer is.
std::optional<ModbusException> find_exception(ByteSpan answer);

/// "01 03 00 10", for logs.
std::string format_hex(ByteSpan bytes);

}  // namespace gyrator
