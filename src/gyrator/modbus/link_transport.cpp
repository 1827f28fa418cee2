#include "gyrator/modbus/link_transport.hpp"

#include "gyrator/core/error.hpp"
#include "gyrator/modbus/serial_line.hpp"

#include <algorithm>
#include <arpa/inet.h>
#include <array>
#include <cerrno>
#include <chrono>
#include <cmath>
#include <modbus/modbus.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/select.h>
#include <sys/socket.h>
#include <variant>

#include <fmt/core.h>

namespace gyrator {
namespace {

using Clock = std::chrono::steady_clock;

struct FreeContext {
  void operator()(modbus_t* context) const {
    ::modbus_close(context);
    ::modbus_free(context);
  }
};
using ContextHandle = std::unique_ptr<modbus_t, FreeContext>;

bool is_number_of_ipv4(const std::string& host) {
  in_addr ignored{};
  return ::inet_pton(AF_INET, host.c_str(), &ignored) == 1;
}

modbus_t* make_context(const TcpAddress& address) {
  // The other kind looks names up, and numbers too, which fails where only IPv6 is set up.
  if (is_number_of_ipv4(address.host)) return ::modbus_new_tcp(address.host.c_str(), address.port);
  return ::modbus_new_tcp_pi(address.host.c_str(), std::to_string(address.port).c_str());
}

modbus_t* make_context(const SerialAddress& address) {
  constexpr int data_bits = 8;
  const Parity parity = is_pseudo_terminal(address.device) ? Parity::none : address.parity;
  return ::modbus_new_rtu(address.device.c_str(), address.baud, static_cast<char>(parity),
                          data_bits, address.stop_bits);
}

struct SecondsAndMicroseconds {
  std::uint32_t seconds, microseconds;
};
SecondsAndMicroseconds split(double seconds) {
  const double whole = std::floor(seconds);
  // A time of zero would mean "for ever" or be refused.
  const double rest = std::max((seconds - whole) * 1e6, whole == 0 ? 1.0 : 0.0);
  return {static_cast<std::uint32_t>(whole), static_cast<std::uint32_t>(rest)};
}

/// Waits for an event on the descriptor; returns those that happened, 0 after the time.
short wait_for(int descriptor, short events, double seconds) {
  const auto end = Clock::now() + std::chrono::duration<double>(seconds);
  while (true) {
    const double left = std::chrono::duration<double>(end - Clock::now()).count();
    pollfd watched{descriptor, events, 0};
    const int found = ::poll(&watched, 1, static_cast<int>(std::ceil(std::max(left, 0.0) * 1e3)));
    if (found > 0) return watched.revents;
    // A signal, such as Ctrl-C, does not cut a wait for an answer short.
    if (found == 0 || errno != EINTR) return 0;
  }
}

std::string reason(int error) {
  return ::modbus_strerror(error);
}

}  // namespace

struct LinkTransport::Context {
  ContextHandle handle;
  bool serial = false;
  bool open = false;
  double send_timeout = 0;

  modbus_t* get() const { return handle.get(); }
  int descriptor() const { return ::modbus_get_socket(handle.get()); }
};

LinkTransport::LinkTransport(const LinkAddress& address, int unit, double response_timeout,
                             double byte_timeout)
    : context_(std::make_unique<Context>()) {
  Context& context = *context_;
  context.serial = std::holds_alternative<SerialAddress>(address);
  context.send_timeout = response_timeout;
  context.handle.reset(std::visit([](const auto& which) { return make_context(which); }, address));
  if (!context.handle)
    throw Error(ErrorCode::bad_input, describe(address), "is no address: " + reason(errno));
  // Before anything else: libmodbus ends the process over a serial request without a unit.
  if (::modbus_set_slave(context.get(), unit) != 0)
    throw Error(ErrorCode::bad_input, describe(address), fmt::format("unit {}: no such one", unit));
  const auto response = split(response_timeout);
  const auto byte = split(byte_timeout);
  ::modbus_set_response_timeout(context.get(), response.seconds, response.microseconds);
  ::modbus_set_byte_timeout(context.get(), byte.seconds, byte.microseconds);
  ::modbus_set_error_recovery(context.get(), MODBUS_ERROR_RECOVERY_NONE);
}

LinkTransport::~LinkTransport() = default;

bool LinkTransport::is_open() const {
  return context_->open;
}

std::string LinkTransport::open() {
  close();
  errno = 0;
  if (::modbus_connect(context_->get()) != 0)
    return errno == 0 || errno == EINPROGRESS ? "no answer" : reason(errno);
  context_->open = true;
  if (context_->descriptor() < FD_SETSIZE) return "";
  close();  // libmodbus waits with select()
  return "too many open files";
}

void LinkTransport::close() {
  if (context_->open) ::modbus_close(context_->get());
  context_->open = false;
}

LinkTransport::Line LinkTransport::look() {
  const short events = wait_for(context_->descriptor(), POLLIN, 0);
  if (events == 0) return Line::quiet;
  if ((events & POLLIN) == 0) return Line::broken;
  if (context_->serial) return (events & POLLHUP) != 0 ? Line::broken : Line::has_bytes;
  char first = 0;
  const ssize_t size = ::recv(context_->descriptor(), &first, 1, MSG_PEEK | MSG_DONTWAIT);
  return size > 0 ? Line::has_bytes : Line::broken;
}

void LinkTransport::drop_input(double silence) {
  constexpr double longest = 10;  // times the silence
  const auto end = Clock::now() + std::chrono::duration<double>(longest * silence);
  std::array<char, 1024> dropped{};
  while (wait_for(context_->descriptor(), POLLIN, silence) == POLLIN && Clock::now() < end)
    if (::read(context_->descriptor(), dropped.data(), dropped.size()) <= 0) return;
}

std::string LinkTransport::send(ByteSpan frame) {
  if (context_->serial) {
    const int sent =
        ::modbus_send_raw_request(context_->get(), frame.data(), static_cast<int>(frame.size()));
    return sent < 0 ? reason(errno) : "";
  }
  // libmodbus gives every raw request the transaction number 0, and late answers could not be told.
  while (!frame.empty()) {
    const ssize_t sent =
        ::send(context_->descriptor(), frame.data(), frame.size(), MSG_NOSIGNAL | MSG_DONTWAIT);
    if (sent > 0) {
      frame = frame.subspan(static_cast<std::size_t>(sent));
    } else if (errno == EAGAIN || errno == EWOULDBLOCK) {
      if (wait_for(context_->descriptor(), POLLOUT, context_->send_timeout) == 0)
        return reason(ETIMEDOUT);
    } else if (errno != EINTR) {
      return reason(errno);
    }
  }
  return "";
}

LinkTransport::Received LinkTransport::receive(double seconds) {
  using Kind = Received::Kind;
  if (wait_for(context_->descriptor(), POLLIN, seconds) == 0) return {};
  std::array<std::uint8_t, MODBUS_MAX_ADU_LENGTH> frame{};
  const int size = ::modbus_receive_confirmation(context_->get(), frame.data());
  const int error = errno;
  if (size > 0) return {Kind::frame, {frame.begin(), frame.begin() + size}, ""};
  // libmodbus drops serial frames of other units without a word.
  if (size == 0) return {Kind::nonsense, {}, "an answer of another unit"};
  if (error == ETIMEDOUT) return {Kind::part, {}, ""};
  const bool nonsense = error >= MODBUS_ENOBASE;
  return {nonsense ? Kind::nonsense : Kind::broken, {}, reason(error)};
}

}  // namespace gyrator
