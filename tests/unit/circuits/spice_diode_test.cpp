#include "gyrator/circuits/nonlinear_law.hpp"
#include "gyrator/circuits/operating_point.hpp"

#include <cmath>
#include <numbers>
#include <string>

#include "unit/circuits/spice_bench.hpp"

namespace gyrator {
namespace {

constexpr double Vt = 1.380649e-23 * 300.15 / 1.602176634e-19;  // k T/q at 27 degC [V]
constexpr double gmin = 1e-12;                                  // beside every diode [S]
// Newton's last step is squared: what is left is rounding, through exp(v/V_e) some tens of it.
constexpr double rounding = 1e-12;

// The circuit at rest, its pin b at ground and a open.
class AtRest {
 public:
  explicit AtRest(const std::string& lines) {
    const SpiceCircuit circuit = read_lines(lines);
    add_subcircuit(network_, circuit, "c", {network_.add_node("c.a", Domain::electrical), ground});
    point_ = find_operating_point(network_);
  }
  double voltage(const std::string& node) const {
    return point_.unknowns(network_.find_node("c." + node)->index - 1);
  }

 private:
  Network network_;
  OperatingPoint point_;
};

const Diode& diode_of(const SpiceCircuit& circuit, std::size_t index = 0) {
  return std::get<Diode>(circuit.elements.at(index).law);
}

TEST(SpiceDiode, a_diode_behind_a_resistor_rests_where_both_carry_the_same_current) {
  const AtRest c(
      "V1 s b 5\nR1 s a 1k\nD1 a b 1N4148\n"
      ".model 1N4148 D(Is=2.52n Rs=.568 N=1.752 Iave=200m Vpk=75 mfg=OnSemi type=silicon)");
  const double i = (5 - c.voltage("a")) / 1e3;
  const double v = c.voltage("d1.rs");
  EXPECT_NEAR(c.voltage("a") - v, 0.568 * i, rounding);
  EXPECT_NEAR(2.52e-9 * std::expm1(v / (1.752 * Vt)) + gmin * v, i, rounding * i);
  EXPECT_GT(i, 4e-3);
}

TEST(SpiceDiode, a_bias_current_sets_the_slope_that_small_signals_meet) {
  for (const double bias : {1e-6, 1e-3, 0.1}) {
    const std::string lines =
        "I1 b a " + std::to_string(bias * 1e6) + "u AC 1\nD1 a b D\n.model D D";
    const double through = bias - gmin * AtRest(lines).voltage("a");
    EXPECT_TRUE(
        is_near(compute_impedance(read_lines(lines), s_of(100)), Vt / (through + 1e-14), rounding))
        << bias;
  }
}

TEST(SpiceDiode, a_bias_voltage_is_there_at_rest_and_no_signal) {
  EXPECT_NEAR(AtRest("V1 a n DC {2+3} AC 1\nR1 n b 1k\nR2 a b 4k").voltage("n"), -1, rounding);
  EXPECT_TRUE(is_near(compute_impedance(read_lines("V1 a n 5\nR1 n b 1k"), s_of(1)), 1e3, 1e-13));
}

TEST(SpiceDiode, the_current_of_a_constant_source_may_control) {
  // 5 V over 1 k; its current, mirrored into 200 ohm from b to a, which is below ground.
  const AtRest c("V1 s b 5\nR1 s b 1k\nF1 a b V1 2\nR2 a b 200");
  EXPECT_NEAR(c.voltage("a"), 200 * 2 * 5e-3, rounding);
}

TEST(SpiceDiode, models_are_read_in_every_form) {
  for (const char* lines :
       {"D1 a b x\n.model X D(Is=1p N=2)", "d1 A B X\n.MODEL x d IS=1e-12 n=2",
        "D1 a b X\n.model X D ( n = 2 , is = {1e-12} )", "D1 a b X off\n.model X D(Is=1p\n+ N=2)",
        "D1 a b X 2\n.model X D(Is=.5p N=2 Cjo=0 Tt=0 M=.4 Vj=.8 Ibv=1u Xti=3 Eg=1.11)",
        "D1 a b X area=0.5 m=4\n.model X D(Is=.5p N=2)",
        ".param k=1\nD1 a b X\n.model X D(Is={k*1p} N={2*k})",
        "X1 a b inner k=2\n.subckt inner p q k=1\nD1 p q X\n.model X D(Is=1p N={k})\n.ends"}) {
    const SpiceCircuit circuit = read_lines(lines);
    ASSERT_EQ(circuit.elements.size(), 1U) << lines;
    EXPECT_NEAR(diode_of(circuit).saturation_current, 1e-12, 1e-26) << lines;
    EXPECT_DOUBLE_EQ(diode_of(circuit).emission_voltage, 2 * Vt) << lines;
  }
  const Diode plain = diode_of(read_lines("D1 a b D\n.model D D"));
  EXPECT_EQ(plain.saturation_current, 1e-14);
  EXPECT_DOUBLE_EQ(plain.emission_voltage, Vt);
  const SpiceCircuit wide = read_lines("D1 a b X 4\n.model X D(Rs=2)");
  EXPECT_EQ(std::get<Resistor>(wide.elements.at(0).law).resistance, 0.5);
}

TEST(SpiceDiode, the_nearest_model_around_is_meant) {
  const std::string text =
      ".model X D(N=3)\n.subckt S a b\n.model X D(N=2)\nD1 a b X\nX1 a b T\n.ends\n"
      ".subckt T a b\nD1 a b X\n.ends\n";
  const SpiceCircuit circuit = parse_subcircuit(text, "test.cir", "S");
  EXPECT_DOUBLE_EQ(diode_of(circuit, 0).emission_voltage, 2 * Vt);
  EXPECT_DOUBLE_EQ(diode_of(circuit, 1).emission_voltage, 3 * Vt) << "T is not inside of S";
}

TEST(SpiceDiode, an_unknown_model_is_refused_with_the_nearest_one) {
  EXPECT_TRUE(mentions(refuse_lines("D1 a b 1N4184\n.model 1N4148 D\n.lib standard.dio"),
                       {"test.cir:2: 'D1 a b 1N4184': unknown .model '1N4184'", "'1N4148'",
                        "not found: test.cir:4: standard.dio"}));
  EXPECT_TRUE(mentions(refuse_lines("D1 a b D"), {"test.cir:2", "there is no .model D"}));
  EXPECT_TRUE(mentions(refuse_lines("D1 a b Q\n.model Q NPN(Is=1)"), {"test.cir:3", "'npn'"}));
  EXPECT_TRUE(mentions(refuse_lines("D1 a b D\n.model D D\n.model d D(N=2)"),
                       {"test.cir:4: the model d is defined a second time: first at test.cir:3"}));
  EXPECT_TRUE(mentions(refuse_lines("D1 a b D 0\n.model D D"), {"an area of 0"}));
  EXPECT_TRUE(mentions(refuse_lines("D1 a b D temp=50\n.model D D"), {"'temp'"}));
}

TEST(SpiceDiode, what_would_make_another_circuit_of_it_is_refused_by_name) {
  const auto refuse = [](const std::string& given) {
    return refuse_lines("D1 a b X\n.model X D(" + given + ")");
  };
  EXPECT_EQ(refuse("Cjo=4p"),
            "test.cir:3: '.model X D(Cjo=4p)': cjo: a diode's junction capacitance is not read: 0 "
            "leaves it out");
  EXPECT_TRUE(mentions(refuse("Tt=20n"), {"tt", "stored charge"}));
  EXPECT_TRUE(mentions(refuse("Bv=75"), {"bv", "breakdown"}));
  EXPECT_TRUE(mentions(refuse("Ron=1 Vfwd=.4"), {"piecewise linear"}));
  EXPECT_TRUE(mentions(refuse("Tnom=50"), {"tnom = 50 degC", "27"}));
  EXPECT_TRUE(mentions(refuse("Rss=1"), {"'rss'", "did you mean 'rs'?"}));
  EXPECT_TRUE(mentions(refuse("Is=0"), {"is = 0: must be positive"}));
  EXPECT_TRUE(mentions(refuse("N=-1"), {"n = -1: must be positive"}));
  EXPECT_TRUE(mentions(refuse("Rs=-1"), {"rs = -1: must not be negative"}));
}

TEST(SpiceDiode, a_constant_source_answers_for_loops_and_cut_sets_like_any_other) {
  EXPECT_TRUE(mentions(refuse_lines("R1 a b 1\nV1 a n 5\nV2 a n 0\nR2 n b 1"), {"loop", "v1, v2"}));
  EXPECT_TRUE(mentions(refuse_lines("R1 a b 1\nI1 a n 1\nI2 n b 1"), {"cut-set", "i1, i2"}));
  EXPECT_TRUE(mentions(refusal([] { check_two_terminals(read_lines("R1 a b 1\nV1 a b 5")); }),
                       {"shorted, or held", "v1"}));
}

TEST(SpiceDiode, an_op_amp_follows_up_to_its_limit) {
  const auto follow = [](const std::string& limit, double input) {
    return AtRest("V1 s b " + std::to_string(input) + "\nX1 o s o opamp Aol=1k " + limit +
                  "\nR1 o a 1k\nR2 a b 1k")
        .voltage("o");
  };
  const double closed = 1e3 / (1 + 1e3);
  for (const double sign : {1.0, -1.0}) {
    EXPECT_NEAR(follow("", sign * 20), sign * 20 * closed, 20 * rounding);
    EXPECT_NEAR(follow("Vmax=12", sign * 20), sign * 12, 12 * rounding);
    // Below it, the pole's clamp leaks 1e-6 of the pole's current.
    EXPECT_NEAR(follow("Vmax=12", sign * 5), sign * 5 * closed, 5 * 1e-6);
  }
  EXPECT_TRUE(mentions(refuse_lines("X1 o a o opamp Vmax=-1\nR1 o b 1"), {"Vmax of -1 V"}));
  for (const SpiceElement& element : read_lines("X1 o a o opamp\nR1 o b 1").elements) {
    EXPECT_FALSE(is_nonlinear(element.law)) << "without a limit it is linear: " << element.name;
  }
}

}  // namespace
}  // namespace gyrator
