#pragma once

#include "gyrator/circuits/network.hpp"

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace gyrator {

/// An element of a circuit read from a SPICE file. Nodes and elements are numbered within the
/// circuit; names are in lower case with the path of instances: "x1.r2".
struct SpiceElement {
  std::string name;
  Role role = Role::device;
  NodeId positive, negative;
  ElementLaw law;
  std::string place;  ///< "snubber.cir:12"
};

/// A subcircuit with everything inside of it, flat.
struct SpiceCircuit {
  std::string name;
  std::string place;
  std::vector<std::string> nodes;  ///< "0", then the pins in order, then those inside
  int pin_count = 0;
  std::vector<SpiceElement> elements;  ///< what an element refers to comes before it
};

struct SpiceReadOptions {
  /// A negative resistance becomes a source that delivers power; else it is refused.
  bool allow_negative = false;
};

/// Reads a subcircuit from a SPICE file of LTspice's, KiCad's or ngspice's dialect
/// (docs/netlist.md) and checks that its equations can have a solution.
///
/// An empty `subckt` stands for the only subcircuit that the file defines, or for a file without
/// any whose elements all lie between two nodes. Throws bad_input, with file, line and the text
/// given, for what cannot be read; and, naming nodes and elements, for a floating node, a loop of
/// ideal voltage sources, a part held by current sources only and inductors coupled beyond what
/// energy allows.
SpiceCircuit read_subcircuit(const std::filesystem::path& path, std::string_view subckt,
                             const SpiceReadOptions& options = {});

/// The same for the text of a file; `file` names it and is where included paths begin.
SpiceCircuit parse_subcircuit(std::string_view text, const std::filesystem::path& file,
                              std::string_view subckt, const SpiceReadOptions& options = {});

/// Checks that a circuit can lie across two terminals, its second pin at ground: two pins, neither
/// of them open, no short or ideal voltage source between them. Throws bad_input.
void check_two_terminals(const SpiceCircuit& circuit);

/// What a circuit stands for in a network.
struct SubcircuitUse {
  Domain domain = Domain::electrical;  ///< of the nodes inside
  std::optional<Role> role;            ///< of all elements; none: each its own
};

/// Adds the circuit to a network, its pins at `terminals`, its ground at the network's. Nodes and
/// elements become "<prefix>.<name>". Throws bad_input for another number of terminals than pins.
void add_subcircuit(Network& network, const SpiceCircuit& circuit, const std::string& prefix,
                    const std::vector<NodeId>& terminals, const SubcircuitUse& use = {});

}  // namespace gyrator
