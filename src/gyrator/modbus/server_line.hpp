#pragma once

#include "gyrator/modbus/file_descriptor.hpp"
#include "gyrator/modbus/modbus_frame.hpp"

#include <chrono>
#include <optional>

namespace gyrator {

/// A request with what goes around it on the wire.
struct ServerRequest {
  std::uint16_t transaction = 0;  ///< TCP
  std::uint8_t unit = 0;
  Bytes pdu;                    ///< from the function code on
  std::size_t frame_bytes = 0;  ///< on the wire
};

/// Bytes that come from a client, cut into requests; one class for each kind of frame.
class TcpFrames {
 public:
  void append(ByteSpan bytes) { bytes_.insert(bytes_.end(), bytes.begin(), bytes.end()); }
  /// The next whole request, taken out.
  std::optional<ServerRequest> take();
  /// What came is no Modbus: the frames are lost for good.
  bool is_broken() const { return broken_; }

 private:
  Bytes bytes_;
  bool broken_ = false;
};

/// On a serial line a frame ends where its function says so and the check sum is right, or at a
/// gap of silence.
class SerialFrames {
 public:
  void append(ByteSpan bytes);
  bool is_empty() const { return bytes_.empty(); }
  std::optional<ServerRequest> take();
  /// The line has been silent: what is there is a whole frame, of an unknown function, or makes
  /// none and is dropped.
  std::optional<ServerRequest> take_at_gap();

 private:
  ServerRequest cut(std::size_t size);

  Bytes bytes_;
};

/// One client: who it is to us, what it asked and what it still has to get. It is asked for no
/// more until it has that.
struct ServerLine {
  using Clock = std::chrono::steady_clock;

  /// A client over TCP.
  explicit ServerLine(FileDescriptor socket) : owned(std::move(socket)), number(owned.get()) {}
  /// A serial line; the descriptor outlives it.
  explicit ServerLine(int descriptor) : number(descriptor), serial(true) {}

  FileDescriptor owned;
  int number;
  bool serial = false;
  TcpFrames tcp_frames;
  SerialFrames serial_frames;
  Clock::time_point last_byte{};
  Bytes output;               ///< to be sent
  Clock::time_point due{};    ///< but not before
  bool cut_when_due = false;  ///< closed instead
  bool closed = false;

  bool is_busy() const { return !output.empty() || cut_when_due; }
  /// Takes what the client has sent; notes its end.
  void receive();
  /// Sends what is due; what does not fit now is tried again.
  void send_due(Clock::time_point now);
  std::optional<ServerRequest> take() { return serial ? serial_frames.take() : tcp_frames.take(); }
};

}  // namespace gyrator
