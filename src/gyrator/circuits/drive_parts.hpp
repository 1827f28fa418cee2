#pragma once

#include "gyrator/circuits/drive.hpp"

#include <string>

namespace gyrator {

/// A drive while it is being added to a network: where the next part of each sort goes. Signals are
/// voltages that carry no physical power; none of the parts loads the signal that it reads.
struct DriveParts {
  Network& network;
  DriveNodes nodes;
  NodeId command;  ///< the command with every feedback so far
  DriveTaps taps;
  NodeId winding;  ///< the motor's own terminal, behind what is in series with it
};

/// A first-order lag 1/(1 + s/w_b) of a signal.
NodeId add_lag(Network& network, const std::string& name, NodeId from, double bandwidth_hz);

/// Adds gain * (signal - minus) to the command.
void add_feedback(DriveParts& parts, const std::string& name, double gain, NodeId signal,
                  NodeId minus = ground);

// The stages, in order. Each adds what the damping has in it of that sort, if anything; `name` is
// the damping's, "damping.0".

/// At the port, and feedback from what is sensed there.
void add_mechanical(DriveParts& parts, const Damping& damping, const std::string& name);
/// Between the motor's ammeter and its winding.
void add_in_series(DriveParts& parts, const Damping& damping, const std::string& name);
/// Across the motor terminals.
void add_across(DriveParts& parts, const Damping& damping, const std::string& name);
/// Feedback from terminal voltage and current to the command.
void add_electrical_feedback(DriveParts& parts, const Damping& damping, const std::string& name,
                             double torque_constant);

}  // namespace gyrator
