#include "gyrator/modbus/modbus_server.hpp"

#include "gyrator/core/error.hpp"
#include "gyrator/core/interrupt.hpp"
#include "gyrator/modbus/listening_socket.hpp"
#include "gyrator/modbus/modbus_frame.hpp"
#include "gyrator/modbus/serial_line.hpp"
#include "gyrator/modbus/server_line.hpp"

#include <algorithm>
#include <cmath>
#include <ctime>
#include <list>
#include <poll.h>
#include <sys/eventfd.h>
#include <utility>

#include <fmt/core.h>

namespace gyrator {
namespace {

using Clock = ServerLine::Clock;

Clock::duration to_duration(double seconds) {
  return std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(seconds));
}

void check(bool fine, const std::string& message) {
  if (!fine) throw Error(ErrorCode::bad_input, "Modbus server", message);
}

}  // namespace

class ModbusServer::Service {
 public:
  Service(RegisterBank& bank, ServerOptions options, ServerHooks hooks);

  std::uint16_t listen(const std::string& host, std::uint16_t port);
  void open_serial(const SerialAddress& line);
  std::string open_pseudo_terminal(const std::filesystem::path& link, const SerialAddress& line);
  bool poll(double seconds);
  void stop() const { ::eventfd_write(stop_.get(), 1); }
  const ServerStatistics& statistics() const { return statistics_; }

 private:
  void add_serial(int descriptor, const SerialAddress& line);
  void wait_for_events(Clock::time_point until);
  Clock::time_point next_deadline(Clock::time_point until) const;
  void accept_clients(int listener);
  void serve(ServerLine& line, Clock::time_point now);
  void handle(ServerLine& line, const ServerRequest& request);
  std::optional<Bytes> answer(const ServerLine& line, const ServerRequest& request);
  bool is_for_us(const ServerLine& line, std::uint8_t unit) const;
  void plan(ServerLine& line, const ServerRequest& request, const Bytes& pdu);

  RegisterBank& bank_;
  const ServerOptions options_;
  const ServerHooks hooks_;
  FileDescriptor stop_;
  std::vector<FileDescriptor> listeners_;
  std::vector<FileDescriptor> serial_ports_;
  std::list<PseudoTerminal> terminals_;
  std::list<ServerLine> lines_;
  double serial_gap_ = 0;  // [s]
  bool stopped_ = false;
  ServerStatistics statistics_;
};

ModbusServer::Service::Service(RegisterBank& bank, ServerOptions options, ServerHooks hooks)
    : bank_(bank),
      options_(options),
      hooks_(std::move(hooks)),
      stop_(::eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK)),
      serial_gap_(options.serial_frame_gap) {
  constexpr int last_unit = 247;
  constexpr int most_clients = 500;
  check(options.unit >= 1 && options.unit <= last_unit,
        fmt::format("unit {}: must be from 1 to {}", options.unit, last_unit));
  check(options.most_clients >= 1 && options.most_clients <= most_clients,
        fmt::format("{} clients: must be from 1 to {}", options.most_clients, most_clients));
  check(options.serial_frame_gap >= 0 && options.serial_frame_gap <= 1,
        fmt::format("frame gap of {} s: must be from 0 to 1 s", options.serial_frame_gap));
  if (!stop_.is_open()) throw Error(ErrorCode::device, "Modbus server", "too many open files");
}

std::uint16_t ModbusServer::Service::listen(const std::string& host, std::uint16_t port) {
  ListeningSocket listener = listen_for_tcp(host, port, options_.loopback_only);
  listeners_.push_back(std::move(listener.socket));
  return listener.port;
}

void ModbusServer::Service::add_serial(int descriptor, const SerialAddress& line) {
  serial_gap_ = std::max(serial_gap_, compute_frame_gap(line));
  lines_.emplace_back(descriptor);
}

void ModbusServer::Service::open_serial(const SerialAddress& line) {
  serial_ports_.push_back(open_serial_line(line));
  add_serial(serial_ports_.back().get(), line);
}

std::string ModbusServer::Service::open_pseudo_terminal(const std::filesystem::path& link,
                                                        const SerialAddress& line) {
  const PseudoTerminal& terminal = terminals_.emplace_back(link);
  add_serial(terminal.descriptor(), line);
  return terminal.name();
}

/// When something is to be done though nothing comes.
Clock::time_point ModbusServer::Service::next_deadline(Clock::time_point until) const {
  for (const ServerLine& line : lines_) {
    if (line.is_busy() && line.due > Clock::now()) until = std::min(until, line.due);
    if (!line.serial_frames.is_empty() && !line.is_busy())
      until = std::min(until, line.last_byte + to_duration(serial_gap_));
  }
  return until;
}

void ModbusServer::Service::wait_for_events(Clock::time_point until) {
  const auto now = Clock::now();
  std::vector<pollfd> watched{{stop_.get(), POLLIN, 0}};
  for (const FileDescriptor& listener : listeners_) watched.push_back({listener.get(), POLLIN, 0});
  for (const ServerLine& line : lines_) {
    short events = line.is_busy() ? 0 : POLLIN;
    if (line.is_busy() && line.due <= now) events = POLLOUT;
    watched.push_back({line.number, events, 0});
  }
  const double left =
      std::max(std::chrono::duration<double>(next_deadline(until) - now).count(), 0.0);
  const double seconds = std::floor(left);
  const timespec patience{static_cast<std::time_t>(seconds),
                          static_cast<long>((left - seconds) * 1e9)};
  if (::ppoll(watched.data(), watched.size(), &patience, nullptr) <= 0) return;
  std::size_t i = 0;
  if (watched[i++].revents != 0) stopped_ = true;
  std::vector<int> knocking;
  for (const FileDescriptor& listener : listeners_)
    if (watched[i++].revents != 0) knocking.push_back(listener.get());
  for (ServerLine& line : lines_) {
    const short events = watched[i++].revents;
    if ((events & POLLIN) != 0)
      line.receive();
    else if ((events & (POLLHUP | POLLERR | POLLNVAL)) != 0)
      line.closed = true;
  }
  for (const int listener : knocking) accept_clients(listener);
}

