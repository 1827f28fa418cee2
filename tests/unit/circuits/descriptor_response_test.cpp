#include "gyrator/circuits/descriptor_response.hpp"

#include "gyrator/core/error.hpp"

#include <algorithm>
#include <cmath>
#include <complex>
#include <functional>
#include <numbers>
#include <string>
#include <vector>

#include <gtest/gtest.h>

namespace gyrator {
namespace {

using Complex = std::complex<double>;
using Eigen::Index;
using Eigen::MatrixXcd;

constexpr Index always_sparse = 0;
constexpr Index always_dense = 1 << 20;

// 0.01 Hz to 100 kHz, two points a decade, and one off the axis.
std::vector<Complex> sample_points() {
  std::vector<Complex> points{{200, 1000}};
  for (int i = 0; i <= 14; ++i)
    points.emplace_back(0, 2 * std::numbers::pi * 0.01 * std::pow(10, 0.5 * i));
  return points;
}

// A factor between 1/3 and 3 that differs from element to element.
double vary(std::size_t i) {
  return std::pow(10, 0.5 * std::sin(1.7 * static_cast<double>(i) + 0.3));
}

NodeId electrical(Network& network, const std::string& name) {
  return network.add_node(name, Domain::electrical);
}

// A lossy line into a load: every section cuts off above 100 kHz, so that all voltages stay
// within a few decades and can be asked for relative to themselves.
struct Line {
  static constexpr double load = 10;
  std::size_t sections;
  Network network;
  ElementId source;
  NodeId far = ground;

  static double resistance(std::size_t i) { return 0.02 * vary(i); }
  static double inductance(std::size_t i) { return 3e-6 * vary(i + 1); }
  static double capacitance(std::size_t i) { return 3e-8 * vary(i + 2); }

  explicit Line(std::size_t count) : sections(count) {
    const int u = network.add_input("u");
    NodeId node = electrical(network, "start");
    source = network.add("source", node, ground, VoltageSource{u});
    for (std::size_t i = 0; i < sections; ++i) {
      const std::string name = std::to_string(i);
      const NodeId inner = electrical(network, "inner" + name);
      const NodeId next = electrical(network, "node" + name);
      network.add("r" + name, node, inner, Resistor{resistance(i)});
      network.add("l" + name, inner, next, Inductor{inductance(i)});
      network.add("c" + name, next, ground, Capacitor{capacitance(i)});
      node = next;
    }
    far = node;
    network.add("load", far, ground, Resistor{load});
  }

