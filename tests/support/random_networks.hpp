#pragma once

#include "gyrator/circuits/network.hpp"

#include <cmath>
#include <cstdint>
#include <numbers>
#include <random>
#include <string>

#include <fmt/core.h>

// Seeded random networks of three kinds, one input each: ladders, bridged networks (with coupled
// inductors, transformers, gyrators and current-controlled sources) and op-amp networks (ideal, and
// of finite gain with one pole). Values are drawn over two to four decades around 1 kohm, 10 mH
// and 100 nF. The same seed gives the same network everywhere.

namespace gyrator::testing {

/// Draws that do not depend on the standard library's distributions, which are not portable.
class Draw {
 public:
  explicit Draw(std::uint64_t seed) : engine_(seed * 0x9E3779B97F4A7C15U + 1) {}

  double uniform() { return static_cast<double>(engine_() >> 11U) * 0x1p-53; }
  double between(double low, double high) { return low + (high - low) * uniform(); }
  double decades(double low, double high) { return low * std::pow(high / low, uniform()); }
  int below(int count) { return static_cast<int>(uniform() * count); }

  double resistance() { return decades(10, 1e5); }
  double inductance() { return decades(1e-3, 0.1); }
  double capacitance() { return decades(1e-9, 1e-6); }

 private:
  std::mt19937_64 engine_;
};

/// A network under construction, whose nodes and elements are numbered.
class NetworkDraft {
 public:
  explicit NetworkDraft(std::uint64_t seed) : draw(seed) {}

  NodeId node() { return network.add_node(fmt::format("n{}", ++nodes_), Domain::electrical); }
  ElementId add(NodeId p, NodeId n, ElementLaw law) {
    return network.add(fmt::format("e{}", ++elements_), p, n, law);
  }
  void resistor(NodeId p, NodeId n) { add(p, n, Resistor{draw.resistance()}); }
  void capacitor(NodeId p, NodeId n) { add(p, n, Capacitor{draw.capacitance()}); }
  ElementId inductor(NodeId p, NodeId n) { return add(p, n, Inductor{draw.inductance()}); }

  /// One of: R, R + L, R || C, R + C, R + L + C.
  void impedance(NodeId p, NodeId n) {
    const int kind = draw.below(5);
    if (kind == 2) capacitor(p, n);
    if (kind == 0 || kind == 2) return resistor(p, n);
    const NodeId inner = node();
    resistor(p, inner);
    if (kind == 1) {
      inductor(inner, n);
    } else if (kind == 3) {
      capacitor(inner, n);
    } else {
      const NodeId second = node();
      inductor(inner, second);
      capacitor(second, n);
    }
  }

  /// The input: a voltage source behind a resistor, or a current source beside one.
  NodeId source() {
    const int input = network.add_input("input");
    const NodeId start = node();
    if (draw.below(2) == 0) {
      const NodeId behind = node();
      add(behind, ground, VoltageSource{input});
      resistor(behind, start);
    } else {
      add(ground, start, CurrentSource{input});
      resistor(start, ground);
    }
    return start;
  }

  Draw draw;
  Network network;

