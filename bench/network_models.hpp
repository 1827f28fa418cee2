#pragma once

#include "gyrator/circuits/network.hpp"

#include <algorithm>
#include <cmath>
#include <string>

namespace gyrator::bench {

/// Networks of a wanted number of nodes, with values that differ from element to element.
struct SizedNetwork {
  Network network;
  ElementId source;
  NodeId far = ground;
};

namespace detail {

inline double vary(int i, double value) {
  return value * std::pow(10.0, 0.5 * std::sin(1.7 * i + 0.3));
}

}  // namespace detail

/// R and L in series, C to ground; two nodes per section, as a transmission line has them.
inline SizedNetwork make_rlc_ladder(int nodes) {
  SizedNetwork s;
  Network& n = s.network;
  const int u = n.add_input("u");
  NodeId node = n.add_node("start", Domain::electrical);
  s.source = n.add("source", node, ground, VoltageSource{u});
  for (int i = 0; static_cast<int>(n.nodes().size()) + 1 < nodes; ++i) {
    const std::string name = std::to_string(i);
    const NodeId inner = n.add_node("inner" + name, Domain::electrical);
    const NodeId next = n.add_node("node" + name, Domain::electrical);
    n.add("r" + name, node, inner, Resistor{detail::vary(i, 5)});
    n.add("l" + name, inner, next, Inductor{detail::vary(i + 1, 1e-3)});
    n.add("c" + name, next, ground, Capacitor{detail::vary(i + 2, 1e-6)});
    if (i % 10 == 5) {
      n.add("gm" + name, next, ground, VoltageControlledCurrentSource{1e-4, node, ground});
    }
    node = next;
  }
  s.far = node;
  return s;
}

/// A sheet of R between neighbours, with C to ground at every `spacing`-th node: what lies between
/// is algebraic, and every node is coupled to all around it.
inline SizedNetwork make_rc_grid(int nodes, int spacing = 1) {
  SizedNetwork s;
  Network& n = s.network;
  const int u = n.add_input("u");
  const int width = std::max(2, static_cast<int>(std::lround(std::sqrt(nodes))));
  for (int i = 0; i < nodes; ++i) {
    const std::string name = std::to_string(i);
    const NodeId node = n.add_node("node" + name, Domain::electrical);
    if (i == 0) s.source = n.add("source", node, ground, VoltageSource{u});
    if (i % width > 0) {
      n.add("left" + name, node, NodeId{node.index - 1}, Resistor{detail::vary(i, 1e3)});
    }
    if (i >= width) {
      n.add("up" + name, node, NodeId{node.index - width}, Resistor{detail::vary(3 * i, 1e3)});
    }
    if (i > 0 && i % spacing == 0) {
      n.add("c" + name, node, ground, Capacitor{detail::vary(i + 2, 1e-7)});
    }
    if (i % 10 == 5) {
      n.add("gm" + name, node, ground,
            VoltageControlledCurrentSource{1e-4, NodeId{node.index - 1}, ground});
    }
    s.far = node;
  }
  return s;
}

}  // namespace gyrator::bench