  // The chain matrix [v_1; i_1] = [a b; c d] [v_2; i_2] of all sections, closed by the load.
  struct Chain {
    Complex voltage, admittance;
  };
  Chain respond(Complex s) const {
    Eigen::Matrix2cd chain = Eigen::Matrix2cd::Identity();
    for (std::size_t i = 0; i < sections; ++i) {
      const Complex series = resistance(i) + s * inductance(i);
      const Complex shunt = s * capacitance(i);
      Eigen::Matrix2cd section;
      section << 1.0 + series * shunt, series, shunt, 1.0;
      chain = (chain * section).eval();
    }
    const Eigen::Vector2cd input = chain * Eigen::Vector2cd(1.0, 1 / load);
    return {1.0 / input(0), input(1) / input(0)};
  }
};

TEST(DescriptorResponse, of_a_line_is_the_product_of_its_chain_matrices) {
  // Some hundreds of sections, each worth a few roundings, and the line's own sensitivity to them.
  constexpr double tolerance = 1e-9;
  for (const std::size_t sections : {2u, 10u, 60u, 200u}) {
    const Line line(sections);
    const NetworkEquations equations(line.network);
    DescriptorResponse response(equations.descriptor());
    for (const Complex s : sample_points()) {
      const Line::Chain expected = line.respond(s);
      const MatrixXcd& x = response.solve(s);
      const Complex voltage = (equations.across(line.far).x * x)(0);
      const Complex admittance = -(equations.through(line.source).x * x)(0);
      EXPECT_LE(std::abs(voltage / expected.voltage - 1.0), tolerance) << sections << " at " << s;
      EXPECT_LE(std::abs(admittance / expected.admittance - 1.0), tolerance)
          << sections << " at " << s;
    }
  }
}

// A sheet of resistors over eight decades of values, with capacitors, inductors, a source of every
// controlled kind and two inputs.
Network make_sheet(int width) {
  Network n;
  const int u = n.add_input("u"), j = n.add_input("j");
  std::vector<NodeId> nodes;
  for (int i = 0; i < width * width; ++i) {
    const std::string name = std::to_string(i);
    const auto k = static_cast<std::size_t>(i);
    const NodeId node = electrical(n, "n" + name);
    const double impedance = std::pow(10, 4 * std::sin(0.7 * i));
    if (i % width > 0) n.add("left" + name, node, nodes.back(), Resistor{impedance});
    if (i >= width) {
      n.add("up" + name, node, nodes[static_cast<std::size_t>(i - width)],
            Resistor{impedance * vary(k)});
    }
    if (i % 3 == 0) n.add("c" + name, node, ground, Capacitor{1e-3 / impedance * vary(k)});
    if (i % 7 == 2) n.add("l" + name, node, ground, Inductor{1e-3 * impedance * vary(k)});
    nodes.push_back(node);
  }
  const ElementId source = n.add("source", nodes[0], ground, VoltageSource{u});
  n.add("injection", ground, nodes[3], CurrentSource{j});
  n.add("vcvs", nodes[5], ground, VoltageControlledVoltageSource{-3, nodes[1], nodes[2]});
  n.add("vccs", nodes[6], ground, VoltageControlledCurrentSource{1e-3, nodes[2], ground});
  n.add("ccvs", nodes[7], ground, CurrentControlledVoltageSource{20, source});
  n.add("cccs", nodes[8], ground, CurrentControlledCurrentSource{0.3, source});
  n.add("transformer", nodes[4], ground, Transformer{0.1, nodes[1], ground});
  n.add("gyrator", nodes[2], ground, Gyrator{1e-2, nodes[8], ground});
  return n;
}

TEST(DescriptorResponse, agrees_with_the_plain_dense_solve_on_both_sides_of_its_size_switch) {
  // Both factorizations are backward stable; their difference is the conditioning of the sheet.
  constexpr double tolerance = 1e-10;
  for (const int width : {3, 5, 12}) {
    const Network network = make_sheet(width);
    const NetworkEquations equations(network);
    const auto& d = equations.descriptor();
    const auto nodes = static_cast<Index>(network.nodes().size()) - 1;
    for (const Index sparse_at : {always_sparse, always_dense, DescriptorResponse::sparse_from}) {
      DescriptorResponse response(d, sparse_at);
      for (const Complex s : sample_points()) {
        const MatrixXcd wanted = solve_descriptor(d, s);
        const MatrixXcd& found = response.solve(s);
        for (Index input = 0; input < wanted.cols(); ++input) {
          const auto off = (found - wanted).col(input).eval();
          const auto size = wanted.col(input).eval();
          const auto branches = d.size() - nodes;
          EXPECT_LE(off.head(nodes).norm(), tolerance * size.head(nodes).norm())
              << width << " voltages at " << s;
          EXPECT_LE(off.tail(branches).norm(), tolerance * size.tail(branches).norm())
              << width << " currents at " << s;
        }
      }
    }
  }
}

TEST(DescriptorResponse, solves_sparsely_from_its_size_on_and_densely_below) {
  // The two differ in their last digits, so that equal to the last digit tells which one ran.
  const Complex s(0, 3e5);
  const auto run = [&](const Descriptor& d, Index at) {
    return MatrixXcd(DescriptorResponse(d, at).solve(s));
  };
  for (const std::size_t sections : {5u, 12u}) {
    const NetworkEquations equations(Line(sections).network);
    const auto& d = equations.descriptor();
    const bool sparse = d.size() >= DescriptorResponse::sparse_from;
    EXPECT_EQ(sparse, sections == 12u);
    const MatrixXcd chosen = DescriptorResponse(d).solve(s);
    ASSERT_NE(run(d, always_sparse), run(d, always_dense));
    EXPECT_EQ(chosen, run(d, sparse ? always_sparse : always_dense)) << sections;
  }
}

TEST(DescriptorResponse, is_not_disturbed_by_the_frequencies_before) {
  const NetworkEquations equations(Line(20).network);
  DescriptorResponse response(equations.descriptor());
  const MatrixXcd first = response.solve(Complex(0, 1));
  (void)response.solve(Complex(0, 1e6));
  EXPECT_EQ(response.solve(Complex(0, 1)), first);
}

TEST(DescriptorResponse, without_unknowns_is_empty) {
  const NetworkEquations equations{Network()};
  EXPECT_EQ(DescriptorResponse(equations.descriptor()).solve(1.0).rows(), 0);
}

// ---- singular pencils, in a network of a given size

std::string refusal(std::size_t sections, Index sparse_at, Complex s,
                    const std::function<void(Network&)>& spoil) {
  Network network = Line(sections).network;
  spoil(network);
  const NetworkEquations equations(network);
  DescriptorResponse response(equations.descriptor(), sparse_at);
  try {
    (void)response.solve(s);
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::numerical);
    EXPECT_NE(error.message().find("Hz"), std::string::npos);
    return error.place();
  }
  return "accepted";
}

struct Spoilt {
  const char* what;
  std::function<void(Network&)> spoil;
  std::vector<std::string> any_of;
};

std::vector<Spoilt> make_spoilt() {
  return {
      {"an island whose values cancel only to rounding",
       [](Network& n) {
         const NodeId a = electrical(n, "a"), b = electrical(n, "b"), c = electrical(n, "c");
         n.add("island.ab", a, b, Resistor{3});
         n.add("island.bc", b, c, Resistor{7});
         n.add("island.ca", c, a, Resistor{11});
       },
       {"island.ab, island.ca", "island.ab, island.bc", "island.bc, island.ca"}},
      {"a loop of voltage sources",
       [](Network& n) {
         const NodeId a = electrical(n, "a");
         n.add("battery", a, ground, VoltageSource{});
         n.add("amplifier", a, ground, VoltageSource{0});
       },
       {"battery", "amplifier"}},
      {"a node without elements", [](Network& n) { electrical(n, "bare"); }, {"bare"}},
      {"a lossless resonance met exactly",
       [](Network& n) {
         const NodeId a = electrical(n, "a");
         n.add("tank.l", a, ground, Inductor{0.25});
         n.add("tank.c", a, ground, Capacitor{0.25});
       },
       {"tank.l", "tank.l, tank.c"}},
  };
}

TEST(DescriptorResponse, of_a_singular_network_names_the_elements_at_any_size) {
  for (const Spoilt& spoilt : make_spoilt()) {
    for (const std::size_t sections : {2u, 60u}) {
      for (const Index sparse_at : {always_sparse, always_dense}) {
        const std::string place = refusal(sections, sparse_at, Complex(0, 4), spoilt.spoil);
        EXPECT_TRUE(std::find(spoilt.any_of.begin(), spoilt.any_of.end(), place) !=
                    spoilt.any_of.end())
            << spoilt.what << ": " << place;
      }
    }
  }
}

TEST(DescriptorResponse, a_pencil_beyond_the_numbers_range_is_an_error) {
  EXPECT_NE(refusal(60, always_sparse, Complex(0, 1e308 * 1e10), [](Network&) {}), "accepted");
}

TEST(DescriptorResponse, keeps_a_network_that_hangs_on_a_billionth_of_its_conductances) {
  // Leakage of 1e-9 S holds an island of 1 S; a current of 1e-9 A raises it to 1 V.
  for (const Index sparse_at : {always_sparse, always_dense}) {
    Network n = Line(30).network;
    const int leak = n.add_input("leak");
    const NodeId a = electrical(n, "a"), b = electrical(n, "b");
    n.add("link", a, b, Resistor{1});
    n.add("leakage", b, ground, Conductance{1e-9});
    n.add("feed", ground, a, CurrentSource{leak});
    const NetworkEquations equations(n);
    const MatrixXcd x = DescriptorResponse(equations.descriptor(), sparse_at).solve(Complex(0, 10));
    // Conditioned 1e9: that many roundings.
    EXPECT_LE(std::abs((equations.across(b).x * x)(leak) / 1e9 - 1.0), 1e9 * 1e-15);
  }
}

}  // namespace
}  // namespace gyrator
