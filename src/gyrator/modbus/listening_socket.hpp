#pragma once

#include "gyrator/modbus/file_descriptor.hpp"

#include <cstdint>
#include <optional>
#include <string>

namespace gyrator {

struct ListeningSocket {
  FileDescriptor socket;   ///< accepts without waiting
  std::uint16_t port = 0;  ///< the one that was free, if 0 was asked for
};

/// Throws bad_input for an address of another machine, or, if loopback_only, for one that other
/// machines reach; device for a port that is in use or not allowed.
ListeningSocket listen_for_tcp(const std::string& host, std::uint16_t port, bool loopback_only);

/// The next client; none if no one waits.
std::optional<FileDescriptor> accept_client(int listener);

}  // namespace gyrator
