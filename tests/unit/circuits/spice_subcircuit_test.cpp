#include "gyrator/circuits/spice_subcircuit.hpp"

#include "gyrator/circuits/reduction.hpp"

#include <cmath>
#include <string>
#include <vector>

#include "unit/circuits/spice_bench.hpp"

namespace gyrator {
namespace {

using Complex = std::complex<double>;

// Some tens of roundings; circuits of op-amps amplify them, which the tests below state.
constexpr double rounding = 1e-13;

SpiceCircuit parse(std::string_view text, std::string_view subckt = {}) {
  return parse_subcircuit(text, "test.cir", subckt);
}

std::string refuse(std::string_view text, std::string_view subckt = {}) {
  return refusal([&] { parse(text, subckt); });
}

TEST(SpiceSubcircuit, a_ladder_has_the_impedance_of_its_continued_fraction) {
  const SpiceCircuit circuit =
      read_lines("R1 a 1 10\nC1 1 b 1u\nR2 1 2 20\nC2 2 b 2u\nR3 2 3 30\nL3 3 b 3m");
  for (const double hz : {10.0, 1e3, 1e5}) {
    const Complex s = s_of(hz);
    const Complex third = 1.0 / (2e-6 * s + 1.0 / (30.0 + 3e-3 * s));
    const Complex expected = 10.0 + 1.0 / (1e-6 * s + 1.0 / (20.0 + third));
    EXPECT_TRUE(is_near(compute_impedance(circuit, s), expected, rounding)) << hz;
  }
}

TEST(SpiceSubcircuit, instances_are_flattened_with_their_path_and_place) {
  const SpiceCircuit circuit = parse(
      "* c\n.subckt OUT p q\nXa p n IN\nXb n q IN\n.ends\n.subckt IN p q\nR1 p q 1\n.ends", "out");
  ASSERT_EQ(circuit.elements.size(), 2U);
  EXPECT_EQ(circuit.elements[0].name, "xa.r1");
  EXPECT_EQ(circuit.elements[1].name, "xb.r1");
  EXPECT_EQ(circuit.elements[1].place, "test.cir:7");
  EXPECT_EQ(circuit.nodes, (std::vector<std::string>{"0", "p", "q", "n"}));
  EXPECT_EQ(circuit.pin_count, 2);
}

TEST(SpiceSubcircuit, parameters_pass_from_instance_to_instance) {
  // R = 2 (g + 1) in the first (r = 3 overridden), 2 (g + 1) default in the second.
  const SpiceCircuit circuit = parse(
      "* c\n.param g=4\n.subckt TOP p q params: r=10\nX1 p n leaf r={r*3}\nX2 n q leaf\n"
      ".subckt leaf a b r={2*h}\n.param h=g+1\nR1 a b {r}\n.ends\n.ends\n",
      "top");
  EXPECT_EQ(std::get<Resistor>(circuit.elements[0].law).resistance, 30);
  EXPECT_EQ(std::get<Resistor>(circuit.elements[1].law).resistance, 10);
}

TEST(SpiceSubcircuit, an_inner_definition_goes_before_an_outer_one_of_its_name) {
  const SpiceCircuit circuit = parse(
      ".subckt TOP p q\nX1 p n s\nX2 n q t\n.subckt s a b\nR1 a b 1\n.ends\n.ends\n"
      ".subckt s a b\nR1 a b 2\n.ends\n.subckt t a b\nX1 a b s\n.ends",
      "TOP");
  EXPECT_EQ(std::get<Resistor>(circuit.elements[0].law).resistance, 1);
  EXPECT_EQ(std::get<Resistor>(circuit.elements[1].law).resistance, 2) << "t stands outside of TOP";
}

TEST(SpiceSubcircuit, a_parameter_of_an_instance_is_one_that_is_used) {
  const std::string leaf = ".subckt leaf a b rload=1\nR1 a b {rload+x}\n.ends\n";
  EXPECT_EQ(
      std::get<Resistor>(parse(leaf + ".subckt T p q\nX1 p q leaf x=2\n.ends", "t").elements[0].law)
          .resistance,
      3)
      << "LTspice passes what the .subckt line does not name";
  EXPECT_TRUE(mentions(refuse(leaf + ".subckt T p q\nX1 p q leaf x=2 rlaod=2\n.ends", "t"),
                       {"test.cir:5: ", "unknown parameter 'rlaod'", "did you mean 'rload'?"}));
  EXPECT_TRUE(mentions(refuse(".subckt leaf a b\n.param r=1\nR1 a b {r}\n.ends\n.subckt T p q\n"
                              "X1 p q leaf r=2\n.ends",
                              "t"),
                       {"test.cir:6", "fixed by a .param line at test.cir:2"}));
}

TEST(SpiceSubcircuit, ground_is_the_same_everywhere) {
  const SpiceCircuit circuit =
      parse(".subckt T p q\nR1 p GND 1\nX1 q s\n.subckt s a\nR1 a 0 1\nR2 a gnd 1\n.ends\n.ends");
  EXPECT_EQ(circuit.nodes.size(), 3U);
  EXPECT_EQ(circuit.elements[0].negative, ground);
  EXPECT_EQ(circuit.elements[2].negative, ground);
}

TEST(SpiceSubcircuit, without_a_name_the_only_subcircuit_is_meant) {
  EXPECT_EQ(parse(".subckt ONE a b\nR1 a b 1\n.ends").name, "ONE");
  EXPECT_EQ(refuse(".subckt ONE a b\n.ends\n.subckt TWO a b\n.ends"),
            "test.cir: the file defines 2 subcircuits: name the one that is meant: ONE, TWO");
  EXPECT_TRUE(mentions(refuse(".subckt ONE a b\nR1 a b 1\n.ends\nX1 1 0 ONE"),
                       {"outside of its subcircuits", "X1 1 0 ONE", "ONE"}));
  EXPECT_EQ(refuse("* nothing"), "test.cir: the file holds no circuit");
}

TEST(SpiceSubcircuit, a_deck_between_two_nodes_needs_no_subcircuit) {
  for (const char* deck : {"title\nR1 n 0 4\nR2 n 0 4", "title\nR1 n m 4\nR2 m n 4",
                           "title\nR1 n 0 4\nG1 n 0 n 0 0.25\n"}) {
    const SpiceCircuit circuit = parse(deck);
    EXPECT_EQ(circuit.pin_count, 2);
    EXPECT_TRUE(is_near(compute_impedance(circuit, s_of(1)), 2, rounding)) << deck;
  }
  const SpiceElement source = parse("title\nR1 n 0 4\nG1 n 0 n 0 0.25").elements[1];
  EXPECT_EQ(source.negative, NodeId{2});
  EXPECT_EQ(std::get<VoltageControlledCurrentSource>(source.law).control_negative, NodeId{2})
      << "its ground is the second terminal, wherever that lies";
  EXPECT_TRUE(mentions(refuse("title\nR1 n m 4\nR2 m 0 4"),
                       {"test.cir: ", "has 3 nodes", ".subckt NAME n1 n2"}));
}

TEST(SpiceSubcircuit, an_unknown_subcircuit_is_named_with_those_there) {
  const std::string file = ".subckt SNUB a b\nR1 a b 1\n.ends\n.subckt T a b\nX1 a b SNUP\n.ends\n";
  EXPECT_EQ(refuse(file, "SNBU"),
            "test.cir: unknown subcircuit 'SNBU': allowed: SNUB, T; did you mean 'SNUB'?");
  EXPECT_TRUE(mentions(refuse(file + ".lib standard.sub", "T"),
                       {"test.cir:5: 'X1 a b SNUP': unknown subcircuit 'SNUP'",
                        "did you mean 'SNUB'?", "opamp", "not found: test.cir:7: standard.sub"}));
  EXPECT_EQ(parse(file + ".lib standard.sub", "SNUB").elements.size(), 1U) << "not needed here";
  EXPECT_EQ(refuse("* c\nR1 a b 1", "S"),
            "test.cir: unknown subcircuit 'S': the file defines none");
}

TEST(SpiceSubcircuit, an_instance_has_as_many_nodes_as_pins) {
  EXPECT_EQ(refuse(".subckt T p q\nX1 p q n s\n.ends\n.subckt s a b\nR1 a b 1\n.ends", "t"),
            "test.cir:2: 'X1 p q n s': gives 3 nodes: the subcircuit s has 2 (a, b)");
  EXPECT_TRUE(mentions(refuse(".subckt T p q\nX1\n.ends"), {"test.cir:2", "is missing"}));
}

TEST(SpiceSubcircuit, a_subcircuit_that_contains_itself_is_refused_with_the_chain) {
  EXPECT_TRUE(
      mentions(refuse(".subckt A p q\nX1 p q B\n.ends\n.subckt B p q\nX2 p q A\n.ends", "a"),
               {"test.cir:5: 'X2 p q A'", "contains itself: ", "A -> B -> A"}));
}

TEST(SpiceSubcircuit, a_few_lines_cannot_ask_for_a_million_elements) {
  std::string text = ".subckt s0 a b\nR1 a b 1\n.ends\n";
  for (int i = 1; i < 30; ++i) {
    const std::string inner = " a b s" + std::to_string(i - 1) + "\n";
    text += ".subckt s" + std::to_string(i) + " a b\nX1" + inner + "X2" + inner + ".ends\n";
  }
  EXPECT_TRUE(mentions(refuse(text, "s29"), {"more than 2000"}));
}

TEST(SpiceSubcircuit, names_are_unique_in_a_subcircuit) {
  EXPECT_EQ(refuse_lines("R1 a b 1\nr1 a b 2"),
            "test.cir:3: the name r1 is there a second time: first at test.cir:2");
}

TEST(SpiceSubcircuit, it_joins_a_network_under_its_prefix) {
  const SpiceCircuit circuit = read_lines("R1 a n 1\nC1 n b 1u\nC2 n unused 0");
  Network network;
  const NodeId terminal = network.add_node("terminal", Domain::electrical);
  add_subcircuit(network, circuit, "damping.0", {terminal, ground});
  EXPECT_TRUE(network.find_element("damping.0.r1").has_value());
  EXPECT_TRUE(network.find_node("damping.0.n").has_value());
  EXPECT_EQ(network.nodes().size(), 3U) << "a node that a capacitor of 0 F alone had is left out";
  EXPECT_EQ(network.element(*network.find_element("damping.0.c1")).negative, ground);
  EXPECT_TRUE(mentions(refusal([&] { add_subcircuit(network, circuit, "x", {terminal}); }),
                       {"x: the subcircuit SNUB has 2 pins and is given 1"}));
}

TEST(SpiceSubcircuit, two_ideal_op_amps_make_an_inductance) {
  // Antoniou: Z = R1 R3 R5 s C4 / R2.
  const SpiceCircuit circuit = read_lines(
      "X1 a m o1 ideal_opamp\nX2 b2 m o2 ideal_opamp\n"
      "R1 a o2 1k\nR2 o2 m 2k\nR3 m o1 3k\nC4 o1 b2 10n\nR5 b2 b 4k");
  for (const double hz : {1.0, 1e3, 1e5}) {
    const Complex s = s_of(hz);
    const Complex expected = 1e3 * 3e3 * 4e3 * 10e-9 / 2e3 * s;
    EXPECT_TRUE(is_near(compute_impedance(circuit, s), expected, 1e-11)) << hz;
  }
}

TEST(SpiceSubcircuit, a_simulated_inductance_resonates_with_a_capacitor_in_the_time_domain) {
  // The inductance above, 60 mH, beside 1 uF: poles at +-j / sqrt(L C), undamped.
  const SpiceCircuit circuit = read_lines(
      "X1 a m o1 ideal_opamp\nX2 b2 m o2 ideal_opamp\nC1 a b 1u\n"
      "R1 a o2 1k\nR2 o2 m 2k\nR3 m o1 3k\nC4 o1 b2 10n\nR5 b2 b 4k");
  Network network;
  const NodeId terminal = network.add_node("terminal", Domain::electrical);
  network.add("drive", ground, terminal, CurrentSource{network.add_input("current")});
  add_subcircuit(network, circuit, "c", {terminal, ground});
  const Reduction reduction = reduce(NetworkEquations(network).descriptor());
  const Eigen::VectorXcd poles = reduction.A.eigenvalues();
  ASSERT_EQ(poles.size(), 2);
  for (int i = 0; i < 2; ++i) {
    EXPECT_NEAR(std::abs(poles(i).imag()), 1 / std::sqrt(60e-3 * 1e-6), 1e-8);
    EXPECT_NEAR(poles(i).real(), 0, 1e-8) << "of 4082 rad/s";
  }
}

TEST(SpiceSubcircuit, the_built_in_op_amp_has_ltspices_pins_and_one_pole) {
  // Inverting input first. Follower driving 1 ohm back into the port through R: with
  // A(s) = Aol / (1 + s Aol / (2 pi GBW)), v_o = v A / (1 + A) and Z = R (1 + A).
  const SpiceCircuit given =
      read_lines("X1 o a o opamp Aol=1k GBW=100k\nR1 a o 1k\n.lib opamp.sub\nR2 o b 1k");
  const SpiceCircuit defaults = read_lines("XU1 o a o opamp\nR1 a o 1k\nR2 o b 1k");
  for (const double hz : {1.0, 1e3, 1e6}) {
    const Complex s = s_of(hz);
    const auto gain = [&](double aol, double gbw) {
      return aol / (1.0 + s * aol / (2 * std::numbers::pi * gbw));
    };
    EXPECT_TRUE(is_near(compute_impedance(given, s), 1e3 * (1.0 + gain(1e3, 1e5)), 1e-9)) << hz;
    EXPECT_TRUE(is_near(compute_impedance(defaults, s), 1e3 * (1.0 + gain(1e5, 1e7)), 1e-9)) << hz;
  }
  for (const SpiceElement& element : given.elements) {
    const bool signal =
        element.name == "x1.g1" || element.name == "x1.r1" || element.name == "x1.c1";
    EXPECT_EQ(element.role, signal ? Role::signal : Role::device) << element.name;
  }
}

TEST(SpiceSubcircuit, a_file_may_bring_its_own_op_amp) {
  const SpiceCircuit circuit =
      read_lines("X1 a b opamp\nR1 a b 4\n.subckt opamp p q\nR1 p q 4\n.ends");
  EXPECT_TRUE(is_near(compute_impedance(circuit, s_of(1)), 2, rounding));
}

TEST(SpiceSubcircuit, parameters_that_an_op_amp_does_not_have_are_refused) {
  EXPECT_TRUE(mentions(refuse_lines("X1 o a o opamp Slew=5\nR1 a o 1\nR2 o b 1"),
                       {"test.cir:2", "unknown parameter 'slew'", "aol, gbw, vmax"}));
}

}  // namespace
}  // namespace gyrator
