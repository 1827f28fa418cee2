#include "gyrator/circuits/spice_subcircuit.hpp"

#include "gyrator/circuits/spice_builder.hpp"
#include "gyrator/circuits/spice_checks.hpp"
#include "gyrator/circuits/spice_reader.hpp"
#include "gyrator/core/error.hpp"
#include "gyrator/core/text.hpp"

#include <utility>

#include <fmt/core.h>

namespace gyrator {
namespace {

[[noreturn]] void refuse(const std::string& place, std::string message) {
  throw Error(ErrorCode::bad_input, place, std::move(message));
}

std::vector<std::string> list_names(const SpiceDefinition& top) {
  std::vector<std::string> names;
  for (const auto& definition : top.definitions) names.push_back(definition.name);
  return names;
}

// What an empty name stands for: the only subcircuit, or else what stands outside of any.
const SpiceDefinition& find_only_definition(const SpiceDefinition& top) {
  if (top.definitions.empty()) {
    if (top.elements.empty()) refuse(top.place, "the file holds no circuit");
    return top;
  }
  if (!top.elements.empty()) {
    refuse(top.place,
           fmt::format("the file holds elements outside of its subcircuits, such as '{}': "
                       "name the subcircuit that is meant: {}",
                       top.elements.front().text, join(list_names(top))));
  }
  if (top.definitions.size() > 1) {
    refuse(top.place, fmt::format("the file defines {} subcircuits: name the one that is meant: {}",
                                  top.definitions.size(), join(list_names(top))));
  }
  return top.definitions.front();
}

const SpiceDefinition& find_wanted(const SpiceDefinition& top, std::string_view subckt) {
  if (subckt.empty()) return find_only_definition(top);
  if (const auto* found = top.find_definition(subckt)) return *found;
  if (top.definitions.empty()) {
    refuse(top.place, fmt::format("unknown subcircuit '{}': the file defines none", subckt));
  }
  refuse(top.place, describe_unknown_name("subcircuit", subckt, list_names(top)));
}

// The law with its nodes and elements as the network numbers them.
ElementLaw renumber(ElementLaw law, const std::vector<NodeId>& nodes,
                    const std::vector<ElementId>& elements) {
  const auto node = [&](NodeId& id) { id = nodes[static_cast<std::size_t>(id.index)]; };
  const auto element = [&](ElementId& id) { id = elements[static_cast<std::size_t>(id.index)]; };
  std::visit(
      [&](auto& e) {
        if constexpr (requires { e.control_positive; }) {
          node(e.control_positive);
          node(e.control_negative);
        }
        if constexpr (requires { e.second_positive; }) {
          node(e.second_positive);
          node(e.second_negative);
        }
        if constexpr (requires { e.control; }) element(e.control);
        if constexpr (requires { e.first; }) {
          element(e.first);
          element(e.second);
        }
      },
      law);
  return law;
}

// A file without subcircuits has no pins: its only two nodes become them.
void take_nodes_as_pins(SpiceCircuit& circuit) {
  std::vector<bool> used(circuit.nodes.size());
  for (const SpiceElement& element : circuit.elements) {
    used[static_cast<std::size_t>(element.positive.index)] = true;
    used[static_cast<std::size_t>(element.negative.index)] = true;
  }
  const std::size_t nodes = circuit.nodes.size() - (used[0] ? 0 : 1);
  if (nodes != 2) {
    refuse(
        circuit.place,
        fmt::format("the file defines no subcircuit and has {} nodes, so that nothing says which "
                    "are the terminals: put '.subckt NAME n1 n2' before the elements and '.ends' "
                    "behind them",
                    nodes));
  }
  if (used[0]) {
    // Its ground is a terminal like the other, wherever the network will have it.
    circuit.nodes.emplace_back("terminal");
    std::vector<ElementId> same;
    for (SpiceElement& element : circuit.elements) {
      same.push_back({static_cast<int>(same.size())});
      if (element.positive == ground) element.positive = {2};
      if (element.negative == ground) element.negative = {2};
      element.law = renumber(element.law, {{2}, {1}}, same);
    }
  }
  circuit.pin_count = 2;
}

SpiceCircuit build(const SpiceDeck& deck, std::string_view subckt,
                   const SpiceReadOptions& options) {
  const SpiceDefinition& wanted = find_wanted(deck.top, subckt);
  SpiceCircuit circuit = SpiceBuilder(deck, options).build(wanted);
  if (&wanted == &deck.top) take_nodes_as_pins(circuit);
  check_spice_structure(circuit);
  return circuit;
}

}  // namespace

SpiceCircuit read_subcircuit(const std::filesystem::path& path, std::string_view subckt,
                             const SpiceReadOptions& options) {
  return build(read_spice_deck(path), subckt, options);
}

SpiceCircuit parse_subcircuit(std::string_view text, const std::filesystem::path& file,
                              std::string_view subckt, const SpiceReadOptions& options) {
  return build(parse_spice_deck(text, file), subckt, options);
}

void check_two_terminals(const SpiceCircuit& circuit) {
  if (circuit.pin_count != 2) {
    refuse(circuit.place, fmt::format("the subcircuit {} has {} pins: across two terminals it must "
                                      "have two (ground, 0, is there besides)",
                                      circuit.name, circuit.pin_count));
  }
  check_spice_port(circuit);
}

void add_subcircuit(Network& network, const SpiceCircuit& circuit, const std::string& prefix,
                    const std::vector<NodeId>& terminals, const SubcircuitUse& use) {
  if (terminals.size() != static_cast<std::size_t>(circuit.pin_count)) {
    refuse(prefix, fmt::format("the subcircuit {} has {} pins and is given {} terminals",
                               circuit.name, circuit.pin_count, terminals.size()));
  }
  // A node that no element holds (of a capacitor of 0 F) would leave the equations singular.
  std::vector<bool> used(circuit.nodes.size());
  for (const SpiceElement& element : circuit.elements) {
    used[static_cast<std::size_t>(element.positive.index)] = true;
    used[static_cast<std::size_t>(element.negative.index)] = true;
  }
  std::vector<NodeId> nodes{ground};
  nodes.insert(nodes.end(), terminals.begin(), terminals.end());
  for (std::size_t i = nodes.size(); i < circuit.nodes.size(); ++i) {
    nodes.push_back(used[i] ? network.add_node(prefix + "." + circuit.nodes[i], use.domain)
                            : ground);
  }
  std::vector<ElementId> elements;
  for (const SpiceElement& element : circuit.elements) {
    elements.push_back(network.add(
        prefix + "." + element.name, nodes[static_cast<std::size_t>(element.positive.index)],
        nodes[static_cast<std::size_t>(element.negative.index)],
        renumber(element.law, nodes, elements), use.role.value_or(element.role)));
  }
}

}  // namespace gyrator
