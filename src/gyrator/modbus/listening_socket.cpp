#include "gyrator/modbus/listening_socket.hpp"

#include "gyrator/core/error.hpp"

#include <cerrno>
#include <memory>
#include <netdb.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <sys/socket.h>
#include <system_error>

#include <fmt/core.h>

namespace gyrator {
namespace {

struct FreeAddresses {
  void operator()(addrinfo* list) const { ::freeaddrinfo(list); }
};
using Addresses = std::unique_ptr<addrinfo, FreeAddresses>;

Addresses find_addresses(const std::string& host, std::uint16_t port, const std::string& place) {
  addrinfo hints{};
  hints.ai_family = AF_UNSPEC;
  hints.ai_socktype = SOCK_STREAM;
  hints.ai_flags = AI_PASSIVE | AI_NUMERICSERV;
  addrinfo* list = nullptr;
  const int failed = host.empty()
                         ? EAI_NONAME
                         : ::getaddrinfo(host.c_str(), std::to_string(port).c_str(), &hints, &list);
  if (failed != 0)
    throw Error(ErrorCode::bad_input, place,
                std::string("is no address of this machine: ") + ::gai_strerror(failed));
  return Addresses(list);
}

bool is_loopback(const addrinfo& address) {
  constexpr std::uint32_t loopback_net = 127;
  constexpr std::uint32_t net_shift = 24;
  if (address.ai_family == AF_INET) {
    // NOLINTNEXTLINE(cppcoreguidelines-pro-type-reinterpret-cast): the sockets' way of a variant
    const auto* ipv4 = reinterpret_cast<const sockaddr_in*>(address.ai_addr);
    return ntohl(ipv4->sin_addr.s_addr) >> net_shift == loopback_net;
  }
  if (address.ai_family != AF_INET6) return false;
  // NOLINTNEXTLINE(cppcoreguidelines-pro-type-reinterpret-cast)
  const auto* ipv6 = reinterpret_cast<const sockaddr_in6*>(address.ai_addr);
  return IN6_IS_ADDR_LOOPBACK(&ipv6->sin6_addr);
}

std::uint16_t port_of(int socket) {
  sockaddr_storage address{};
  socklen_t size = sizeof(address);
  // NOLINTNEXTLINE(cppcoreguidelines-pro-type-reinterpret-cast)
  ::getsockname(socket, reinterpret_cast<sockaddr*>(&address), &size);
  if (address.ss_family == AF_INET6) {
    // NOLINTNEXTLINE(cppcoreguidelines-pro-type-reinterpret-cast)
    return ntohs(reinterpret_cast<const sockaddr_in6*>(&address)->sin6_port);
  }
  // NOLINTNEXTLINE(cppcoreguidelines-pro-type-reinterpret-cast)
  return ntohs(reinterpret_cast<const sockaddr_in*>(&address)->sin_port);
}

void set_option(int socket, int level, int option) {
  const int on = 1;
  ::setsockopt(socket, level, option, &on, sizeof(on));
}

}  // namespace

ListeningSocket listen_for_tcp(const std::string& host, std::uint16_t port, bool loopback_only) {
  const std::string place = fmt::format("{}:{}", host, port);
  const Addresses addresses = find_addresses(host, port, place);
  const addrinfo& address = *addresses;
  if (loopback_only && !is_loopback(address))
    throw Error(ErrorCode::bad_input, place,
                "other machines reach this address, and Modbus knows no passwords: allowed: "
                "127.0.0.1, ::1, localhost");
  FileDescriptor socket(::socket(address.ai_family, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0));
  if (socket.is_open()) set_option(socket.get(), SOL_SOCKET, SO_REUSEADDR);
  if (!socket.is_open() || ::bind(socket.get(), address.ai_addr, address.ai_addrlen) != 0 ||
      ::listen(socket.get(), SOMAXCONN) != 0) {
    const ErrorCode code = errno == EADDRNOTAVAIL ? ErrorCode::bad_input : ErrorCode::device;
    throw Error(code, place, "cannot be listened at: " + std::generic_category().message(errno));
  }
  const std::uint16_t given = port_of(socket.get());
  return {std::move(socket), given};
}

std::optional<FileDescriptor> accept_client(int listener) {
  FileDescriptor client(::accept4(listener, nullptr, nullptr, SOCK_CLOEXEC | SOCK_NONBLOCK));
  if (!client.is_open()) return std::nullopt;
  set_option(client.get(), IPPROTO_TCP, TCP_NODELAY);
  return client;
}

}  // namespace gyrator
