#include "gyrator/circuits/descriptor.hpp"

#include "gyrator/core/error.hpp"

#include <cmath>
#include <complex>
#include <numbers>
#include <string>
#include <vector>

#include <gtest/gtest.h>

namespace gyrator {
namespace {

using Complex = std::complex<double>;

// A 6 x 6 solve of well scaled numbers: some tens of roundings.
constexpr double rounding = 1e-13;

// From 0.1 Hz to 10 kHz, and points off the imaginary axis.
std::vector<Complex> sample_points() {
  std::vector<Complex> points{{0.5, 0}, {-3, 40}, {200, 1000}};
  for (const double hz : {0.1, 1.0, 17.0, 160.0, 1e3, 1e4}) {
    points.emplace_back(0, 2 * std::numbers::pi * hz);
  }
  return points;
}

// Nodes p, n, c, d, each held by an ideal source: input 0 … 3 is its voltage. The element under
// test sees v_p - v_n across it and v_c - v_d at its second port or control.
struct Fixture {
  Network network;
  std::vector<NodeId> nodes;
  std::vector<ElementId> sources;

  Fixture() {
    for (const char* name : {"p", "n", "c", "d"}) {
      const int input = network.add_input(name);
      nodes.push_back(network.add_node(name, Domain::electrical));
      sources.push_back(
          network.add(std::string("hold.") + name, nodes.back(), ground, VoltageSource{input}));
    }
  }

