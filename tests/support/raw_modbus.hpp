#pragma once

#include "gyrator/modbus/file_descriptor.hpp"
#include "gyrator/modbus/listening_socket.hpp"
#include "gyrator/modbus/modbus_frame.hpp"
#include "gyrator/modbus/serial_line.hpp"

#include <arpa/inet.h>
#include <atomic>
#include <cstdint>
#include <functional>
#include <netinet/in.h>
#include <poll.h>
#include <stdexcept>
#include <string>
#include <sys/socket.h>
#include <thread>
#include <utility>

namespace gyrator::modbus_tests {

/// A client that sends and takes bytes, whatever they mean.
class RawClient {
 public:
  explicit RawClient(std::uint16_t port) : descriptor_(::socket(AF_INET, SOCK_STREAM, 0)) {
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_port = htons(port);
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    if (::connect(descriptor_.get(), reinterpret_cast<sockaddr*>(&address), sizeof(address)) != 0)
      throw std::runtime_error("no connection");
  }
  explicit RawClient(const std::string& terminal)
      : descriptor_(open_serial_line({terminal, 115200})) {}

  void send(const Bytes& bytes) const {
    // A server that has hung up must not end the test by SIGPIPE.
    const auto sent = ::send(descriptor_.get(), bytes.data(), bytes.size(), MSG_NOSIGNAL);
    if (sent < 0 && errno == ENOTSOCK && ::write(descriptor_.get(), bytes.data(), bytes.size()) < 0)
      throw std::runtime_error("not written");
  }

  /// So many bytes, or fewer if no more come for a while.
  Bytes receive(std::size_t size, double patience = 2) const {
    Bytes received;
    while (received.size() < size) {
      pollfd watched{descriptor_.get(), POLLIN, 0};
      if (::poll(&watched, 1, static_cast<int>(1e3 * patience)) <= 0) break;
      std::uint8_t byte = 0;
      if (::read(descriptor_.get(), &byte, 1) != 1) break;
      received.push_back(byte);
    }
    return received;
  }
  /// Whether the other side has hung up.
  bool is_closed(double patience = 2) const {
    pollfd watched{descriptor_.get(), POLLIN, 0};
    if (::poll(&watched, 1, static_cast<int>(1e3 * patience)) <= 0) return false;
    std::uint8_t byte = 0;
    return ::recv(descriptor_.get(), &byte, 1, MSG_PEEK) <= 0;
  }

 private:
  FileDescriptor descriptor_;
};

/// A device over TCP that answers every frame with whatever bytes it is told to.
class FakeDevice {
 public:
  using Answer = std::function<Bytes(const Bytes& frame)>;

  explicit FakeDevice(Answer answer)
      : answer_(std::move(answer)), listener_(listen_for_tcp("127.0.0.1", 0, true)) {
    thread_ = std::thread([this] { run(); });
  }
  ~FakeDevice() {
    stopped_ = true;
    thread_.join();
  }
  FakeDevice(const FakeDevice&) = delete;
  FakeDevice& operator=(const FakeDevice&) = delete;

  std::uint16_t port() const { return listener_.port; }
  int requests() const { return requests_; }
  int connections() const { return connections_; }

 private:
  static constexpr int nap = 10;  // [ms]

  bool wait(int descriptor) const {
    while (!stopped_) {
      pollfd watched{descriptor, POLLIN, 0};
      if (::poll(&watched, 1, nap) > 0) return true;
    }
    return false;
  }
  void run() {
    while (wait(listener_.socket.get()))
      if (auto client = accept_client(listener_.socket.get())) {
        ++connections_;
        serve(client->get());
      }
  }
  /// Requests are small enough to come in one piece.
  void serve(int client) {
    while (wait(client)) {
      Bytes frame(300);
      const ssize_t size = ::recv(client, frame.data(), frame.size(), 0);
      if (size <= 0) return;
      frame.resize(static_cast<std::size_t>(size));
      ++requests_;
      const Bytes answer = answer_(frame);
      ::send(client, answer.data(), answer.size(), MSG_NOSIGNAL);
    }
  }

  Answer answer_;
  ListeningSocket listener_;
  std::atomic<bool> stopped_{false};
  std::atomic<int> requests_{0}, connections_{0};
  std::thread thread_;
};

}  // namespace gyrator::modbus_tests
