#pragma once

#include "gyrator/modbus/modbus_frame.hpp"

#include <filesystem>
#include <fstream>
#include <string>
#include <string_view>

namespace gyrator {

/// A file to which every frame is appended as it goes over the wire, a line each: time (UTC, to the
/// microsecond), address, direction ('>' sent, '<' received, '!' what happened else), bytes or
/// words.
class WireLog {
 public:
  /// An empty path: nothing is logged. Throws bad_input for a file that cannot be written.
  WireLog(const std::filesystem::path& path, std::string address);

  void note_sent(ByteSpan frame) { write('>', frame); }
  void note_received(ByteSpan frame) { write('<', frame); }
  void note(std::string_view event);

 private:
  void write(char direction, ByteSpan frame);

  std::ofstream file_;
  std::string address_;
};

}  // namespace gyrator
