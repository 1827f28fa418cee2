#pragma once

#include "gyrator/modbus/link_address.hpp"
#include "gyrator/modbus/link_error.hpp"
#include "gyrator/modbus/register_value.hpp"

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>
#include <string>
#include <vector>

namespace gyrator {

/// How a device wants to be talked to.
struct LinkOptions {
  int unit = 1;                        ///< 1 … 247; over TCP also 0 and 255
  double response_timeout = 0.5;       ///< until an answer begins [s]
  double byte_timeout = 0.1;           ///< between bytes of an answer [s]
  double gap = 0;                      ///< of silence before each request, at least [s]
  int read_retries = 3;                ///< after a read's first try failed; writes have none
  double backoff = 0.02;               ///< before the first retry [s]; doubles with each
  int max_read = 125;                  ///< registers in a request; longer reads are split
  int max_write = 123;                 ///< registers in a request; longer writes are refused
  bool single_register_writes = true;  ///< one register is written by function 6, else by 16
  std::filesystem::path wire_log;      ///< every frame, with its time; empty: none
};

struct LinkStatistics {
  std::uint64_t requests = 0;    ///< sent, retries included
  std::uint64_t writes = 0;      ///< of them
  std::uint64_t retries = 0;     ///< of reads
  std::uint64_t reconnects = 0;  ///< after the first connection
  std::uint64_t exceptions = 0;  ///< answered by the device
  std::uint64_t bytes_sent = 0, bytes_received = 0;
  double seconds = 0;  ///< spent on requests, waits for gaps and back-off included
};

class LinkConnection;

/// A connection to one Modbus device over TCP or a serial line (RTU); one request at a time.
///
/// A read that fails is tried again `read_retries` times after growing waits; not after an
/// exception other than device_busy and acknowledge. A write is sent once, whatever happens to it
/// (LinkError). After any fault but an exception the next request goes over a new connection (TCP),
/// or after `byte_timeout` of silence (serial line), so that nothing of one exchange gets into the
/// next. An answer counts only with the request's own transaction number (TCP), unit and function,
/// and with the length and the echo that belong to it; one that is known as an earlier request's is
/// dropped. Over a serial line, where answers have no number, one that comes later than that
/// silence cannot be known from the next: choose a `response_timeout` that the device keeps.
///
/// Every function throws LinkError with the address, unit and register as its place; bad_input for
/// a count or an address that no device can have; interrupted, before anything is sent, once the
/// user has pressed Ctrl-C (core/interrupt): a request on its way is waited for, so that it is
/// known how it went. Not thread-safe: a link belongs to one thread at a time.
class ModbusLink {
 public:
  /// Connects. Throws LinkError refused where that fails, bad_input for impossible options.
  ModbusLink(LinkAddress address, LinkOptions options = {});
  ~ModbusLink();

  ModbusLink(ModbusLink&&) noexcept;
  ModbusLink& operator=(ModbusLink&&) noexcept;
  ModbusLink(const ModbusLink&) = delete;
  ModbusLink& operator=(const ModbusLink&) = delete;

  /// Of coils or discrete inputs, `address` from 0. At most 2000 go in a request.
  std::vector<bool> read_bits(RegisterTable table, int address, int count);
  /// Of input or holding registers.
  std::vector<std::uint16_t> read_registers(RegisterTable table, int address, int count);

  /// One request each.
  void write_coil(int address, bool value);
  void write_coils(int address, const std::vector<bool>& values);
  void write_registers(int address, std::span<const std::uint16_t> words);

  /// Closes the connection and opens it again; nothing of what was on its way is sent twice.
  void reconnect();
  /// Until the next request, which opens it again.
  void disconnect();

  const LinkAddress& address() const;
  const LinkOptions& options() const;
  LinkStatistics statistics() const;

 private:
  std::unique_ptr<LinkConnection> connection_;
};

}  // namespace gyrator
