#include "gyrator/modbus/modbus_frame.hpp"

#include <algorithm>

#include <fmt/core.h>

namespace gyrator {
namespace {

constexpr std::size_t short_request = 5;  // function, address, count or value

Bytes make_request(ModbusFunction function, int address, int argument) {
  Bytes request{static_cast<std::uint8_t>(function)};
  append_word(request, static_cast<std::uint16_t>(address));
  append_word(request, static_cast<std::uint16_t>(argument));
  return request;
}

bool is_read(std::uint8_t function) {
  return function >= 1 && function <= 4;
}

/// Data bytes that a read request asks for.
std::size_t data_bytes(ByteSpan request) {
  const std::size_t count = read_word(request, 3);
  const bool bits = request[0] <= static_cast<std::uint8_t>(ModbusFunction::read_discrete);
  return bits ? (count + 7) / 8 : 2 * count;
}

}  // namespace

std::uint16_t compute_crc16(ByteSpan bytes) {
  constexpr std::uint16_t reversed_polynomial = 0xA001;
  std::uint16_t crc = 0xFFFF;
  for (const std::uint8_t byte : bytes) {
    crc ^= byte;
    for (int bit = 0; bit < 8; ++bit)
      crc = static_cast<std::uint16_t>(crc & 1U ? crc >> 1U ^ reversed_polynomial : crc >> 1U);
  }
  return crc;
}

Bytes make_serial_frame(std::uint8_t unit, ByteSpan pdu) {
  Bytes frame{unit};
  frame.insert(frame.end(), pdu.begin(), pdu.end());
  const std::uint16_t crc = compute_crc16(frame);
  frame.push_back(static_cast<std::uint8_t>(crc & 0xFFU));
  frame.push_back(static_cast<std::uint8_t>(crc >> 8U));
  return frame;
}

bool has_valid_crc(ByteSpan frame) {
  if (frame.size() < 3) return false;
  const std::uint16_t crc = compute_crc16(frame.first(frame.size() - 2));
  return frame[frame.size() - 2] == (crc & 0xFFU) && frame[frame.size() - 1] == crc >> 8U;
}

Bytes make_tcp_frame(std::uint16_t transaction, std::uint8_t unit, ByteSpan pdu) {
  Bytes frame;
  append_word(frame, transaction);
  append_word(frame, 0);
  append_word(frame, static_cast<std::uint16_t>(pdu.size() + 1));
  frame.push_back(unit);
  frame.insert(frame.end(), pdu.begin(), pdu.end());
  return frame;
}

TcpHeader read_tcp_header(ByteSpan frame) {
  return {read_word(frame, 0), read_word(frame, 2), read_word(frame, 4), frame[6]};
}

std::optional<std::size_t> find_request_length(ByteSpan begin) {
  constexpr std::size_t many_count_at = 5;
  constexpr std::size_t mask_bytes = 7;
  constexpr std::size_t exchange_count_at = 9;
  if (begin.empty()) return std::nullopt;
  const auto counted_at = [begin](std::size_t at) -> std::optional<std::size_t> {
    if (begin.size() <= at) return std::nullopt;
    return at + 1 + begin[at];
  };
  switch (static_cast<ModbusFunction>(begin[0])) {
    case ModbusFunction::read_coils:
    case ModbusFunction::read_discrete:
    case ModbusFunction::read_holding:
    case ModbusFunction::read_input:
    case ModbusFunction::write_coil:
    case ModbusFunction::write_register:
      return short_request;
    case ModbusFunction::write_coils:
    case ModbusFunction::write_registers:
      return counted_at(many_count_at);
    case ModbusFunction::mask_write_register:
      return mask_bytes;
    case ModbusFunction::read_write_registers:
      return counted_at(exchange_count_at);
  }
  return std::nullopt;
}

std::uint16_t read_word(ByteSpan bytes, std::size_t at) {
  return static_cast<std::uint16_t>(bytes[at] << 8U | bytes[at + 1]);
}

void append_word(Bytes& bytes, std::uint16_t word) {
  bytes.push_back(static_cast<std::uint8_t>(word >> 8U));
  bytes.push_back(static_cast<std::uint8_t>(word & 0xFFU));
}

void append_bits(Bytes& bytes, const std::vector<bool>& bits) {
  for (std::size_t i = 0; i < bits.size(); ++i) {
    if (i % 8 == 0) bytes.push_back(0);
    if (bits[i]) bytes.back() = static_cast<std::uint8_t>(bytes.back() | 1U << i % 8);
  }
}

std::vector<bool> read_bit_field(ByteSpan bytes, std::size_t count) {
  std::vector<bool> bits(count);
  for (std::size_t i = 0; i < count; ++i) bits[i] = (bytes[i / 8] >> i % 8 & 1U) != 0;
  return bits;
}

Bytes make_read_request(RegisterTable table, int address, int count) {
  const auto function = [table] {
    switch (table) {
      case RegisterTable::coil:
        return ModbusFunction::read_coils;
      case RegisterTable::discrete:
        return ModbusFunction::read_discrete;
      case RegisterTable::input:
        return ModbusFunction::read_input;
      case RegisterTable::holding:
        break;
    }
    return ModbusFunction::read_holding;
  }();
  return make_request(function, address, count);
}

Bytes make_coil_request(int address, bool value) {
  constexpr int on = 0xFF00;
  return make_request(ModbusFunction::write_coil, address, value ? on : 0);
}

Bytes make_coils_request(int address, const std::vector<bool>& values) {
  Bytes request =
      make_request(ModbusFunction::write_coils, address, static_cast<int>(values.size()));
  request.push_back(static_cast<std::uint8_t>((values.size() + 7) / 8));
  append_bits(request, values);
  return request;
}

Bytes make_register_request(int address, std::uint16_t word) {
  return make_request(ModbusFunction::write_register, address, word);
}

Bytes make_registers_request(int address, std::span<const std::uint16_t> words) {
  Bytes request =
      make_request(ModbusFunction::write_registers, address, static_cast<int>(words.size()));
  request.push_back(static_cast<std::uint8_t>(2 * words.size()));
  for (const std::uint16_t word : words) append_word(request, word);
  return request;
}

std::optional<ModbusException> find_exception(ByteSpan answer) {
  if (answer.size() != 2 || (answer[0] & exception_flag) == 0) return std::nullopt;
  return static_cast<ModbusException>(answer[1]);
}

std::string find_answer_mistake(ByteSpan request, ByteSpan answer) {
  const std::uint8_t function = request[0];
  if (answer.empty()) return "an empty answer";
  if ((answer[0] & ~exception_flag) != function)
    return fmt::format("an answer to function {}, not to {}", answer[0] & ~exception_flag,
                       function);
  if (answer[0] != function)
    return answer.size() == 2 ? "" : fmt::format("an exception of {} bytes", answer.size());
  if (is_read(function)) {
    const std::size_t wanted = data_bytes(request);
    if (answer.size() == wanted + 2 && answer[1] == wanted) return "";
    return fmt::format("{} bytes of data instead of {}", answer.size() < 2 ? 0 : answer.size() - 2,
                       wanted);
  }
  // All writes echo address and value or count.
  if (answer.size() == short_request && std::equal(answer.begin(), answer.end(), request.begin()))
    return "";
  return fmt::format("the echo {} of {}", format_hex(answer),
                     format_hex(request.first(short_request)));
}

std::string format_hex(ByteSpan bytes) {
  std::string text;
  for (const std::uint8_t byte : bytes)
    text += fmt::format("{}{:02X}", text.empty() ? "" : " ", byte);
  return text;
}

}  // namespace gyrator
