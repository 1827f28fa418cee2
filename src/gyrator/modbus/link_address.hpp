#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <variant>

namespace gyrator {

/// A Modbus TCP device or gateway.
struct TcpAddress {
  std::string host;          ///< a name or an address of the internet
  std::uint16_t port = 502;  ///< that of the Modbus specification
};

enum class Parity : char { none = 'N', even = 'E', odd = 'O' };

/// A serial line; the defaults are those of the Modbus serial line specification 1.02.
struct SerialAddress {
  std::string device;  ///< "/dev/ttyUSB0"
  int baud = 19200;    ///< bits per second
  Parity parity = Parity::even;
  int stop_bits = 1;
};

using LinkAddress = std::variant<TcpAddress, SerialAddress>;

/// The address of "tcp://HOST[:PORT]" or "rtu://DEVICE[?baud=B&parity=N|E|O&stop=1|2]", such as
/// tcp://127.0.0.1:1502, tcp://[::1]:502 and rtu:///dev/ttyUSB0?baud=115200&parity=E&stop=1.
/// Throws bad_input, the text as its place: also for a baud rate that the serial driver does not
/// know, as libmodbus would silently take 9600 instead.
LinkAddress parse_link_address(std::string_view text);

/// The text that parses to it, with every setting of a serial line.
std::string describe(const LinkAddress& address);

/// Time of one character on a serial line [s]: start bit, 8 data bits, parity, stop bits. The
/// Modbus specification wants 11 bits; two stop bits stand in for no parity.
double compute_character_time(const SerialAddress& line);

/// Silence that parts two frames on a serial line [s]: 3.5 characters, 1.75 ms above 19200 baud.
double compute_frame_gap(const SerialAddress& line);

/// Time that a request and its answer of so many bytes take on a serial line, with the silence
/// after each [s]; a pseudo-terminal takes none of it by itself.
///   t = (n_request + n_answer) t_character + 2 t_gap                               (wire-1)
double compute_wire_time(const SerialAddress& line, std::size_t request_bytes,
                         std::size_t answer_bytes);

}  // namespace gyrator
