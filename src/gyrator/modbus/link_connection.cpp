#include "gyrator/modbus/link_connection.hpp"

#include "gyrator/core/interrupt.hpp"

#include <algorithm>
#include <cmath>
#include <string_view>
#include <thread>
#include <utility>

#include <fmt/core.h>

namespace gyrator {
namespace {

using Clock = std::chrono::steady_clock;

constexpr std::string_view read_back_hint = "; the write may have arrived or not: read it back";

bool is_worth_a_retry(const LinkError& fault) {
  return fault.fault() != LinkFault::exception ||
         fault.exception() == ModbusException::device_busy ||
         fault.exception() == ModbusException::acknowledge;
}

/// What an exception usually comes from.
std::string_view explain(ModbusException exception) {
  switch (exception) {
    case ModbusException::illegal_function:
      return "; the device does not have it";
    case ModbusException::illegal_data_address:
      return "; is the profile that of this device, and its addresses counted from 0?";
    case ModbusException::illegal_data_value:
      return "; the device does not take this value or count";
    case ModbusException::gateway_path_unavailable:
    case ModbusException::gateway_target_failed:
      return "; is the unit right?";
    default:
      return "";
  }
}

/// Adds the time of its life to a sum.
class Stopwatch {
 public:
  explicit Stopwatch(double& sum) : sum_(sum) {}
  ~Stopwatch() { sum_ += std::chrono::duration<double>(Clock::now() - begin_).count(); }
  Stopwatch(const Stopwatch&) = delete;
  Stopwatch& operator=(const Stopwatch&) = delete;
  Stopwatch(Stopwatch&&) = delete;
  Stopwatch& operator=(Stopwatch&&) = delete;

