#pragma once

#include "gyrator/core/error.hpp"
#include "gyrator/modbus/modbus_link.hpp"
#include "gyrator/modbus/modbus_server.hpp"

#include <atomic>
#include <chrono>
#include <filesystem>
#include <functional>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include <gtest/gtest.h>

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

/// A server in a thread of its own, on a free port of the loopback or on a pseudo-terminal. What
/// its hooks do can be changed while it runs.
class ServedBank {
 public:
  enum class Wire { tcp, serial };

  explicit ServedBank(Wire wire = Wire::tcp, ServerOptions options = {})
      : server_(bank, options, hooks()) {
    if (wire == Wire::tcp) {
      const std::uint16_t port = server_.listen("127.0.0.1", 0);
      address_ = TcpAddress{"127.0.0.1", port};
    } else {
      address_ = SerialAddress{server_.open_pseudo_terminal({}), 115200};
    }
    thread_ = std::thread([this] { server_.run(); });
  }
  ~ServedBank() {
    server_.stop();
    thread_.join();
  }
  ServedBank(const ServedBank&) = delete;
  ServedBank& operator=(const ServedBank&) = delete;

  const LinkAddress& address() const { return address_; }
  std::uint16_t port() const { return std::get<TcpAddress>(address_).port; }
  std::string terminal() const { return std::get<SerialAddress>(address_).device; }

  /// What becomes of the next answers, one after another; after them, all are sent.
  void plan(std::vector<AnswerPlan> plans) {
    const std::lock_guard lock(mutex_);
    plans_ = std::move(plans);
  }
  /// The next so many requests are refused.
  void refuse(ModbusException exception, int times) {
    const std::lock_guard lock(mutex_);
    refusals_.assign(static_cast<std::size_t>(times), exception);
  }

  CountingBank bank;

 private:
  template <class T>
  std::optional<T> next(std::vector<T>& list) {
    const std::lock_guard lock(mutex_);
    if (list.empty()) return std::nullopt;
    T first = list.front();
    list.erase(list.begin());
    return first;
  }
  ServerHooks hooks() {
    return {[this](std::span<const std::uint8_t>) { return next(refusals_); },
            [this](const ServerExchange&) { return next(plans_).value_or(AnswerPlan{}); }};
  }

  std::mutex mutex_;
  std::vector<AnswerPlan> plans_;
  std::vector<ModbusException> refusals_;
  ModbusServer server_;
  LinkAddress address_;
  std::thread thread_;
};

/// Short waits, so that tests of what never comes are quick.
inline LinkOptions quick_options(double response_timeout = 0.15) {
  LinkOptions options;
  options.response_timeout = response_timeout;
  options.byte_timeout = 0.05;
  options.backoff = 0.001;
  return options;
}

/// The fault that the work ends with; the test fails where it does not.
inline LinkError fault_of(const std::function<void()>& work) {
  try {
    work();
  } catch (const LinkError& error) {
    return error;
  }
  ADD_FAILURE() << "no LinkError";
  return {LinkFault::refused, "", "none"};
}

}  // namespace gyrator::modbus_tests