  // Current per volt of every input that leaves each of the four nodes into the element.
  Eigen::Matrix4cd draw(Complex s) const {
    const NetworkEquations equations(network);
    const Eigen::MatrixXcd x = solve_descriptor(equations.descriptor(), s);
    Eigen::Matrix4cd current;
    for (int i = 0; i < 4; ++i) {
      const LinearForm form = equations.through(sources[static_cast<std::size_t>(i)]);
      current.row(i) = -(form.x * x + form.u);
    }
    return current;
  }
};

// Rows and columns p, n, c, d: the admittance matrix of i = y (v_a - v_b) from one node pair.
Eigen::Matrix4cd pair(int from, int to, int a, int b, Complex y) {
  Eigen::Matrix4cd m = Eigen::Matrix4cd::Zero();
  m(from, a) += y;
  m(from, b) -= y;
  m(to, a) -= y;
  m(to, b) += y;
  return m;
}

void expect_admittance(const Fixture& fixture, const Eigen::Matrix4cd& expected, Complex s) {
  const Eigen::Matrix4cd found = fixture.draw(s);
  EXPECT_LE((found - expected).norm(), rounding * expected.norm()) << "s = " << s << "\n"
                                                                   << found << "\nexpected\n"
                                                                   << expected;
}

TEST(Descriptor, passive_elements_draw_their_own_admittance_from_both_nodes) {
  constexpr double R = 4.7, G = 0.3, L = 2e-3, C = 3e-4;
  for (const Complex s : sample_points()) {
    const std::vector<std::pair<ElementLaw, Complex>> laws{{Resistor{R}, 1 / R},
                                                           {Conductance{G}, G},
                                                           {Inductor{L}, 1.0 / (L * s)},
                                                           {Capacitor{C}, C * s}};
    for (const auto& [law, y] : laws) {
      Fixture fixture;
      fixture.network.add("x", fixture.nodes[0], fixture.nodes[1], law);
      expect_admittance(fixture, pair(0, 1, 0, 1, y), s);
    }
  }
}

TEST(Descriptor, voltage_controlled_current_source_draws_gain_times_the_control_voltage) {
  constexpr double g = -0.7;
  Fixture fixture;
  fixture.network.add("x", fixture.nodes[0], fixture.nodes[1],
                      VoltageControlledCurrentSource{g, fixture.nodes[2], fixture.nodes[3]});
  expect_admittance(fixture, pair(0, 1, 2, 3, g), {0, 10});
}

TEST(Descriptor, current_controlled_current_source_multiplies_the_sensed_current) {
  constexpr double gain = 50, R = 8;
  Fixture fixture;
  Network& network = fixture.network;
  const NodeId inner = network.add_node("inner", Domain::electrical);
  const ElementId ammeter = network.add("ammeter", fixture.nodes[2], inner, VoltageSource{});
  network.add("r", inner, fixture.nodes[3], Resistor{R});
  network.add("x", fixture.nodes[0], fixture.nodes[1],
              CurrentControlledCurrentSource{gain, ammeter});
  expect_admittance(fixture, pair(2, 3, 2, 3, 1 / R) + pair(0, 1, 2, 3, gain / R), {0, 10});
}

TEST(Descriptor, controlled_voltage_sources_add_their_voltage_behind_a_resistor) {
  constexpr double gain = -3, r_m = 20, R = 5, R_sense = 8;
  {
    // i = (v_p - v_n - gain (v_c - v_d)) / R
    Fixture fixture;
    Network& network = fixture.network;
    const NodeId inner = network.add_node("inner", Domain::electrical);
    network.add("r", fixture.nodes[0], inner, Resistor{R});
    network.add("x", inner, fixture.nodes[1],
                VoltageControlledVoltageSource{gain, fixture.nodes[2], fixture.nodes[3]});
    expect_admittance(fixture, pair(0, 1, 0, 1, 1 / R) - pair(0, 1, 2, 3, gain / R), {0, 10});
  }
  {
    // The sensed current is (v_c - v_d) / R_sense, and the voltage r_m times that.
    Fixture fixture;
    Network& network = fixture.network;
    const NodeId inner = network.add_node("inner", Domain::electrical);
    const NodeId sense = network.add_node("sense", Domain::electrical);
    const ElementId ammeter = network.add("ammeter", fixture.nodes[2], sense, VoltageSource{});
    network.add("r_sense", sense, fixture.nodes[3], Resistor{R_sense});
    network.add("r", fixture.nodes[0], inner, Resistor{R});
    network.add("x", inner, fixture.nodes[1], CurrentControlledVoltageSource{r_m, ammeter});
    expect_admittance(fixture,
                      pair(2, 3, 2, 3, 1 / R_sense) + pair(0, 1, 0, 1, 1 / R) -
                          pair(0, 1, 2, 3, r_m / (R_sense * R)),
                      {0, 10});
  }
}

TEST(Descriptor, current_source_carries_its_input_from_positive_to_negative) {
  Network network;
  const int u = network.add_input("u");
  const NodeId a = network.add_node("a", Domain::electrical);
  const NodeId b = network.add_node("b", Domain::electrical);
  network.add("ra", a, ground, Resistor{2});
  network.add("rb", b, ground, Resistor{3});
  const ElementId source = network.add("x", a, b, CurrentSource{u});
  const NetworkEquations equations(network);
  const Eigen::MatrixXcd x = solve_descriptor(equations.descriptor(), 0);
  // It pulls 1 A out of a and pushes it into b.
  EXPECT_NEAR(std::abs((equations.across(a).x * x)(0) + 2.0), 0, rounding);
  EXPECT_NEAR(std::abs((equations.across(b).x * x)(0) - 3.0), 0, rounding);
  EXPECT_NEAR(std::abs((equations.across(source).x * x)(0) + 5.0), 0, rounding);
  EXPECT_EQ(equations.through(source).u(u), 1);
  EXPECT_TRUE(equations.through(source).x.isZero(0));
}

TEST(Descriptor, transformer_scales_an_impedance_by_the_square_of_its_ratio_and_loses_nothing) {
  // Second port loaded by R: v = n v_2, i_2 = -n i, so that v / i = n^2 R.
  constexpr double n = 0.05, R = 700;
  Fixture fixture;
  Network& network = fixture.network;
  const NodeId second = network.add_node("second", Domain::electrical);
  const ElementId t = network.add("x", fixture.nodes[0], fixture.nodes[1],
                                  Transformer{n, second, fixture.nodes[3]});
  const ElementId load = network.add("r", second, fixture.nodes[3], Resistor{R});
  expect_admittance(fixture, pair(0, 1, 0, 1, 1 / (n * n * R)), {0, 10});

  const NetworkEquations equations(network);
  const Eigen::MatrixXcd x = solve_descriptor(equations.descriptor(), Complex(0, 10));
  const Eigen::RowVectorXcd i = equations.through(t).x * x;
  const Eigen::RowVectorXcd i_load = equations.through(load).x * x;
  const Eigen::RowVectorXcd v = equations.across(t).x * x;
  const Eigen::RowVectorXcd v_2 = equations.across(second, fixture.nodes[3]).x * x;
  EXPECT_LE((i_load - n * i).norm(), rounding * i_load.norm());  // i_load = -i_2
  EXPECT_LE((v - n * v_2).norm(), rounding * v.norm());
}

TEST(Descriptor, gyrator_turns_an_impedance_into_its_inverse) {
  // i = g v_2, i_2 = -g v, second port loaded by C: the first looks like an inductor C/g^2.
  constexpr double g = 0.2, C = 1e-3;
  Fixture fixture;
  Network& network = fixture.network;
  const NodeId second = network.add_node("second", Domain::electrical);
  network.add("x", fixture.nodes[0], fixture.nodes[1], Gyrator{g, second, fixture.nodes[3]});
  network.add("c", second, fixture.nodes[3], Capacitor{C});
  for (const Complex s : sample_points()) {
    expect_admittance(fixture, pair(0, 1, 0, 1, g * g / (C * s)), s);
  }
  Fixture held;  // and with the second port held, each side draws g times the other's voltage
  held.network.add("x", held.nodes[0], held.nodes[1], Gyrator{g, held.nodes[2], held.nodes[3]});
  expect_admittance(held, pair(0, 1, 2, 3, g) - pair(2, 3, 0, 1, g), {0, 10});
}

TEST(Descriptor, a_motor_is_its_winding_and_its_back_emf) {
  // Terminal voltage c, shaft free with J and b:
  //   w / V = K_t / ((R + L s)(J s + b) + K_t^2),   I / V = (J s + b) / (same)
  constexpr double K_t = 23.5e-3, R = 2.06, L = 0.238e-3, J = 1.07e-6, b = 1.2e-6;  // RE25 10 W
  Network network;
  const int u = network.add_input("voltage");
  const NodeId terminal = network.add_node("terminal", Domain::electrical);
  const NodeId inner = network.add_node("inner", Domain::electrical);
  const NodeId emf = network.add_node("emf", Domain::electrical);
  const NodeId shaft = network.add_node("shaft", Domain::mechanical);
  network.add("source", terminal, ground, VoltageSource{u});
  network.add("resistance", terminal, inner, Resistor{R});
  const ElementId winding = network.add("inductance", inner, emf, Inductor{L});
  network.add("torque_constant", emf, ground, Transformer{K_t, shaft, ground});
  network.add("inertia", shaft, ground, Capacitor{J});
  network.add("damping", shaft, ground, Conductance{b});
  const NetworkEquations equations(network);
  for (const Complex s : sample_points()) {
    const Complex denominator = (R + L * s) * (J * s + b) + K_t * K_t;
    const Eigen::MatrixXcd x = solve_descriptor(equations.descriptor(), s);
    const Complex speed = (equations.across(shaft).x * x)(0);
    const Complex current = (equations.through(winding).x * x)(0);
    // The equations mix 1e-6 and 1e2; that costs digits of the smaller result.
    EXPECT_LE(std::abs(speed * denominator / K_t - 1.0), 1e-12) << s;
    EXPECT_LE(std::abs(current * denominator / (J * s + b) - 1.0), 1e-12) << s;
  }
}

TEST(Descriptor, the_current_of_any_element_agrees_with_an_ammeter_in_series) {
  const std::vector<ElementLaw> laws{Resistor{3},
                                     Conductance{0.4},
                                     Inductor{0.1},
                                     VoltageSource{1},
                                     CurrentSource{1},
                                     VoltageControlledVoltageSource{2, NodeId{2}, NodeId{3}},
                                     VoltageControlledCurrentSource{2, NodeId{2}, NodeId{3}},
                                     CurrentControlledVoltageSource{2, ElementId{0}},
                                     CurrentControlledCurrentSource{2, ElementId{0}},
                                     Transformer{2, NodeId{2}, NodeId{3}},
                                     Gyrator{2, NodeId{2}, NodeId{3}}};
  for (std::size_t kind = 0; kind < laws.size(); ++kind) {
    Network network;
    const int u = network.add_input("u");
    const int w = network.add_input("w");
    const NodeId a = network.add_node("a", Domain::electrical);
    const NodeId b = network.add_node("b", Domain::electrical);
    const NodeId c = network.add_node("c", Domain::electrical);
    const NodeId d = network.add_node("d", Domain::electrical);
    const NodeId e = network.add_node("e", Domain::electrical);
    network.add("control", b, e, VoltageSource{});
    const ElementId ammeter = network.add("ammeter", a, d, VoltageSource{});
    network.add("drive_a", ground, a, CurrentSource{u});
    network.add("drive_b", ground, b, CurrentSource{w});
    network.add("ra", a, ground, Resistor{2});
    network.add("rb", b, ground, Resistor{5});
    network.add("rec", e, c, Resistor{7});
    network.add("rc", c, ground, Resistor{11});
    const ElementId x = network.add("x", d, c, laws[kind]);
    const NetworkEquations equations(network);
    const Eigen::MatrixXcd solved = solve_descriptor(equations.descriptor(), Complex(1, 2));
    const LinearForm own = equations.through(x);
    const LinearForm meter = equations.through(ammeter);
    const Eigen::RowVectorXcd through = own.x * solved + own.u;
    const Eigen::RowVectorXcd measured = meter.x * solved + meter.u;
    EXPECT_GT(measured.norm(), 1e-3) << "kind " << kind << " carries nothing";
    EXPECT_LE((through - measured).norm(), rounding * measured.norm()) << "kind " << kind;
  }
}

TEST(Descriptor, what_carries_no_current_unknown_is_refused_by_name) {
  Network network;
  const NodeId a = network.add_node("a", Domain::electrical);
  const ElementId c = network.add("c1", a, ground, Capacitor{1});
  const ElementId r = network.add("r1", a, ground, Resistor{1});
  try {
    (void)NetworkEquations(network).through(c);
    FAIL() << "the current of a capacitor was given";
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::bad_input);
    EXPECT_EQ(error.place(), "c1");
    EXPECT_NE(error.message().find("ammeter"), std::string::npos);
  }
  network.add("copy", a, ground, CurrentControlledCurrentSource{1, r});
  try {
    const NetworkEquations equations(network);
    FAIL() << "a source controlled by the current of a resistor was accepted";
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::bad_input);
    EXPECT_EQ(error.place(), "copy");
    EXPECT_NE(error.message().find("r1"), std::string::npos);
  }
}