 private:
  double& sum_;
  Clock::time_point begin_ = Clock::now();
};

void sleep(double seconds, const std::string& place) {
  constexpr double longest_nap = 0.05;  // [s], so that Ctrl-C is heard
  const auto end = Clock::now() + std::chrono::duration<double>(seconds);
  while (Clock::now() < end) {
    throw_if_interrupted(place);
    const std::chrono::duration<double> left = end - Clock::now();
    std::this_thread::sleep_for(std::min(left, std::chrono::duration<double>(longest_nap)));
  }
}

}  // namespace

LinkConnection::LinkConnection(LinkAddress address, LinkOptions options)
    : address_(std::move(address)),
      options_(std::move(options)),
      name_(fmt::format("{}, unit {}", describe(address_), options_.unit)),
      log_(options_.wire_log, describe(address_)),
      transport_(address_, options_.unit, options_.response_timeout, options_.byte_timeout),
      serial_(std::holds_alternative<SerialAddress>(address_)) {
  if (const auto* line = std::get_if<SerialAddress>(&address_)) {
    line_gap_ = compute_frame_gap(*line);
    character_time_ = compute_character_time(*line);
  }
  throw_if_interrupted(name_);
  if (const auto refused = open(name_)) throw LinkError(*refused);
}

std::optional<LinkError> LinkConnection::open(const std::string& place) {
  const std::string why = transport_.open();
  if (!why.empty()) {
    log_.note("no connection: " + why);
    const std::string_view remedy = serial_ ? "is the device file right, plugged in and readable?"
                                            : "is the device on, and its address and port right?";
    return LinkError(LinkFault::refused, place, fmt::format("no connection: {}: {}", why, remedy));
  }
  if (was_open_) ++statistics_.reconnects;
  was_open_ = true;
  unsettled_ = false;
  log_.note("connected");
  return std::nullopt;
}

void LinkConnection::close() {
  if (transport_.is_open()) log_.note("disconnected");
  transport_.close();
}

void LinkConnection::reopen() {
  throw_if_interrupted(name_);
  close();
  if (const auto refused = open(name_)) throw LinkError(*refused);
}

void LinkConnection::keep_gap(const std::string& place) const {
  if (last_ == Clock::time_point{}) return;
  const double gap = std::max(options_.gap, line_gap_);
  const double since = std::chrono::duration<double>(Clock::now() - last_).count();
  if (since < gap) sleep(gap - since, place);
}

/// Takes what has come too late off the connection; closes it where that is not to be known.
void LinkConnection::settle() {
  if (serial_) {
    // A serial answer has no number: all that is on its way must have come.
    if (!unsettled_ && transport_.look() == LinkTransport::Line::quiet) return;
    log_.note("dropping what came too late");
    transport_.drop_input(options_.byte_timeout);
    unsettled_ = false;
    return;
  }
  if (transport_.look() != LinkTransport::Line::has_bytes) return;
  ++transaction_;  // what waits here answers an earlier one
  while (transport_.look() == LinkTransport::Line::has_bytes)
    if (!is_late_answer(receive(0))) return close();
}

/// A connection on which nothing waits to be taken for the next answer.
std::optional<LinkError> LinkConnection::make_ready(const std::string& place) {
  keep_gap(place);
  if (transport_.is_open()) settle();
  if (transport_.is_open() && transport_.look() == LinkTransport::Line::broken) {
    log_.note("the device has closed the connection");
    close();
  }
  throw_if_interrupted(place);
  if (transport_.is_open()) return std::nullopt;
  return open(place);
}

LinkConnection::Outcome LinkConnection::fail(const LinkRequest& request, LinkFault fault,
                                             std::string message,
                                             std::optional<ModbusException> exception) {
  log_.note(message);
  const bool uncertain = fault != LinkFault::refused && fault != LinkFault::exception;
  if (request.is_write && uncertain) message += read_back_hint;
  return {{}, LinkError(fault, request.place, std::move(message), exception)};
}

ByteSpan LinkConnection::pdu_of(ByteSpan frame) const {
  constexpr std::size_t unit_bytes = 1;
  constexpr std::size_t crc_bytes = 2;
  return serial_ ? frame.subspan(unit_bytes, frame.size() - unit_bytes - crc_bytes)
                 : frame.subspan(tcp_header_bytes);
}

/// What is wrong with a frame around the answer, which libmodbus does not look at; empty if all is
/// well.
std::string LinkConnection::find_frame_mistake(ByteSpan frame) const {
  constexpr std::size_t shortest_serial = 4;
  constexpr std::size_t shortest_tcp = tcp_header_bytes + 1;
  if (frame.size() < (serial_ ? shortest_serial : shortest_tcp)) return "too short a frame";
  if (serial_)
    return frame[0] == options_.unit ? "" : fmt::format("an answer of unit {}", frame[0]);
  const TcpHeader header = read_tcp_header(frame);
  if (header.protocol != 0) return fmt::format("protocol {} instead of 0", header.protocol);
  if (header.transaction != transaction_)
    return fmt::format("an answer to transaction {}, not to {}", header.transaction, transaction_);
  constexpr std::size_t before_length_counts = 6;
  if (header.length + before_length_counts != frame.size())
    return fmt::format("{} bytes announced and {} needed", header.length,
                       frame.size() - before_length_counts);
  if (header.unit != options_.unit) return fmt::format("an answer of unit {}", header.unit);
  return "";
}

/// An answer to one of the last requests before this one.
bool LinkConnection::is_late_answer(const Received& received) const {
  constexpr int remembered = 64;
  if (serial_ || received.kind != Received::Kind::frame || received.bytes.size() < tcp_header_bytes)
    return false;
  const TcpHeader header = read_tcp_header(received.bytes);
  const auto age = static_cast<std::uint16_t>(transaction_ - header.transaction);
  return header.protocol == 0 && age >= 1 && age <= remembered;
}

LinkConnection::Outcome LinkConnection::fail_as_garbled(const LinkRequest& request,
                                                        const std::string& what) {
  return fail(request, LinkFault::garbled,
              fmt::format("garbled: {}: must be an answer to function {} of unit {}; is another "
                          "master on the line, or its setting wrong?",
                          what, request.pdu[0], options_.unit));
}

/// Takes an answer for what it is.
LinkConnection::Outcome LinkConnection::judge(const LinkRequest& request,
                                              const Received& received) {
  using Kind = Received::Kind;
  switch (received.kind) {
    case Kind::nothing:
      return fail(request, LinkFault::timeout,
                  fmt::format("no answer within {:g} s: is the device on, and is its unit {}?",
                              options_.response_timeout, options_.unit));
    case Kind::part:
      return fail(request, LinkFault::timeout,
                  fmt::format("only a part of an answer, then nothing for {:g} s: is the line "
                              "disturbed, or the byte timeout too short?",
                              options_.byte_timeout));
    case Kind::broken:
      return fail(request, LinkFault::lost,
                  fmt::format("connection lost: {}: is the device still on?", received.why));
    case Kind::nonsense:
      return fail_as_garbled(request, received.why);
    case Kind::frame:
      break;
  }
  return judge_frame(request, received.bytes);
}

LinkConnection::Outcome LinkConnection::judge_frame(const LinkRequest& request, ByteSpan frame) {
  if (const std::string mistake = find_frame_mistake(frame); !mistake.empty())
    return fail_as_garbled(request, mistake);
  const ByteSpan answer = pdu_of(frame);
  if (const std::string mistake = find_answer_mistake(request.pdu, answer); !mistake.empty())
    return fail_as_garbled(request, mistake);
  const auto exception = find_exception(answer);
  if (!exception) return {{answer.begin(), answer.end()}, {}};
  ++statistics_.exceptions;
  return fail(request, LinkFault::exception,
              fmt::format("refused by the device: {}: asked for function {}{}",
                          describe(*exception), request.pdu[0], explain(*exception)),
              exception);
}

LinkConnection::Received LinkConnection::receive(double seconds) {
  Received received = transport_.receive(seconds);
  statistics_.bytes_received += received.bytes.size();
  if (!received.bytes.empty()) log_.note_received(received.bytes);
  if (is_late_answer(received)) log_.note("that was a late answer to an earlier request: dropped");
  return received;
}

LinkConnection::Outcome LinkConnection::await_answer(const LinkRequest& request) {
  constexpr std::size_t frame_bytes = 3;  // unit and check sum
  // The answer cannot begin before the request has left the serial line.
  const double patience = options_.response_timeout +
                          character_time_ * static_cast<double>(request.pdu.size() + frame_bytes);
  const auto end = Clock::now() + std::chrono::duration<double>(patience);
  while (true) {
    const double left = std::chrono::duration<double>(end - Clock::now()).count();
    const Received received = receive(std::max(left, 0.0));
    if (!is_late_answer(received)) return judge(request, received);
  }
}

LinkConnection::Outcome LinkConnection::exchange(const LinkRequest& request) {
  const auto unit = static_cast<std::uint8_t>(options_.unit);
  ++transaction_;
  const Bytes whole = serial_ ? make_serial_frame(unit, request.pdu)
                              : make_tcp_frame(transaction_, unit, request.pdu);
  constexpr std::size_t crc_bytes = 2;  // libmodbus adds them again
  const ByteSpan frame = ByteSpan(whole).first(whole.size() - (serial_ ? crc_bytes : 0));
  ++statistics_.requests;
  if (request.is_write) ++statistics_.writes;
  log_.note_sent(whole);
  if (const std::string why = transport_.send(frame); !why.empty())
    return fail(request, LinkFault::lost,
                fmt::format("connection lost: {}: is the device still on?", why));
  statistics_.bytes_sent += whole.size();
  return await_answer(request);
}

LinkConnection::Outcome LinkConnection::try_once(const LinkRequest& request) {
  if (auto refused = make_ready(request.place)) return {{}, std::move(refused)};
  Outcome outcome = exchange(request);
  last_ = Clock::now();
  if (!outcome.fault) return outcome;
  const LinkFault fault = outcome.fault->fault();
  if (fault == LinkFault::exception) return outcome;
  // After silence too: the device may have got a part of the request, and would take the next one
  // for the rest of it.
  if (serial_ && fault != LinkFault::lost)
    unsettled_ = true;
  else
    close();
  return outcome;
}

Bytes LinkConnection::perform(const LinkRequest& request) {
  constexpr double longest_wait = 5;  // [s]
  const Stopwatch watch(statistics_.seconds);
  double wait = options_.backoff;
  for (int tries = 0;; ++tries) {
    Outcome outcome = try_once(request);
    if (!outcome.fault) return std::move(outcome.answer);
    const bool again =
        !request.is_write && tries < options_.read_retries && is_worth_a_retry(*outcome.fault);
    if (!again) throw LinkError(*outcome.fault);
    ++statistics_.retries;
    sleep(wait, request.place);
    wait = std::min(2 * wait, longest_wait);
  }
}

}  // namespace gyrator
