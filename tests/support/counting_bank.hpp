#pragma once

#include "gyrator/modbus/register_bank.hpp"

#include <algorithm>
#include <atomic>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

namespace gyrator::modbus_tests {

/// A device of 200 addresses in each table that counts what is done to it.
class CountingBank : public RegisterBank {
 public:
  static constexpr int size = 200;

  Answer<std::vector<bool>> read_bits(RegisterTable table, int address, int count) override {
    ++reads;
    if (address + count > size) return ModbusException::illegal_data_address;
    const auto& bits = table == RegisterTable::coil ? coils : discretes;
    return std::vector<bool>(bits.begin() + address, bits.begin() + address + count);
  }
  Answer<std::vector<std::uint16_t>> read_registers(RegisterTable table, int address,
                                                    int count) override {
    ++reads;
    if (address + count > size) return ModbusException::illegal_data_address;
    const auto& words = table == RegisterTable::holding ? holdings : inputs;
    return std::vector<std::uint16_t>(words.begin() + address, words.begin() + address + count);
  }
  std::optional<ModbusException> write_coils(int address,
                                             const std::vector<bool>& values) override {
    if (address + static_cast<int>(values.size()) > size)
      return ModbusException::illegal_data_address;
    ++writes;
    std::copy(values.begin(), values.end(), coils.begin() + address);
    return std::nullopt;
  }
  std::optional<ModbusException> write_registers(int address,
                                                 std::span<const std::uint16_t> words) override {
    if (address + static_cast<int>(words.size()) > size)
      return ModbusException::illegal_data_address;
    ++writes;
    std::copy(words.begin(), words.end(), holdings.begin() + address);
    return std::nullopt;
  }

  std::atomic<int> reads{0}, writes{0};
  std::vector<bool> coils = std::vector<bool>(size), discretes = alternating();
  std::vector<std::uint16_t> holdings = std::vector<std::uint16_t>(size), inputs = numbered();

 private:
  static std::vector<bool> alternating() {
    std::vector<bool> bits(size);
    for (std::size_t i = 0; i < size; ++i) bits[i] = i % 3 == 0;
    return bits;
  }
  static std::vector<std::uint16_t> numbered() {
    std::vector<std::uint16_t> words(size);
    for (std::size_t i = 0; i < size; ++i) words[i] = static_cast<std::uint16_t>(7 * i + 1);
    return words;
  }
};

}  // namespace gyrator::modbus_tests