TEST(Descriptor, a_pencil_that_is_singular_at_the_frequency_is_an_error) {
  // An LC pair of 1 rad/s without loss, driven at exactly its resonance.
  Network network;
  const int u = network.add_input("u");
  const NodeId a = network.add_node("a", Domain::electrical);
  network.add("source", ground, a, CurrentSource{u});
  network.add("l", a, ground, Inductor{1});
  network.add("c", a, ground, Capacitor{1});
  const NetworkEquations equations(network);
  EXPECT_NO_THROW(solve_descriptor(equations.descriptor(), Complex(0, 1.001)));
  try {
    solve_descriptor(equations.descriptor(), Complex(0, 1));
    FAIL() << "an infinite response was returned";
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::numerical);
  }
}

TEST(SteadyState, is_the_response_at_zero_frequency) {
  // 10 V through 1 ohm, 2 ohm and an inductor to ground: 10/3 A; the capacitor at the middle.
  Network network;
  const int u = network.add_input("u");
  const NodeId a = network.add_node("a", Domain::electrical);
  const NodeId b = network.add_node("b", Domain::electrical);
  const NodeId c = network.add_node("c", Domain::electrical);
  network.add("source", a, ground, VoltageSource{u});
  network.add("r1", a, b, Resistor{1});
  network.add("c1", b, ground, Capacitor{1e-6});
  network.add("r2", b, c, Resistor{2});
  const ElementId l = network.add("l1", c, ground, Inductor{1e-3});
  const NetworkEquations equations(network);
  const Eigen::MatrixXd x = solve_steady_state(equations.descriptor());
  EXPECT_NEAR((equations.across(b).x * x)(0), 2.0 / 3, rounding);
  EXPECT_NEAR((equations.across(c).x * x)(0), 0, rounding);
  EXPECT_NEAR((equations.through(l).x * x)(0), 1.0 / 3, rounding);
}

