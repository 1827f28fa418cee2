#pragma once

#include "gyrator/modbus/link_address.hpp"
#include "gyrator/modbus/register_bank.hpp"

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace gyrator {

/// A request and its answer, on their way through a server.
struct ServerExchange {
  std::span<const std::uint8_t> request, answer;    ///< from the function code on; broadcast: none
  std::size_t request_bytes = 0, answer_bytes = 0;  ///< of the whole frames on the wire
};

/// What becomes of an answer.
struct AnswerPlan {
  enum class Fate {
    send,
    swallow,  ///< never sent
    halve,    ///< only the first half of its bytes
    garble,   ///< one byte wrong: found by the check sum (RTU) or the transaction number (TCP)
    cut       ///< the connection is closed instead (TCP); swallowed (RTU)
  };
  Fate fate = Fate::send;
  double delay = 0;  ///< before it is sent [s]; other clients are served meanwhile
  std::optional<std::vector<std::uint8_t>> other_answer;  ///< instead, from the function code on
};

/// Where a simulated device shows its timing and its moods; called in the server's thread.
struct ServerHooks {
  /// Before the bank is asked: an exception is answered at once, and nothing is done.
  std::function<std::optional<ModbusException>(std::span<const std::uint8_t> request)>
      before_request;
  /// After the bank has been asked, before the answer goes out.
  std::function<AnswerPlan(const ServerExchange&)> before_answer;
};

struct ServerOptions {
  /// That is answered. Others are met with silence on a serial line, and over TCP, where a silent
  /// gateway would cost its client a timeout, with "gateway target failed". Broadcasts (unit 0) are
  /// done without an answer on a serial line; over TCP, units 0 and 255 mean this device.
  int unit = 1;
  bool loopback_only = true;       ///< refuses to listen to other machines
  int most_clients = 32;           ///< the next one is turned away
  double serial_frame_gap = 0.02;  ///< silence that ends a frame, at least (see frame_gap) [s]
};

struct ServerStatistics {
  std::uint64_t requests = 0;  ///< answered, exceptions included
  std::uint64_t exceptions = 0;
  std::uint64_t discarded = 0;  ///< frames that made no sense or were not for this unit
  std::uint64_t clients = 0;    ///< accepted so far
};

/// Serves a RegisterBank to Modbus clients over TCP and a serial line, in one thread.
///
/// Its own frames and function codes, rather than libmodbus': the server side of Debian's libmodbus
/// 3.1.6 has had memory errors. Requests are taken one after another, of one client only after the
/// answer before has been sent. Nothing that a client sends ends the server: TCP clients that talk
/// no Modbus are disconnected, bytes on a serial line that make no frame are dropped at the next
/// gap of silence.
class ModbusServer {
 public:
  /// The bank outlives the server. Throws bad_input for impossible options.
  ModbusServer(RegisterBank& bank, ServerOptions options = {}, ServerHooks hooks = {});
  ~ModbusServer();

  ModbusServer(const ModbusServer&) = delete;
  ModbusServer& operator=(const ModbusServer&) = delete;
  ModbusServer(ModbusServer&&) = delete;
  ModbusServer& operator=(ModbusServer&&) = delete;

  /// Listens at the host's address and returns the port: the one given, or for 0 a free one.
  /// Throws bad_input for an address of another machine, or one that others can reach while
  /// loopback_only; device for a port in use.
  std::uint16_t listen(const std::string& host, std::uint16_t port);

  /// Answers on a serial line. Throws device where it cannot be opened.
  void open_serial(const SerialAddress& line);

  /// Answers on a pseudo-terminal, which clients open as `link`, a symbolic link that is removed
  /// with the server; returns the terminal's own name. An empty link: none is made. Throws
  /// bad_input where a file that is no symbolic link is in its place.
  std::string open_pseudo_terminal(const std::filesystem::path& link,
                                   const SerialAddress& line = {});

  /// Serves what is there, waiting at most so long for it [s]; returns whether stop() was called.
  bool poll(double seconds);
  /// Serves until stop() or Ctrl-C (core/interrupt).
  void run();
  /// Ends run(); may be called from any thread and from a signal handler.
  void stop();

  ServerStatistics statistics() const;

 private:
  class Service;
  std::unique_ptr<Service> service_;
};

}  // namespace gyrator
