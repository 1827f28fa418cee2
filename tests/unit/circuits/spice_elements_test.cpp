#include "gyrator/circuits/spice_elements.hpp"

#include <cmath>
#include <string>
#include <vector>

#include "unit/circuits/spice_bench.hpp"

namespace gyrator {
namespace {

using Complex = std::complex<double>;

// Networks of fewer than ten elements of like size: some tens of roundings of 1e-16.
constexpr double rounding = 1e-13;
// A part of 1e-5 of the others' impedance takes five of the sixteen digits.
constexpr double small_parts = 1e-11;

// The impedance of the lines between a and b is that of the formula, from 1 Hz to 100 kHz.
template <class Formula>
void expect_impedance(const std::string& lines, Formula formula,
                      const SpiceReadOptions& options = {}, double tolerance = rounding) {
  const SpiceCircuit circuit = read_lines(lines, options);
  for (const double hz : {1.0, 30.0, 1e3, 1e5}) {
    const Complex s = s_of(hz);
    EXPECT_TRUE(is_near(compute_impedance(circuit, s), formula(s), tolerance))
        << lines << " at " << hz << " Hz";
  }
}

Complex parallel(Complex x, Complex y) {
  return x * y / (x + y);
}

TEST(SpiceElements, resistors_capacitors_and_inductors_take_their_value_in_every_form) {
  for (const char* line :
       {"R1 a b 1k", "r1 A B 1K tol=1 pwr=0.5", "R1 a b R=1k", "R1 a b {2*500}", "R1 a b '0.5k*2'",
        "R1 (a, b) 1kOhm", "R1 a b r={1k}", "R1 a b 4k m=4"}) {
    expect_impedance(line, [](Complex) { return Complex(1e3); });
  }
  for (const char* line : {"C1 a b 10u", "C1 a b 10\u00B5F V=25 Irms=2 mfg=\"W\u00FCrth\" ic=0",
                           "C1 a b C=10u", "C1 a b 5u M=2"}) {
    expect_impedance(line, [](Complex s) { return 1.0 / (10e-6 * s); });
  }
  for (const char* line : {"L1 a b 1m", "L1 a b 1mH Ipk=3", "L1 a b L={1/1000}", "L1 a b 3m m=3"}) {
    expect_impedance(line, [](Complex s) { return 1e-3 * s; });
  }
}

TEST(SpiceElements, the_losses_of_a_capacitor_are_elements_of_their_own) {
  const auto both = [](Complex s) { return parallel(1e3, 0.1 + 1e-3 * s + 1.0 / (10e-6 * s)); };
  expect_impedance("C1 a b 10u Rser=0.1 Lser=1m Rpar=1k", both, {}, small_parts);
  const auto shunted = [](Complex s) {
    return parallel(1.0 / (1e-9 * s), parallel(2, 1e-3 * s) + 1.0 / (10e-6 * s)) / 2.0;
  };
  expect_impedance("C1 a b 10u Lser=1m RLshunt=2 Cpar=1n m=2", shunted, {}, small_parts);
  expect_impedance("C1 a b 0 Rser=1 Rpar=1k", [](Complex) { return Complex(1e3); });
}

TEST(SpiceElements, the_losses_of_an_inductor_are_elements_of_their_own) {
  expect_impedance("L1 a b 1m Rser=0.2 Rpar=1k Cpar=1n", [](Complex s) {
    return parallel(parallel(1e3, 1.0 / (1e-9 * s)), 0.2 + 1e-3 * s);
  });
}

TEST(SpiceElements, zero_is_a_short_for_resistance_and_inductance_and_nothing_for_capacitance) {
  expect_impedance("R1 a n 0\nL1 n m 0\nR2 m b 5\nC1 m b 0", [](Complex) { return Complex(5); });
  const SpiceCircuit circuit = read_lines("R1 a n 0\nL1 n m 0\nR2 m b 5\nC1 m b 0");
  EXPECT_EQ(circuit.elements.size(), 3U);
  EXPECT_TRUE(std::holds_alternative<VoltageSource>(circuit.elements[0].law));
}

TEST(SpiceElements, a_negative_resistance_needs_permission_and_is_a_source) {
  EXPECT_EQ(refuse_lines("R1 a b 1k\nR2 a b {-2*5}"),
            "test.cir:3: 'R2 a b {-2*5}': resistance of r2 is -10 ohm: a negative component value "
            "supplies energy and has to be allowed explicitly (\"allow_negative\": true)");
  const SpiceReadOptions allowed{.allow_negative = true};
  expect_impedance(
      "R1 a n 15\nR2 n b -10", [](Complex) { return Complex(5); }, allowed);
  EXPECT_TRUE(std::holds_alternative<VoltageControlledCurrentSource>(
      read_lines("R1 a n 15\nR2 n b -10", allowed).elements[1].law));
  EXPECT_TRUE(mentions(refuse_lines("C1 a b -1u", allowed), {"test.cir:2", "c1 is -1e-06 F"}));
  EXPECT_TRUE(mentions(refuse_lines("L1 a b -1u", allowed), {"test.cir:2", "l1 is -1e-06 H"}));
  EXPECT_TRUE(
      mentions(refuse_lines("C1 a b 1u Rser=-1", allowed), {"rser = -1", "not be negative"}));
  EXPECT_TRUE(mentions(refuse_lines("R1 a b 1 m=0"), {"m = 0", "must be positive"}));
}

TEST(SpiceElements, coupled_inductors_share_their_flux) {
  // Short-circuited secondary: Z = s L1 (1 - k^2); series aiding: L1 + L2 + 2 M.
  expect_impedance("L1 a b 4m\nL2 n b 1m\nV1 n b 0\nK1 L1 L2 0.5",
                   [](Complex s) { return 4e-3 * 0.75 * s; });
  expect_impedance("L1 a n 4m\nL2 n b 1m\nK1 L1 L2 K=0.5", [](Complex s) { return 7e-3 * s; });
  expect_impedance("L1 a n 4m\nL2 n b 1m\nK1 L1 L2 -0.5", [](Complex s) { return 3e-3 * s; });
}

TEST(SpiceElements, one_coupling_may_join_many_inductors) {
  // Three alike in series: 3 L + 6 k L.
  expect_impedance("K1 L1 L2 L3 0.98\nL1 a n 1m\nL2 n m 1m\nL3 m b 1m",
                   [](Complex s) { return (3 + 6 * 0.98) * 1e-3 * s; });
}

TEST(SpiceElements, a_coupling_names_two_inductors_and_at_most_one) {
  const std::string coils = "L1 a b 1m\nL2 a b 1m\n";
  EXPECT_EQ(refuse_lines(coils + "K1 L1 L2 1.1"),
            "test.cir:4: 'K1 L1 L2 1.1': a coupling of 1.1: must be from -1 to 1");
  EXPECT_TRUE(mentions(refuse_lines(coils + "K1 L1 L3 1"),
                       {"test.cir:4: ", "unknown inductor", "'l3'", "l1, l2"}));
  EXPECT_TRUE(mentions(refuse_lines(coils + "K1 L1 L1 1"), {"names L1 twice"}));
  EXPECT_TRUE(mentions(refuse_lines(coils + "K1 L1"), {"the second inductor is missing"}));
  EXPECT_TRUE(
      mentions(refuse_lines("L1 a b 1m\nL2 a c 0\nR1 c b 1\nK1 L1 L2 1"), {"test.cir:5", "l2"}))
      << "an inductance of zero is a short and couples nothing";
}

TEST(SpiceElements, controlled_sources_have_the_signs_of_spice) {
  // Each draws a current of 1/5 A per volt from a to b.
  expect_impedance("G1 a b a b 0.2", [](Complex) { return Complex(5); });
  expect_impedance("G1 a b (a,b) 0.1 m=2", [](Complex) { return Complex(5); });
  expect_impedance("E1 n b a b 2\nR1 a n 5\n", [](Complex) { return Complex(-5); });
  expect_impedance("V1 a n 0\nR1 n b 10\nF1 a b V1 1", [](Complex) { return Complex(5); });
  expect_impedance("H1 a b V1 5\nG1 0 n a b 1\nV1 n 0", [](Complex s) { return Complex(0) * s; });
}

TEST(SpiceElements, a_current_controls_from_before_or_behind) {
  // v = 5 i through H, i being the port's own.
  expect_impedance("H1 n b V1 5\nV1 a n DC 0", [](Complex) { return Complex(5); });
  expect_impedance("V1 a n\nH1 n b V1 5", [](Complex) { return Complex(5); });
  EXPECT_TRUE(mentions(refuse_lines("V1 a n\nR1 n b 1\nF1 a b V2 1"),
                       {"test.cir:4: unknown voltage source 'v2'", "v1"}));
  EXPECT_TRUE(
      mentions(refuse_lines("R1 a b 1\nF1 a b R1 1"), {"test.cir:3: there is no voltage source"}));
}

TEST(SpiceElements, a_linear_polynomial_is_a_gain) {
  expect_impedance("G1 a b POLY(1) a b 0 0.2", [](Complex) { return Complex(5); });
  expect_impedance("G1 a b poly(1) (a,b) 0.2", [](Complex) { return Complex(5); });
  expect_impedance("V1 a n 0\nR1 n b 10\nF1 a b POLY(1) V1 0 1 0",
                   [](Complex) { return Complex(5); });
  EXPECT_TRUE(mentions(refuse_lines("G1 a b POLY(1) a b 1 0.2"), {"test.cir:2", "not linear"}));
  EXPECT_TRUE(mentions(refuse_lines("G1 a b POLY(1) a b 0 1 2"), {"not linear"}));
  EXPECT_TRUE(mentions(refuse_lines("G1 a b POLY(2) a b a b 0 1 2"), {"poly", "behavioural"}));
}

TEST(SpiceElements, sources_of_formulas_and_of_time_are_refused_by_name) {
  EXPECT_TRUE(
      mentions(refuse_lines("E1 a b value={v(a)^2}"), {"test.cir:2", "value", "behavioural"}));
  EXPECT_TRUE(mentions(refuse_lines("G1 a b laplace={v(a)} = {1/s}"), {"test.cir:2"}));
  EXPECT_TRUE(mentions(refuse_lines("E1 a b TABLE {v(a)} (0,0)"), {"table", "behavioural"}));
  for (const char* wave :
       {"PULSE(0 5 1n)", "pulse 0 5", "SIN(0 1 1k)", "SINE(0 1)", "PWL(0 0 1 1)"}) {
    const std::string line = std::string("V1 a n 0 ") + wave;
    EXPECT_TRUE(mentions(refuse_lines(line), {"test.cir:2: '", line, "waveform", "in time"}));
  }
  EXPECT_TRUE(mentions(refuse_lines("I1 a b DC 0 AC 1 EXP(0 1)"), {"waveform exp"}));
}

TEST(SpiceElements, a_source_of_zero_is_an_ammeter_or_nothing_and_its_ac_part_is_ignored) {
  for (const char* source : {"V1 a n", "V1 a n 0", "V1 a n DC 0", "V1 a n AC 1", "V1 a n 0 AC 1 90",
                             "V1 a n AC 1 0 DC {0}", "V1 a n dc=0 ac=1"}) {
    expect_impedance(std::string(source) + "\nR1 n b 5", [](Complex) { return Complex(5); });
  }
  expect_impedance("I1 a b 0\nR1 a b 5\nI2 b a AC 1", [](Complex) { return Complex(5); });
  expect_impedance("V1 a n 0 Rser=2 Cpar=1u\nR1 n b 5",
                   [](Complex s) { return 5.0 + parallel(2, 1.0 / (1e-6 * s)); });
}

TEST(SpiceElements, other_elements_are_refused_with_what_is_read) {
  EXPECT_TRUE(mentions(refuse_lines("R1 a b 1\nJ1 a b c 2N3819"),
                       {"test.cir:3: 'J1 a b c 2N3819': junction transistors are not read",
                        "R (resistors)", "D (diodes)", "X (subcircuits)"}));
  for (const char* line : {"Q1 a b c Q", "M1 a b c d M", "B1 a b V=1", "S1 a b c d S", "T1 a b c d",
                           "@1 a b a b", "^1 a b 5", "1 2 3", "\u00B5 a b", "()"}) {
    EXPECT_TRUE(mentions(refuse_lines(line), {"test.cir:2: '", "are not read: allowed: R "}))
        << line;
  }
}

TEST(SpiceElements, what_is_missing_or_too_much_on_a_line_is_named) {
  EXPECT_TRUE(mentions(refuse_lines("R1"), {"'R1': the first node is missing"}));
  EXPECT_TRUE(mentions(refuse_lines("R1 a"), {"the second node is missing"}));
  EXPECT_TRUE(mentions(refuse_lines("R1 a b"), {"resistance is missing"}));
  EXPECT_TRUE(mentions(refuse_lines("R1 a b 1 2"), {"unexpected '2'"}));
  EXPECT_TRUE(
      mentions(refuse_lines("R1 a b 1x2"), {"resistance of '1x2'", "a number such as 4.7k"}));
  EXPECT_TRUE(mentions(refuse_lines(".param rx=1\nR1 a b Rx"), {"did you mean {Rx}?"}));
  EXPECT_TRUE(mentions(refuse_lines("R1 a b {rx}"), {"test.cir:2: parameter 'rx' is not defined"}));
  EXPECT_TRUE(mentions(refuse_lines("C1 a b 1u Rsre=1"), {"'rsre'", "did you mean 'rser'?"}));
  EXPECT_TRUE(mentions(refuse_lines("C1 a b 1u Rser=1 rser=2"), {"rser is given twice"}));
  EXPECT_TRUE(mentions(refuse_lines("E1 a b c"), {"control node is missing"}));
  EXPECT_TRUE(mentions(refuse_lines("E1 a b a b"), {"the gain is missing"}));
  EXPECT_TRUE(mentions(refuse_lines("E1 a b a b 2 m=2"), {"unknown parameter 'm'"}));
}

TEST(SpiceElements, temperature_and_initial_values_are_refused) {
  for (const char* part : {"tc=0.001", "tc1=1m", "temp=50", "tc=1m,2m"}) {
    EXPECT_TRUE(mentions(refuse_lines(std::string("R1 a b 1 ") + part), {"temperature"})) << part;
  }
  EXPECT_TRUE(mentions(refuse_lines("C1 a b 1u ic=5"), {"ic = 5", "at rest"}));
}

}  // namespace
}  // namespace gyrator