TEST(SteadyState, leaves_a_node_between_two_capacitors_at_zero_and_has_none_for_a_ramp) {
  Network network;
  const int voltage = network.add_input("voltage");
  const int current = network.add_input("current");
  const NodeId a = network.add_node("a", Domain::electrical);
  const NodeId middle = network.add_node("middle", Domain::electrical);
  const NodeId tank = network.add_node("tank", Domain::electrical);
  network.add("source", a, ground, VoltageSource{voltage});
  network.add("c1", a, middle, Capacitor{1e-6});
  network.add("c2", middle, ground, Capacitor{1e-6});
  network.add("charger", ground, tank, CurrentSource{current});
  network.add("c3", tank, ground, Capacitor{1e-6});
  const NetworkEquations equations(network);
  const Eigen::MatrixXd x = solve_steady_state(equations.descriptor());
  EXPECT_EQ((equations.across(middle).x * x)(voltage), 0);
  EXPECT_NEAR((equations.across(a).x * x)(voltage), 1, rounding);
  EXPECT_TRUE(std::isnan((equations.across(tank).x * x)(current))) << "c3 charges for ever";
}

TEST(Descriptor, coupled_inductors_are_a_transformer_with_leakage) {
  // V = (s L1 - (s M)^2/(R + s L2)) I seen from the first winding, the second loaded by R.
  const double l1 = 4e-3, l2 = 1e-3, m = -1.5e-3, r = 7;
  Network network;
  const int u = network.add_input("u");
  const NodeId a = network.add_node("a", Domain::electrical);
  const NodeId b = network.add_node("b", Domain::electrical);
  const ElementId source = network.add("source", a, ground, VoltageSource{u});
  const ElementId first = network.add("l1", a, ground, Inductor{l1});
  const ElementId second = network.add("l2", b, ground, Inductor{l2});
  network.add("k", ground, ground, MutualInductance{m, first, second});
  network.add("load", b, ground, Resistor{r});
  const NetworkEquations equations(network);
  const std::complex<double> s(0, 2e4);
  const Eigen::MatrixXcd x = solve_descriptor(equations.descriptor(), s);
  const std::complex<double> seen = s * l1 - s * m * s * m / (r + s * l2);
  const std::complex<double> current = -(equations.through(source).x * x)(0);
  EXPECT_LE(std::abs(current - 1.0 / seen), 1e-13 / std::abs(seen));
}

TEST(Descriptor, an_ideal_op_amp_holds_its_inputs_equal) {
  // Inverting integrator: v_out/u = -1/(s R C).
  Network network;
  const int u = network.add_input("u");
  const NodeId in = network.add_node("in", Domain::electrical);
  const NodeId minus = network.add_node("minus", Domain::electrical);
  const NodeId out = network.add_node("out", Domain::electrical);
  network.add("source", in, ground, VoltageSource{u});
  network.add("r", in, minus, Resistor{1e4});
  network.add("c", minus, out, Capacitor{1e-7});
  network.add("opamp", out, ground, IdealOpAmp{ground, minus});
  const NetworkEquations equations(network);
  const std::complex<double> s(0, 300);
  const Eigen::MatrixXcd x = solve_descriptor(equations.descriptor(), s);
  EXPECT_LE(std::abs((equations.across(out).x * x)(0) + 1.0 / (s * 1e-3)), 1e-13 * 10);
}

}  // namespace
}  // namespace gyrator
