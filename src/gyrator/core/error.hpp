#pragma once

#include <stdexcept>
#include <string>

namespace gyrator {

/// Whose fault a failure is; the value is the program's exit code (docs/interface).
enum class ErrorCode {
  bad_input = 2,     ///< the user's file, option or value
  numerical = 3,     ///< singular network, unstable plant, an integrator that gave up
  device = 4,        ///< hardware or communication
  interrupted = 130  ///< stopped by the user; partial results are named in the message
};

/// The one exception of the library: a code, the place it happened and what went wrong.
///
/// `place` says where in the user's terms: a JSON path ("device.json: /motor/resistance"),
/// an element ("damping.0.capacitor"), an instant ("t = 0.0132 s").
/// `message` follows the grammar: what was given, with unit: the rule: what is allowed.
/// what() joins both as "place: message".
class Error : public std::runtime_error {
 public:
  Error(ErrorCode code, std::string place, std::string message);

  ErrorCode code() const { return code_; }
  const std::string& place() const { return place_; }
  const std::string& message() const { return message_; }

 private:
  ErrorCode code_;
  std::string place_;
  std::string message_;
};

}  // namespace gyrator
