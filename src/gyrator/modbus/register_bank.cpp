#include "gyrator/modbus/register_bank.hpp"

#include "gyrator/modbus/modbus_frame.hpp"

namespace gyrator {
namespace {

using Refusal = ModbusException;
using Request = std::span<const std::uint8_t>;

Bytes refuse(Request request, Refusal exception) {
  return make_exception_answer(request[0], exception);
}

/// Address and count of most requests, checked as the specification says: first the count, then
/// the range.
struct Range {
  int address = 0, count = 0;
  std::optional<Refusal> refusal;
};

Range read_range(Request request, std::size_t at, int most) {
  Range range{read_word(request, at), read_word(request, at + 2), {}};
  if (range.count < 1 || range.count > most)
    range.refusal = Refusal::illegal_data_value;
  else if (range.address + range.count > register_count)
    range.refusal = Refusal::illegal_data_address;
  return range;
}

std::vector<std::uint16_t> read_words(Request bytes) {
  std::vector<std::uint16_t> words;
  for (std::size_t i = 0; i + 1 < bytes.size(); i += 2) words.push_back(read_word(bytes, i));
  return words;
}

Bytes read_answer(Request request, const std::vector<std::uint16_t>& words) {
  Bytes answer{request[0], static_cast<std::uint8_t>(2 * words.size())};
  for (const std::uint16_t word : words) append_word(answer, word);
  return answer;
}

/// The echo of a write that was done.
Bytes write_answer(Request request, const std::optional<Refusal>& refusal, std::size_t echoed = 5) {
  if (refusal) return refuse(request, *refusal);
  const Request echo = request.first(echoed);
  return {echo.begin(), echo.end()};
}

Bytes read_bits(Request request, RegisterBank& bank, RegisterTable table) {
  const Range range = read_range(request, 1, most_read_bits);
  if (range.refusal) return refuse(request, *range.refusal);
  const auto found = bank.read_bits(table, range.address, range.count);
  if (const auto* refusal = std::get_if<Refusal>(&found)) return refuse(request, *refusal);
  Bytes data;
  append_bits(data, std::get<std::vector<bool>>(found));
  Bytes answer{request[0], static_cast<std::uint8_t>(data.size())};
  answer.insert(answer.end(), data.begin(), data.end());
  return answer;
}

Bytes read_registers(Request request, RegisterBank& bank, RegisterTable table) {
  const Range range = read_range(request, 1, most_read_registers);
  if (range.refusal) return refuse(request, *range.refusal);
  const auto found = bank.read_registers(table, range.address, range.count);
  if (const auto* refusal = std::get_if<Refusal>(&found)) return refuse(request, *refusal);
  return read_answer(request, std::get<std::vector<std::uint16_t>>(found));
}

Bytes write_coil(Request request, RegisterBank& bank) {
  constexpr std::uint16_t on = 0xFF00;
  const std::uint16_t value = read_word(request, 3);
  if (value != 0 && value != on) return refuse(request, Refusal::illegal_data_value);
  return write_answer(request, bank.write_coils(read_word(request, 1), {value == on}));
}

Bytes write_register(Request request, RegisterBank& bank) {
  const std::vector<std::uint16_t> word{read_word(request, 3)};
  return write_answer(request, bank.write_registers(read_word(request, 1), word));
}

Bytes write_coils(Request request, RegisterBank& bank) {
  const Range range = read_range(request, 1, most_written_bits);
  if (range.refusal) return refuse(request, *range.refusal);
  if (request[5] != (range.count + 7) / 8) return refuse(request, Refusal::illegal_data_value);
  const auto bits = read_bit_field(request.subspan(6), static_cast<std::size_t>(range.count));
  return write_answer(request, bank.write_coils(range.address, bits));
}

Bytes write_registers(Request request, RegisterBank& bank) {
  const Range range = read_range(request, 1, most_written_registers);
  if (range.refusal) return refuse(request, *range.refusal);
  if (request[5] != 2 * range.count) return refuse(request, Refusal::illegal_data_value);
  const auto words = read_words(request.subspan(6));
  return write_answer(request, bank.write_registers(range.address, words));
}

/// The register becomes (register and and_mask) or (or_mask and not and_mask).
Bytes mask_write_register(Request request, RegisterBank& bank) {
  const int address = read_word(request, 1);
  const unsigned and_mask = read_word(request, 3);
  const unsigned or_mask = read_word(request, 5);
  const auto found = bank.read_registers(RegisterTable::holding, address, 1);
  if (const auto* refusal = std::get_if<Refusal>(&found)) return refuse(request, *refusal);
  const unsigned before = std::get<std::vector<std::uint16_t>>(found).front();
  const std::vector<std::uint16_t> word{
      static_cast<std::uint16_t>((before & and_mask) | (or_mask & ~and_mask))};
  return write_answer(request, bank.write_registers(address, word), request.size());
}

/// Writes, then reads.
Bytes read_write_registers(Request request, RegisterBank& bank) {
  const Range read = read_range(request, 1, most_read_registers);
  const Range written = read_range(request, 5, most_exchanged_registers);
  for (const auto& refusal : {read.refusal, written.refusal})
    if (refusal) return refuse(request, *refusal);
  if (request[9] != 2 * written.count) return refuse(request, Refusal::illegal_data_value);
  const auto words = read_words(request.subspan(10));
  if (const auto refusal = bank.write_registers(written.address, words))
    return refuse(request, *refusal);
  const auto found = bank.read_registers(RegisterTable::holding, read.address, read.count);
  if (const auto* refusal = std::get_if<Refusal>(&found)) return refuse(request, *refusal);
  return read_answer(request, std::get<std::vector<std::uint16_t>>(found));
}

Bytes perform(Request request, RegisterBank& bank) {
  switch (static_cast<ModbusFunction>(request[0])) {
    case ModbusFunction::read_coils:
      return read_bits(request, bank, RegisterTable::coil);
    case ModbusFunction::read_discrete:
      return read_bits(request, bank, RegisterTable::discrete);
    case ModbusFunction::read_holding:
      return read_registers(request, bank, RegisterTable::holding);
    case ModbusFunction::read_input:
      return read_registers(request, bank, RegisterTable::input);
    case ModbusFunction::write_coil:
      return write_coil(request, bank);
    case ModbusFunction::write_register:
      return write_register(request, bank);
    case ModbusFunction::write_coils:
      return write_coils(request, bank);
    case ModbusFunction::write_registers:
      return write_registers(request, bank);
    case ModbusFunction::mask_write_register:
      return mask_write_register(request, bank);
    case ModbusFunction::read_write_registers:
      return read_write_registers(request, bank);
  }
  return refuse(request, Refusal::illegal_function);
}

bool is_known(std::uint8_t function) {
  constexpr std::uint8_t last_of_short = 6;
  return (function >= 1 && function <= last_of_short) ||
         function == static_cast<std::uint8_t>(ModbusFunction::write_coils) ||
         function == static_cast<std::uint8_t>(ModbusFunction::write_registers) ||
         function == static_cast<std::uint8_t>(ModbusFunction::mask_write_register) ||
         function == static_cast<std::uint8_t>(ModbusFunction::read_write_registers);
}

}  // namespace

std::vector<std::uint8_t> make_exception_answer(std::uint8_t function, ModbusException exception) {
  return {static_cast<std::uint8_t>(function | exception_flag),
          static_cast<std::uint8_t>(exception)};
}

std::vector<std::uint8_t> answer_request(Request request, RegisterBank& bank) {
  if (request.empty() || request.size() > longest_pdu || request[0] == 0 ||
      (request[0] & exception_flag) != 0)
    return {};
  if (!is_known(request[0])) return refuse(request, Refusal::illegal_function);
  // From here on every byte that is looked at is there.
  if (find_request_length(request) != request.size())
    return refuse(request, Refusal::illegal_data_value);
  return perform(request, bank);
}

}  // namespace gyrator