 private:
  int nodes_ = 0, elements_ = 0;
};

inline Network make_random_ladder(std::uint64_t seed) {
  NetworkDraft d(seed);
  NodeId at = d.source();
  for (int sections = 2 + d.draw.below(4); sections > 0; --sections) {
    const NodeId next = d.node();
    d.impedance(at, next);
    d.impedance(next, ground);
    at = next;
  }
  d.add(at, ground, Conductance{1 / d.draw.resistance()});
  return d.network;
}

/// Bridged T, lattice, coupled inductors, transformer, gyrator, or current-controlled sources.
inline Network make_random_bridge(std::uint64_t seed) {
  NetworkDraft d(seed);
  const NodeId in = d.source();
  const NodeId out = d.node();
  d.resistor(out, ground);
  switch (d.draw.below(6)) {
    case 0: {  // bridged T
      const NodeId middle = d.node();
      d.impedance(in, middle);
      d.impedance(middle, out);
      d.impedance(middle, ground);
      d.impedance(in, out);
      break;
    }
    case 1: {  // lattice with a load between its floating ends
      const NodeId other = d.node();
      d.impedance(in, out);
      d.impedance(in, other);
      d.impedance(out, other);
      d.impedance(other, ground);
      break;
    }
    case 2: {  // coupled inductors of either sense
      const NodeId second = d.node();
      const double first_inductance = d.draw.inductance();
      const double second_inductance = d.draw.inductance();
      const ElementId a = d.add(in, ground, Inductor{first_inductance});
      const ElementId b = d.add(second, ground, Inductor{second_inductance});
      const double k = d.draw.between(-0.95, 0.95);
      d.add(ground, ground,
            MutualInductance{k * std::sqrt(first_inductance * second_inductance), a, b});
      d.impedance(second, out);
      d.impedance(in, out);
      break;
    }
    case 3: {  // transformer, bridged
      const NodeId second = d.node();
      d.add(in, ground, Transformer{d.draw.between(-3, 3), second, ground});
      d.impedance(second, out);
      d.impedance(in, out);
      break;
    }
    case 4: {  // gyrator, bridged
      const NodeId second = d.node();
      d.add(in, ground, Gyrator{1 / d.draw.resistance(), second, ground});
      d.impedance(second, ground);
      d.impedance(second, out);
      d.impedance(in, out);
      break;
    }
    default: {  // the current of an inductor and of a source, each sensed
      const NodeId middle = d.node();
      const NodeId sensed = d.node();
      const ElementId coil = d.inductor(in, middle);
      const ElementId ammeter = d.add(middle, sensed, VoltageSource{});
      d.impedance(sensed, ground);
      d.add(out, ground, CurrentControlledCurrentSource{d.draw.between(-0.5, 0.5), coil});
      const NodeId driven = d.node();
      d.add(driven, ground, CurrentControlledVoltageSource{d.draw.between(-100, 100), ammeter});
      d.impedance(driven, out);
      d.impedance(in, out);
    }
  }
  return d.network;
}

/// Ideal op-amps (inverting, non-inverting, lossy integrator, Sallen–Key, simulated inductor), and
/// an inverting amplifier of finite gain with one pole.
inline Network make_random_op_amp_network(std::uint64_t seed) {
  NetworkDraft d(seed);
  const NodeId in = d.source();
  const NodeId out = d.node();
  d.resistor(out, ground);
  const auto op_amp = [&](NodeId output, NodeId positive, NodeId negative) {
    d.add(output, ground, IdealOpAmp{positive, negative});
  };
  switch (d.draw.below(6)) {
    case 0: {  // inverting
      const NodeId minus = d.node();
      d.impedance(in, minus);
      d.impedance(minus, out);
      op_amp(out, ground, minus);
      break;
    }
    case 1: {  // non-inverting
      const NodeId minus = d.node();
      d.impedance(minus, ground);
      d.impedance(out, minus);
      d.capacitor(in, ground);
      op_amp(out, in, minus);
      break;
    }
    case 2: {  // lossy integrator
      const NodeId minus = d.node();
      d.resistor(in, minus);
      d.resistor(minus, out);
      d.capacitor(minus, out);
      op_amp(out, ground, minus);
      break;
    }
    case 3: {  // Sallen–Key low-pass of unity gain
      const NodeId a = d.node();
      const NodeId b = d.node();
      d.resistor(in, a);
      d.resistor(a, b);
      d.capacitor(a, out);
      d.capacitor(b, ground);
      op_amp(out, b, out);
      break;
    }
    case 4: {  // Antoniou's simulated inductor, Z_1 Z_3 Z_5 / (Z_2 Z_4) with a capacitor as Z_4
      const NodeId a = d.node();
      const NodeId b = d.node();
      const NodeId c = d.node();
      const NodeId e = d.node();
      const auto r = [&](NodeId p, NodeId n) { d.add(p, n, Resistor{d.draw.decades(500, 5e3)}); };
      r(in, a);
      r(a, b);
      r(b, c);
      d.add(c, e, Capacitor{d.draw.decades(1e-8, 1e-7)});
      r(e, ground);
      op_amp(c, in, b);
      op_amp(a, b, e);
      d.impedance(in, out);
      break;
    }
    default: {  // inverting, of finite gain and one pole: a transconductance into R || C, buffered
      const NodeId minus = d.node();
      const NodeId pole = d.node();
      d.resistor(in, minus);
      d.resistor(minus, out);
      const double gain = d.draw.decades(1e3, 1e6);
      const double corner_hz = d.draw.decades(1, 100);
      d.add(pole, ground, VoltageControlledCurrentSource{gain * 1e-3, minus, ground});
      d.add(pole, ground, Resistor{1e3});
      d.add(pole, ground, Capacitor{1 / (2 * std::numbers::pi * corner_hz * 1e3)});
      d.add(out, ground, VoltageControlledVoltageSource{1, pole, ground});
    }
  }
  return d.network;
}

/// The kinds in turn.
inline Network make_random_network(std::uint64_t seed) {
  switch (seed % 3) {
    case 0:
      return make_random_ladder(seed);
    case 1:
      return make_random_bridge(seed);
    default:
      return make_random_op_amp_network(seed);
  }
}

}  // namespace gyrator::testing
