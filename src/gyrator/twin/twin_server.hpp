#pragma once

#include "gyrator/core/random_stream.hpp"
#include "gyrator/modbus/modbus_server.hpp"
#include "gyrator/twin/twin_bank.hpp"

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

namespace gyrator {

/// What goes wrong on purpose, each with its probability for each request.
struct TwinMoods {
  double busy = 0;     ///< the exception "device busy", and nothing is done
  double late = 0;     ///< the answer comes `late_by` later
  double late_by = 1;  ///< [s] of the wall clock
  double drop = 0;     ///< the connection is closed instead of the answer; RTU: none comes
  double silent = 0;   ///< no answer comes
  double garble = 0;   ///< the answer has one byte wrong, as the check sum or number tells
  double half = 0;     ///< half of the answer comes
  double echo = 0;     ///< the answer to a write names another address
  std::string stuck;   ///< a register that takes every write and keeps its value

  friend bool operator==(const TwinMoods&, const TwinMoods&) = default;
};

/// "busy=0.01,late=0.02:0.8s,drop=0.005,stuck=current_limit". Throws bad_input, the place
/// "misbehave", for an unknown name, with the nearest, and what is no probability.
TwinMoods parse_twin_moods(std::string_view text);

struct TwinTiming {
  /// Whose bytes take their time (wire-1); none: no time on the wire.
  std::optional<SerialAddress> wire;
  double turnaround = 1e-3;    ///< from a request to its answer [s]
  std::optional<double> pace;  ///< as TwinBankOptions::pace
};

/// A bank's timing and moods, for a server. With a pace an answer waits its time; without one the
/// amplifier's time passes by it instead and the answer goes out at once. `bank` must outlive them.
ServerHooks make_twin_hooks(TwinBank& bank, const TwinTiming& timing, const TwinMoods& moods,
                            std::uint64_t seed);

}  // namespace gyrator
