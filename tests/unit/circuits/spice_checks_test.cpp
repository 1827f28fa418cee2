#include "gyrator/circuits/spice_checks.hpp"

#include "unit/circuits/spice_bench.hpp"

namespace gyrator {
namespace {

TEST(SpiceChecks, a_node_that_one_terminal_reaches_is_floating) {
  EXPECT_EQ(refuse_lines("R1 a b 1\nR2 a n 1"),
            "test.cir:3: floating node n: only one terminal, of r2, reaches it");
  EXPECT_EQ(refuse_lines("R1 a b 1\nR2 a unconnected-(U1-Pad3) 1"), "accepted")
      << "KiCad says that this is meant";
}

TEST(SpiceChecks, a_node_that_is_only_listened_to_is_floating) {
  EXPECT_EQ(
      refuse_lines("E1 m b n b 2\nG1 a b n b 1\nR1 a m 1"),
      "test.cir:2: floating node n: e1, g1 listen to its voltage, and nothing is connected to "
      "it");
}

TEST(SpiceChecks, a_pin_without_elements_is_refused) {
  EXPECT_EQ(refuse_lines("R1 a 0 1"), "test.cir:1: the pin b of SNUB is connected to nothing");
}

TEST(SpiceChecks, a_part_without_a_path_to_the_terminals_is_named) {
  EXPECT_EQ(refuse_lines("R1 a b 1\nR2 n m 1\nC2 n m 1u"),
            "test.cir:3: no path from node n to the terminals or ground: r2, c2");
  EXPECT_TRUE(mentions(refuse_lines("L1 a b 1m\nL2 n m 1m\nK1 L1 L2 1\nR2 n m 1"),
                       {"no path from node n", "l2, r2"}))
      << "a secondary winding without reference";
}

TEST(SpiceChecks, a_cut_set_of_current_sources_is_named) {
  EXPECT_EQ(refuse_lines("R1 a b 1\nG1 a n a b 1\nG2 n b a b 1\nR2 n n 1"),
            "test.cir:3: a cut-set of current sources: only g1, g2 connect the part with node n to "
            "the rest, and its voltage is undetermined");
  EXPECT_TRUE(
      mentions(refuse_lines("V1 a m\nR1 m b 1\nF1 a n V1 1\nF2 n b V1 1"), {"cut-set", "f1, f2"}));
  // 0 = G1 (v_a - v_b) - G2 v_n determines v_n.
  EXPECT_EQ(refuse_lines("R1 a b 1\nG1 0 n a b 1\nG2 n 0 n x 1\nE1 x 0 n 0 -1"), "accepted");
  EXPECT_EQ(refuse_lines("R1 a b 1\nG1 0 n a b 1\nG2 n 0 n 0 1"), "accepted")
      << "a source across its own control is a conductance";
}

TEST(SpiceChecks, a_loop_of_ideal_voltage_sources_is_named_with_its_members) {
  EXPECT_EQ(refuse_lines("R1 a b 1\nV1 a n\nR2 n m 0\nE1 m a a b 2\n"),
            "test.cir:5: a loop of ideal voltage sources or shorts: v1, r2, e1");
  EXPECT_TRUE(mentions(refuse_lines("R1 a b 1\nV1 a a"), {"test.cir:3", "loop", "v1"}));
  EXPECT_TRUE(mentions(refuse_lines("R1 a b 1\nV1 a n\nH1 n a V1 2"), {"loop", "v1, h1"}));
  EXPECT_TRUE(
      mentions(refuse_lines("R1 a n 1\nR2 n b 1\nX1 a b n ideal_opamp\nX2 b a n ideal_opamp"),
               {"loop", "x1.@1, x2.@1"}));
  EXPECT_EQ(refuse_lines("R1 a b 1\nV1 a n\nL1 n a 1m"), "accepted") << "an inductor is no short";
}

TEST(SpiceChecks, couplings_that_no_windings_have_are_refused) {
  const std::string coils = "L1 a b 1m\nL2 a b 1m\nL3 a b 1m\n";
  EXPECT_EQ(refuse_lines(coils + "K1 L1 L2 L3 -0.5"), "accepted") << "k >= -1/2 for three alike";
  EXPECT_TRUE(
      mentions(refuse_lines(coils + "K1 L1 L2 L3 -0.51"), {"test.cir:5", "negative energy"}));
  EXPECT_TRUE(
      mentions(refuse_lines(coils + "K1 L1 L2 0.9\nK2 L2 L3 0.9\nK3 L1 L3 -0.9"), {"k1, k2, k3"}));
  EXPECT_EQ(refuse_lines(coils + "K1 L1 L2 L3 1"), "accepted");
  EXPECT_TRUE(mentions(refuse_lines(coils + "K1 L1 L2 0.9\nK2 L2 L1 0.9"),
                       {"test.cir:6", "k2 couples two inductors that k1 couples"}));
}

TEST(SpiceChecks, a_port_that_is_shorted_is_refused) {
  const auto port = [](const std::string& lines) {
    return refusal([&] { check_two_terminals(read_lines(lines)); });
  };
  EXPECT_EQ(port("R1 a n 0\nV1 n b\nR2 a b 1"),
            "test.cir:1: the terminals a and b of SNUB are shorted, or held by ideal voltage "
            "sources: v1, r1");
  EXPECT_TRUE(mentions(port("R1 a b 1\nE1 a 0 a b 2"), {"held by ideal voltage sources: e1"}))
      << "the second pin lies at ground";
  EXPECT_TRUE(mentions(port("R1 a b 1\nV1 b 0"), {"loop", "v1"}));
  EXPECT_EQ(port("R1 a b 1"), "accepted");
}

TEST(SpiceChecks, a_damping_circuit_has_two_pins) {
  const SpiceCircuit three =
      parse_subcircuit(".subckt S a b c\nR1 a b 1\nR2 b c 1\n.ends", "test.cir", "s");
  EXPECT_TRUE(mentions(refusal([&] { check_two_terminals(three); }),
                       {"test.cir:1: the subcircuit S has 3 pins", "must have two"}));
}

}  // namespace
}  // namespace gyrator