void ModbusServer::Service::accept_clients(int listener) {
  while (auto client = accept_client(listener)) {
    const auto there = std::count_if(lines_.begin(), lines_.end(), [](const ServerLine& line) {
      return !line.serial && !line.closed;
    });
    if (there >= options_.most_clients) continue;  // closed at once
    lines_.emplace_back(std::move(*client));
    ++statistics_.clients;
  }
}

bool ModbusServer::Service::is_for_us(const ServerLine& line, std::uint8_t unit) const {
  constexpr std::uint8_t tcp_device = 255;
  return unit == options_.unit || unit == 0 || (!line.serial && unit == tcp_device);
}

/// Nothing for a unit that is not ours on a serial line.
std::optional<Bytes> ModbusServer::Service::answer(const ServerLine& line,
                                                   const ServerRequest& request) {
  const std::uint8_t function = request.pdu[0];
  if (!is_for_us(line, request.unit)) {
    ++statistics_.discarded;
    if (line.serial) return std::nullopt;
    return make_exception_answer(function, ModbusException::gateway_target_failed);
  }
  if (hooks_.before_request)
    if (const auto refusal = hooks_.before_request(request.pdu))
      return make_exception_answer(function, *refusal);
  Bytes found = answer_request(request.pdu, bank_);
  if (found.empty()) {
    ++statistics_.discarded;
    return std::nullopt;
  }
  return found;
}

void ModbusServer::Service::handle(ServerLine& line, const ServerRequest& request) {
  const auto found = answer(line, request);
  if (!found) return;
  const bool broadcast = line.serial && request.unit == 0;
  ++statistics_.requests;
  if (((*found)[0] & exception_flag) != 0) ++statistics_.exceptions;
  plan(line, request, broadcast ? Bytes{} : *found);
}

/// Puts the answer on its way, as the hook wants it. A broadcast has an empty one.
void ModbusServer::Service::plan(ServerLine& line, const ServerRequest& request, const Bytes& pdu) {
  const auto frame_of = [&](const Bytes& content) {
    if (content.empty()) return Bytes{};
    return line.serial ? make_serial_frame(request.unit, content)
                       : make_tcp_frame(request.transaction, request.unit, content);
  };
  Bytes frame = frame_of(pdu);
  AnswerPlan plan;
  if (hooks_.before_answer)
    plan = hooks_.before_answer({request.pdu, pdu, request.frame_bytes, frame.size()});
  if (plan.other_answer && !pdu.empty()) frame = frame_of(*plan.other_answer);
  using Fate = AnswerPlan::Fate;
  if (plan.fate == Fate::swallow) frame.clear();
  if (plan.fate == Fate::halve) frame.resize(frame.size() / 2);
  if (plan.fate == Fate::garble && !frame.empty())
    frame[line.serial ? frame.size() - 1 : 0] ^= 0x40U;
  line.output = std::move(frame);
  line.cut_when_due = plan.fate == Fate::cut;
  line.due = Clock::now() + to_duration(std::max(plan.delay, 0.0));
}

/// Requests one after another, until one must wait for its answer's time.
void ModbusServer::Service::serve(ServerLine& line, Clock::time_point now) {
  line.send_due(now);
  while (!line.closed && !line.is_busy()) {
    auto request = line.take();
    if (!request && line.serial && !line.serial_frames.is_empty() &&
        now - line.last_byte >= to_duration(serial_gap_)) {
      request = line.serial_frames.take_at_gap();
      if (!request) ++statistics_.discarded;
    }
    if (!request) break;
    handle(line, *request);
    line.send_due(Clock::now());
  }
  if (!line.tcp_frames.is_broken()) return;
  ++statistics_.discarded;
  line.closed = true;
}

bool ModbusServer::Service::poll(double seconds) {
  if (stopped_) return true;
  wait_for_events(Clock::now() + to_duration(seconds));
  const auto now = Clock::now();
  for (ServerLine& line : lines_) serve(line, now);
  lines_.remove_if([](const ServerLine& line) { return line.closed && !line.serial; });
  const bool lost =
      std::any_of(lines_.begin(), lines_.end(), [](const ServerLine& line) { return line.closed; });
  if (lost) throw Error(ErrorCode::device, "serial line", "lost: is it still plugged in?");
  return stopped_;
}

ModbusServer::ModbusServer(RegisterBank& bank, ServerOptions options, ServerHooks hooks)
    : service_(std::make_unique<Service>(bank, options, std::move(hooks))) {}
ModbusServer::~ModbusServer() = default;

std::uint16_t ModbusServer::listen(const std::string& host, std::uint16_t port) {
  return service_->listen(host, port);
}
void ModbusServer::open_serial(const SerialAddress& line) {
  service_->open_serial(line);
}
std::string ModbusServer::open_pseudo_terminal(const std::filesystem::path& link,
                                               const SerialAddress& line) {
  return service_->open_pseudo_terminal(link, line);
}

bool ModbusServer::poll(double seconds) {
  return service_->poll(seconds);
}

void ModbusServer::run() {
  constexpr double look_around = 0.1;  // [s], for a Ctrl-C that came just before the wait
  while (!interrupt_requested())
    if (service_->poll(look_around)) return;
}

void ModbusServer::stop() {
  service_->stop();
}

ServerStatistics ModbusServer::statistics() const {
  return service_->statistics();
}

}  // namespace gyrator
