#pragma once

#include "gyrator/modbus/link_transport.hpp"
#include "gyrator/modbus/modbus_frame.hpp"
#include "gyrator/modbus/modbus_link.hpp"
#include "gyrator/modbus/wire_log.hpp"

#include <chrono>
#include <optional>
#include <string>

namespace gyrator {

/// A request to a device, and how to speak of it.
struct LinkRequest {
  Bytes pdu;          ///< from the function code on
  std::string place;  ///< "tcp://127.0.0.1:1502, unit 1, holding 0x0010 (40017)"
  bool is_write = false;
};

/// Asks one device, and decides what becomes of a request that fails: the rules of ModbusLink.
class LinkConnection {
 public:
  /// Connects. The options have been checked.
  LinkConnection(LinkAddress address, LinkOptions options);

  /// The answer, from the function code on, which is the right one to the request.
  Bytes perform(const LinkRequest& request);

  void reopen();
  void close();

  const LinkAddress& address() const { return address_; }
  const LinkOptions& options() const { return options_; }
  const LinkStatistics& statistics() const { return statistics_; }
  /// "tcp://127.0.0.1:1502, unit 1"
  const std::string& name() const { return name_; }

 private:
  using Clock = std::chrono::steady_clock;
  using Received = LinkTransport::Received;

  /// What one try came to: an answer, or the fault.
  struct Outcome {
    Bytes answer;
    std::optional<LinkError> fault;
  };

  Outcome try_once(const LinkRequest& request);
  std::optional<LinkError> open(const std::string& place);
  std::optional<LinkError> make_ready(const std::string& place);
  void keep_gap(const std::string& place) const;
  void settle();
  Outcome exchange(const LinkRequest& request);
  Outcome await_answer(const LinkRequest& request);
  Received receive(double seconds);
  Outcome judge(const LinkRequest& request, const Received& received);
  Outcome judge_frame(const LinkRequest& request, ByteSpan frame);
  Outcome fail(const LinkRequest& request, LinkFault fault, std::string message,
               std::optional<ModbusException> exception = {});
  Outcome fail_as_garbled(const LinkRequest& request, const std::string& what);
  std::string find_frame_mistake(ByteSpan frame) const;
  bool is_late_answer(const Received& received) const;
  ByteSpan pdu_of(ByteSpan frame) const;

  const LinkAddress address_;
  const LinkOptions options_;
  LinkStatistics statistics_;
  const std::string name_;
  WireLog log_;
  LinkTransport transport_;
  const bool serial_;
  double line_gap_ = 0;        // silence that parts frames on the serial line [s]
  double character_time_ = 0;  // of the serial line [s]; over TCP 0
  std::uint16_t transaction_ = 0;
  bool was_open_ = false;
  bool unsettled_ = false;  // a late answer may still come over the serial line
  Clock::time_point last_;  // end of the last exchange
};

}  // namespace gyrator
