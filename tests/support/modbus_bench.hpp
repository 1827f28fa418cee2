#pragma once

#include "gyrator/core/error.hpp"
#include "gyrator/modbus/modbus_link.hpp"
#include "gyrator/modbus/modbus_server.hpp"

#include <chrono>
#include <functional>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include <gtest/gtest.h>

#include "support/counting_bank.hpp"

namespace gyrator::modbus_tests {

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
    // Not run(): it ends with the Ctrl-C of a test in the same process.
    thread_ = std::thread([this] {
      while (!server_.poll(0.1)) {
      }
    });
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
