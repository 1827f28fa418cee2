#include "gyrator/modbus/server_line.hpp"

#include <array>
#include <cerrno>
#include <sys/socket.h>

namespace gyrator {
namespace {

constexpr std::size_t longest_serial_frame = 256;

ByteSpan first_of(const Bytes& bytes, std::size_t size) {
  return ByteSpan(bytes).first(size);
}

}  // namespace

std::optional<ServerRequest> TcpFrames::take() {
  constexpr std::size_t before_length_counts = 6;
  constexpr std::size_t shortest = 2;
  constexpr std::size_t longest = longest_pdu + 1;
  if (broken_ || bytes_.size() < tcp_header_bytes) return std::nullopt;
  const TcpHeader header = read_tcp_header(bytes_);
  broken_ = header.protocol != 0 || header.length < shortest || header.length > longest;
  const std::size_t size = before_length_counts + header.length;
  if (broken_ || bytes_.size() < size) return std::nullopt;
  ServerRequest request{
      header.transaction, header.unit,
      Bytes(bytes_.begin() + tcp_header_bytes, bytes_.begin() + static_cast<std::ptrdiff_t>(size)),
      size};
  bytes_.erase(bytes_.begin(), bytes_.begin() + static_cast<std::ptrdiff_t>(size));
  return request;
}

void SerialFrames::append(ByteSpan bytes) {
  constexpr std::size_t never_a_frame = 4096;  // noise without a gap
  if (bytes_.size() > never_a_frame) bytes_.clear();
  bytes_.insert(bytes_.end(), bytes.begin(), bytes.end());
}

ServerRequest SerialFrames::cut(std::size_t size) {
  constexpr std::ptrdiff_t crc_bytes = 2;
  const auto end = bytes_.begin() + static_cast<std::ptrdiff_t>(size);
  ServerRequest request{0, bytes_.front(), Bytes(bytes_.begin() + 1, end - crc_bytes), size};
  bytes_.erase(bytes_.begin(), end);
  return request;
}

std::optional<ServerRequest> SerialFrames::take() {
  constexpr std::size_t unit_and_crc = 3;
  if (bytes_.empty()) return std::nullopt;
  const auto length = find_request_length(ByteSpan(bytes_).subspan(1));
  if (!length || bytes_.size() < *length + unit_and_crc) return std::nullopt;
  const std::size_t size = *length + unit_and_crc;
  if (size > longest_serial_frame || !has_valid_crc(first_of(bytes_, size))) return std::nullopt;
  return cut(size);
}

std::optional<ServerRequest> SerialFrames::take_at_gap() {
  constexpr std::size_t shortest = 4;
  std::optional<ServerRequest> request;
  if (bytes_.size() >= shortest && bytes_.size() <= longest_serial_frame && has_valid_crc(bytes_))
    request = cut(bytes_.size());
  bytes_.clear();
  return request;
}

void ServerLine::receive() {
  std::array<std::uint8_t, 1024> bytes{};
  const ssize_t size = ::read(number, bytes.data(), bytes.size());
  if (size > 0) {
    const ByteSpan received(bytes.data(), static_cast<std::size_t>(size));
    last_byte = Clock::now();
    if (serial)
      serial_frames.append(received);
    else
      tcp_frames.append(received);
  } else if (size == 0 || (errno != EAGAIN && errno != EWOULDBLOCK && errno != EINTR)) {
    closed = true;
  }
}

void ServerLine::send_due(Clock::time_point now) {
  if (!is_busy() || now < due) return;
  if (cut_when_due) {
    closed = !serial;
    cut_when_due = false;
    output.clear();
    return;
  }
  const ssize_t sent = serial ? ::write(number, output.data(), output.size())
                              : ::send(number, output.data(), output.size(), MSG_NOSIGNAL);
  if (sent > 0)
    output.erase(output.begin(), output.begin() + sent);
  else if (errno != EAGAIN && errno != EWOULDBLOCK && errno != EINTR)
    closed = true;
}

}  // namespace gyrator
