#pragma once

#include "gyrator/modbus/link_address.hpp"
#include "gyrator/modbus/modbus_frame.hpp"

#include <memory>
#include <string>

namespace gyrator {

/// Frames to and from one device over libmodbus, which opens the connection, sets the serial line
/// up, makes and checks its sums and finds where an answer ends. What the frames say, the numbers
/// of transactions and every decision about faults are the caller's (ModbusLink): libmodbus' own
/// recovery may send a write again.
class LinkTransport {
 public:
  /// For frames of this unit; times in s. Opens nothing yet. Throws bad_input.
  LinkTransport(const LinkAddress& address, int unit, double response_timeout, double byte_timeout);
  ~LinkTransport();

  LinkTransport(const LinkTransport&) = delete;
  LinkTransport& operator=(const LinkTransport&) = delete;
  LinkTransport(LinkTransport&&) = delete;
  LinkTransport& operator=(LinkTransport&&) = delete;

  bool is_open() const;
  /// Returns why it could not be opened; empty if it is.
  std::string open();
  void close();

  /// What stands between requests, where nothing should.
  enum class Line { quiet, has_bytes, broken };
  Line look();
  /// Drops what has come; keeps at it until nothing has come for `silence` [s], or for ten times as
  /// long.
  void drop_input(double silence);

  /// Of a TCP frame with its header, or of a serial one without its check sum. Returns why it could
  /// not be sent; empty if it was.
  std::string send(ByteSpan frame);

  struct Received {
    enum class Kind { frame, nothing, part, broken, nonsense };
    Kind kind = Kind::nothing;
    Bytes bytes;      ///< of a frame, with header or check sum
    std::string why;  ///< broken, nonsense
  };
  /// The next frame, if its first byte comes within so many seconds.
  Received receive(double seconds);

 private:
  struct Context;
  std::unique_ptr<Context> context_;
};

}  // namespace gyrator
