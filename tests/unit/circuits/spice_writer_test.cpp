#include "gyrator/circuits/spice_writer.hpp"

#include "gyrator/circuits/descriptor.hpp"
#include "gyrator/core/error.hpp"

#include <algorithm>
#include <complex>
#include <numbers>
#include <set>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "support/ngspice_comparison.hpp"

namespace gyrator {
namespace {

using Complex = std::complex<double>;

// A 10 x 10 solve of well scaled numbers on either side.
constexpr double rounding = 1e-11;

// Nodes p, n, c, d, each held by a source of its own behind a resistor of its own.
struct Fixture {
  Network network;
  NodeId p, n, c, d;

  Fixture() : p(held("p", 1.0)), n(held("n", 1.7)), c(held("c", 0.6)), d(held("d", 2.3)) {}

  NodeId held(const std::string& name, double resistance) {
    const NodeId behind = network.add_node("behind." + name, Domain::electrical);
    const NodeId node = network.add_node(name, Domain::electrical);
    network.add("source." + name, behind, ground, VoltageSource{network.add_input(name)});
    network.add("hold." + name, behind, node, Resistor{resistance});
    return node;
  }

  void expect_agreement() const {
    EXPECT_LE(testing::compare_with_ngspice(network, {.from_hz = 1, .to_hz = 1e4}).response,
              rounding);
  }
};

TEST(SpiceWriter, resistor_and_conductance_are_the_same_in_ngspice) {
  Fixture f;
  f.network.add("R", f.p, f.n, Resistor{4.7});
  f.network.add("G", f.c, f.d, Conductance{0.3});
  f.expect_agreement();
}

TEST(SpiceWriter, inductor_and_capacitor_are_the_same_in_ngspice) {
  Fixture f;
  f.network.add("L", f.p, f.n, Inductor{2e-3});
  f.network.add("C", f.c, f.d, Capacitor{3e-4});
  f.expect_agreement();
}

TEST(SpiceWriter, an_ammeter_and_a_current_source_are_the_same_in_ngspice) {
  Fixture f;
  f.network.add("ammeter", f.p, f.n, VoltageSource{});
  f.network.add("I", f.c, f.d, CurrentSource{f.network.add_input("current")});
  f.expect_agreement();
}

TEST(SpiceWriter, voltage_controlled_sources_are_the_same_in_ngspice) {
  Fixture f;
  f.network.add("E", f.p, f.n, VoltageControlledVoltageSource{-3.2, f.c, f.d});
  f.network.add("G", f.c, f.n, VoltageControlledCurrentSource{0.8, f.d, f.p});
  f.expect_agreement();
}

// Every element that carries an unknown current can be sensed.
TEST(SpiceWriter, current_controlled_sources_are_the_same_in_ngspice_whatever_they_sense) {
  const auto with_control = [](const ElementLaw& law) {
    Fixture f;
    const ElementId control = f.network.add("control", f.p, f.n, law);
    f.network.add("H", f.c, ground, CurrentControlledVoltageSource{1.9, control});
    f.network.add("F", f.d, f.p, CurrentControlledCurrentSource{-0.7, control});
    f.expect_agreement();
  };
  with_control(VoltageSource{});
  with_control(VoltageSource{1});
  with_control(Inductor{2e-3});
  with_control(VoltageControlledVoltageSource{0.4, NodeId{6}, NodeId{8}});
  with_control(Transformer{0.4, NodeId{8}, ground});
}

TEST(SpiceWriter, a_current_controlled_voltage_source_can_itself_be_sensed) {
  Fixture f;
  const ElementId first = f.network.add("first", f.p, f.n, Inductor{1e-3});
  const ElementId second =
      f.network.add("second", f.c, ground, CurrentControlledVoltageSource{1.9, first});
  f.network.add("third", f.d, ground, CurrentControlledCurrentSource{2.5, second});
  f.expect_agreement();
}

TEST(SpiceWriter, transformer_and_gyrator_are_the_same_in_ngspice) {
  for (const double factor : {0.4, -1.8}) {
    Fixture transformer;
    transformer.network.add("T", transformer.p, transformer.n,
                            Transformer{factor, transformer.c, transformer.d});
    transformer.expect_agreement();
    Fixture gyrator;
    gyrator.network.add("Y", gyrator.p, gyrator.n, Gyrator{factor, gyrator.c, gyrator.d});
    gyrator.expect_agreement();
  }
}

TEST(SpiceWriter, coupled_inductors_are_the_same_in_ngspice_for_either_sense_and_full_coupling) {
  for (const double k : {0.6, -0.35, 1.0}) {
    Fixture f;
    const ElementId first = f.network.add("L1", f.p, f.n, Inductor{2e-3});
    const ElementId second = f.network.add("L2", f.c, f.d, Inductor{5e-4});
    f.network.add("M", ground, ground, MutualInductance{k * 1e-3, first, second});
    f.expect_agreement();
  }
}

TEST(SpiceWriter, an_ideal_op_amp_is_exact_in_ngspice) {
  // Inverting, -Z_f/Z_i with Z_f = R_f || C: to 1e-9 of the closed form at every frequency.
  constexpr double R_i = 1e3, R_f = 47e3, C = 1e-9;
  Network network;
  const NodeId in = network.add_node("in", Domain::electrical);
  const NodeId minus = network.add_node("minus", Domain::electrical);
  const NodeId out = network.add_node("out", Domain::electrical);
  network.add("source", in, ground, VoltageSource{network.add_input("v")});
  network.add("R_i", in, minus, Resistor{R_i});
  network.add("R_f", minus, out, Resistor{R_f});
  network.add("C", minus, out, Capacitor{C});
  network.add("amplifier", out, ground, IdealOpAmp{ground, minus});
  const auto tables = run_ngspice(
      testing::write_comparison_deck(network, {.from_hz = 1, .to_hz = 1e6}), {"response.data"});
  for (std::size_t row = 0; row < tables[0].columns[0].size(); ++row) {
    const Complex s(0, 2 * std::numbers::pi * tables[0].columns[0][row]);
    const Complex expected = -R_f / (1.0 + s * R_f * C) / R_i;
    const Complex found(tables[0].columns[5][row], tables[0].columns[6][row]);
    EXPECT_LE(std::abs(found - expected), 1e-9 * std::abs(expected));
  }
}

TEST(SpiceWriter, an_op_amp_between_floating_outputs_is_the_same_in_ngspice) {
  Fixture f;
  f.network.add("feedback", f.p, f.c, Resistor{3.3});
  f.network.add("amplifier", f.p, f.n, IdealOpAmp{f.d, f.c});
  f.expect_agreement();
}

TEST(SpiceWriter, names_are_legal_and_unique_regardless_of_case) {
  Network network;
  const NodeId a = network.add_node("Node.1", Domain::electrical);
  const NodeId b = network.add_node("node_1", Domain::electrical);
  const NodeId gnd = network.add_node("gnd", Domain::mechanical);
  const NodeId odd = network.add_node("0; µ\n*", Domain::electrical);
  network.add("R.x", a, b, Resistor{1});
  network.add("r_x", b, gnd, Resistor{1});
  network.add("R x\n.end", gnd, odd, Conductance{1e-4});
  network.add("C", odd, ground, Capacitor{1e-5});
  const SpiceNetlist netlist = write_spice_netlist(network);
  EXPECT_EQ(netlist.nodes[0], "0");
  std::set<std::string> names(netlist.nodes.begin(), netlist.nodes.end());
  names.insert(netlist.devices.begin(), netlist.devices.end());
  EXPECT_EQ(names.size(), 5U + 4U);
  EXPECT_EQ(netlist.nodes[1], "n_node_1");
  EXPECT_EQ(netlist.nodes[2], "n_node_1__2");
  EXPECT_EQ(netlist.devices[0], "r_r_x");
  for (const std::string& name : names) {
    EXPECT_EQ(name.find_first_not_of("abcdefghijklmnopqrstuvwxyz0123456789_"), std::string::npos);
  }
  // Four nodes and four elements, a line each: none of the names broke one.
  EXPECT_EQ(std::count(netlist.lines.begin(), netlist.lines.end(), '\n'), 4 + 4);
  EXPECT_NE(netlist.lines.find("R.x [ohm]"), std::string::npos);
  EXPECT_NE(netlist.lines.find("a damper of 0.0001 N.m.s/rad"), std::string::npos);
}

TEST(SpiceWriter, a_prefix_keeps_two_networks_apart_in_one_netlist) {
  Network network;
  const NodeId a = network.add_node("a", Domain::electrical);
  network.add("R", a, ground, Resistor{1});
  SpiceOptions one;
  one.prefix = "1";
  SpiceOptions two;
  two.prefix = "2";
  const SpiceNetlist first = write_spice_netlist(network, one);
  const SpiceNetlist second = write_spice_netlist(network, two);
  EXPECT_NE(first.nodes[1], second.nodes[1]);
  EXPECT_NE(first.devices[0], second.devices[0]);
}

TEST(SpiceWriter, numbers_have_no_suffix_that_spice_would_misread) {
  Network network;
  const NodeId a = network.add_node("a", Domain::electrical);
  network.add("R", a, ground, Resistor{1.0 / 3});
  network.add("C", a, ground, Capacitor{2.2e-3});
  SpiceOptions options;
  options.initial = {0, -0.125};
  const std::string lines = write_spice_netlist(network, options).lines;
  EXPECT_NE(lines.find("r_r n_a 0 0.3333333333333333 ;"), std::string::npos) << lines;
  EXPECT_NE(lines.find("c_c n_a 0 0.0022 ic=-0.125 ;"), std::string::npos) << lines;
}

TEST(SpiceWriter, laws_that_bend_are_formulas_of_their_pieces) {
  Network network;
  const NodeId a = network.add_node("a", Domain::electrical);
  const NodeId b = network.add_node("b", Domain::electrical);
  network.add("clamp", a, b, VoltageClamp{2, 0.5});
  network.add("brake", a, ground, SaturatingConductance{3, 4});
  network.add("limiter", a, b, CurrentLimiter{5, 6});
  network.add("e", a, ground, LimitedVoltageControlledVoltageSource{7, 8, a, b});
  network.add("g", a, ground, LimitedVoltageControlledCurrentSource{-9, 10, ground, b});
  network.add("bias", a, ground, ConstantVoltageSource{11});
  network.add("offset", a, b, ConstantCurrentSource{-12});
  network.add("d", a, b, Diode{1e-9, 2 * 1.38064852e-23 * 300.15 / 1.6021766208e-19});
  const SpiceNetlist netlist = write_spice_netlist(network);
  for (const char* line :
       {"\nb_clamp n_a n_b i=2*(max(v(n_a,n_b)-2,0)+min(v(n_a,n_b)+2,0)) ;",
        "\nb_brake n_a 0 i=max(-4,min(4,3*v(n_a,0))) ;",
        "\nb_limiter n_limiter_inner n_b v=6*(max(i(v_limiter_ammeter)-5,0)+"
        "min(i(v_limiter_ammeter)+5,0)) ;",
        "\nb_e n_a 0 v=max(-8,min(8,7*v(n_a,n_b))) ;",
        "\nb_g n_a 0 i=max(-10,min(10,-9*(-v(n_b)))) ;", "\nv_bias n_a 0 DC 11 ;",
        "\ni_offset n_a n_b DC -12 ;", "\nd_d n_a n_b m_d ;", "\n.model m_d d(is=1e-09 n=2)\n"}) {
    EXPECT_NE(netlist.lines.find(line), std::string::npos) << line << " in\n" << netlist.lines;
  }
  EXPECT_EQ(netlist.ammeters[5], "v_bias");
  EXPECT_EQ(netlist.release, "") << "nothing is held unless it is asked for";
}

}  // namespace
}  // namespace gyrator
