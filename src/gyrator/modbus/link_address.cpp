#include "gyrator/modbus/link_address.hpp"

#include "gyrator/core/error.hpp"
#include "gyrator/core/text.hpp"
#include "gyrator/modbus/serial_line.hpp"

#include <algorithm>
#include <charconv>
#include <optional>
#include <vector>

#include <fmt/core.h>

namespace gyrator {
namespace {

constexpr std::string_view grammar =
    "must be tcp://HOST:PORT, such as tcp://127.0.0.1:1502, or rtu://DEVICE, such as "
    "rtu:///dev/ttyUSB0?baud=115200&parity=E&stop=1";

[[noreturn]] void refuse(std::string_view text, std::string_view why) {
  throw Error(ErrorCode::bad_input, std::string(text), std::string(why));
}

std::optional<int> find_integer(std::string_view text) {
  int number = 0;
  const auto [end, failed] = std::from_chars(text.data(), text.data() + text.size(), number);
  if (failed != std::errc{} || end != text.data() + text.size()) return std::nullopt;
  return number;
}

TcpAddress parse_tcp(std::string_view text, std::string_view rest) {
  TcpAddress address;
  std::string_view port;
  if (rest.starts_with('[')) {  // an IPv6 address has colons of its own
    const std::size_t end = rest.find(']');
    if (end == std::string_view::npos) refuse(text, "has no ']' to its '['");
    address.host = rest.substr(1, end - 1);
    rest.remove_prefix(end + 1);
    if (!rest.empty() && !rest.starts_with(':')) refuse(text, grammar);
    port = rest.empty() ? rest : rest.substr(1);
    if (!rest.empty() && port.empty()) refuse(text, grammar);
  } else {
    const std::size_t colon = rest.find(':');
    address.host = rest.substr(0, colon);
    if (colon != std::string_view::npos) {
      port = rest.substr(colon + 1);
      if (port.empty()) refuse(text, grammar);
    }
  }
  if (address.host.empty() || address.host.find_first_of("/?&@ ") != std::string::npos)
    refuse(text, grammar);
  if (port.empty()) return address;
  constexpr int last_port = 65535;
  const auto number = find_integer(port);
  if (!number || *number < 1 || *number > last_port)
    refuse(text, fmt::format("port '{}': must be a whole number from 1 to {}", port, last_port));
  address.port = static_cast<std::uint16_t>(*number);
  return address;
}

int parse_baud(std::string_view text, std::string_view value) {
  const auto number = find_integer(value);
  const auto& known = known_baud_rates();
  if (number && std::find(known.begin(), known.end(), *number) != known.end()) return *number;
  std::vector<std::string> rates;
  rates.reserve(known.size());
  for (const int rate : known) rates.push_back(std::to_string(rate));
  refuse(text, fmt::format("baud={}: allowed: {}", value, join(rates)));
}

void set_option(SerialAddress& address, std::string_view text, std::string_view option) {
  const std::size_t equals = option.find('=');
  const std::string_view name = option.substr(0, equals);
  const std::string_view value =
      equals == std::string_view::npos ? std::string_view{} : option.substr(equals + 1);
  if (name == "baud") {
    address.baud = parse_baud(text, value);
  } else if (name == "parity") {
    if (value == "N")
      address.parity = Parity::none;
    else if (value == "E")
      address.parity = Parity::even;
    else if (value == "O")
      address.parity = Parity::odd;
    else
      refuse(text, fmt::format("parity={}: allowed: N, E, O", value));
  } else if (name == "stop") {
    if (value != "1" && value != "2") refuse(text, fmt::format("stop={}: allowed: 1, 2", value));
    address.stop_bits = value == "1" ? 1 : 2;
  } else {
    refuse(text, describe_unknown_name("setting", name, {"baud", "parity", "stop"}));
  }
}

SerialAddress parse_serial(std::string_view text, std::string_view rest) {
  SerialAddress address;
  const std::size_t question = rest.find('?');
  address.device = rest.substr(0, question);
  if (address.device.empty()) refuse(text, grammar);
  if (question == std::string_view::npos) return address;
  rest.remove_prefix(question + 1);
  while (true) {
    const std::size_t end = rest.find('&');
    set_option(address, text, rest.substr(0, end));
    if (end == std::string_view::npos) return address;
    rest.remove_prefix(end + 1);
  }
}

}  // namespace

LinkAddress parse_link_address(std::string_view text) {
  constexpr std::string_view tcp = "tcp://";
  constexpr std::string_view rtu = "rtu://";
  if (text.starts_with(tcp)) return parse_tcp(text, text.substr(tcp.size()));
  if (text.starts_with(rtu)) return parse_serial(text, text.substr(rtu.size()));
  refuse(text, grammar);
}

std::string describe(const LinkAddress& address) {
  if (const auto* tcp = std::get_if<TcpAddress>(&address)) {
    const bool has_colons = tcp->host.find(':') != std::string::npos;
    const std::string host = has_colons ? "[" + tcp->host + "]" : tcp->host;
    return fmt::format("tcp://{}:{}", host, tcp->port);
  }
  const auto& serial = std::get<SerialAddress>(address);
  return fmt::format("rtu://{}?baud={}&parity={}&stop={}", serial.device, serial.baud,
                     static_cast<char>(serial.parity), serial.stop_bits);
}

double compute_character_time(const SerialAddress& line) {
  constexpr int start_and_data_bits = 9;
  const int bits = start_and_data_bits + (line.parity == Parity::none ? 0 : 1) + line.stop_bits;
  return static_cast<double>(bits) / line.baud;
}

double compute_frame_gap(const SerialAddress& line) {
  constexpr int last_counted_in_characters = 19200;
  constexpr double fixed_gap = 1.75e-3;
  constexpr double characters = 3.5;
  return line.baud > last_counted_in_characters ? fixed_gap
                                                : characters * compute_character_time(line);
}

double compute_wire_time(const SerialAddress& line, std::size_t request_bytes,
                         std::size_t answer_bytes) {
  return static_cast<double>(request_bytes + answer_bytes) * compute_character_time(line) +
         2 * compute_frame_gap(line);
}

}  // namespace gyrator
