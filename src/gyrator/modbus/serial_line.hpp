#pragma once

#include "gyrator/modbus/file_descriptor.hpp"
#include "gyrator/modbus/link_address.hpp"

#include <filesystem>
#include <string>
#include <vector>

namespace gyrator {

/// Baud rates that the system's serial driver and libmodbus both know.
const std::vector<int>& known_baud_rates();

/// Whether the device file, or what it is a link to, is a pseudo-terminal. These have no parity,
/// and the system refuses to set one, so that it is left out.
bool is_pseudo_terminal(const std::string& device);

/// Opens the line's device for reads that do not wait, with its baud rate, parity and stop bits,
/// and nothing done to the bytes. Throws device, the device file as its place.
FileDescriptor open_serial_line(const SerialAddress& line);

/// A pair of a terminal that others open as a serial line, and the end of it that is ours.
class PseudoTerminal {
 public:
  /// `link` becomes a symbolic link to the terminal until the object goes; empty: none. A link that
  /// another pseudo-terminal has left there is replaced. Throws bad_input for anything else in its
  /// place, device where the system has no terminal to give.
  explicit PseudoTerminal(std::filesystem::path link = {});
  ~PseudoTerminal();

  PseudoTerminal(const PseudoTerminal&) = delete;
  PseudoTerminal& operator=(const PseudoTerminal&) = delete;
  PseudoTerminal(PseudoTerminal&&) = delete;
  PseudoTerminal& operator=(PseudoTerminal&&) = delete;

  /// Our end; reads do not wait.
  int descriptor() const { return ours_.get(); }
  /// "/dev/pts/7"
  const std::string& name() const { return name_; }

 private:
  FileDescriptor ours_;
  FileDescriptor held_;  // theirs, so that ours does not break when a client closes it
  std::string name_;
  std::filesystem::path link_;
};

}  // namespace gyrator
