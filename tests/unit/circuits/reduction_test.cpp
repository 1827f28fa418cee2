#include "gyrator/circuits/reduction.hpp"

#include "gyrator/circuits/state_space.hpp"
#include "gyrator/core/error.hpp"

#include <cmath>
#include <complex>
#include <functional>
#include <string>
#include <vector>

#include <gtest/gtest.h>

namespace gyrator {
namespace {

using Complex = std::complex<double>;
using Eigen::MatrixXcd;

// Eliminations of a handful of well scaled equations: some tens of roundings.
constexpr double rounding = 1e-13;

NodeId electrical(Network& network, const char* name) {
  return network.add_node(name, Domain::electrical);
}
NodeId mechanical(Network& network, const char* name) {
  return network.add_node(name, Domain::mechanical);
}

// Voltage source, R and L in series.
Network make_rl() {
  Network n;
  const int u = n.add_input("voltage");
  const NodeId a = electrical(n, "a"), b = electrical(n, "b");
  n.add("source", a, ground, VoltageSource{u});
  n.add("r", a, b, Resistor{3});
  n.add("l", b, ground, Inductor{0.2});
  return n;
}

// Index 2: a current source decides the current of an inductor. R to ground on its far side, and
// a motor-like transformer to a mass, so that states remain.
Network make_forced_inductor() {
  Network n;
  const int u = n.add_input("current");
  const NodeId a = electrical(n, "a"), b = electrical(n, "b");
  const NodeId shaft = mechanical(n, "shaft");
  n.add("source", ground, a, CurrentSource{u});
  n.add("r", a, b, Resistor{2});
  const NodeId emf = electrical(n, "emf");
  n.add("l", b, emf, Inductor{0.5});
  n.add("torque_constant", emf, ground, Transformer{0.25, shaft, ground});
  n.add("mass", shaft, ground, Capacitor{4});
  n.add("damper", shaft, ground, Conductance{0.5});
  return n;
}

// Index 2: a voltage source with two capacitors in series is a loop of capacitors.
Network make_capacitor_loop() {
  Network n;
  const int u = n.add_input("voltage");
  const NodeId a = electrical(n, "a"), b = electrical(n, "b");
  n.add("source", a, ground, VoltageSource{u});
  n.add("c1", a, b, Capacitor{3});
  n.add("c2", b, ground, Capacitor{1});
  n.add("r", b, ground, Resistor{0.5});
  return n;
}

// Index 2: two masses joined by an ammeter move as one; a third hangs on a spring.
Network make_rigid_masses() {
  Network n;
  const int u = n.add_input("force");
  const NodeId a = mechanical(n, "a"), b = mechanical(n, "b"), c = mechanical(n, "c");
  n.add("mass_a", a, ground, Capacitor{2});
  n.add("joint", a, b, VoltageSource{});
  n.add("mass_b", b, ground, Capacitor{6});
  n.add("spring", b, c, Inductor{1.0 / 50});
  n.add("mass_c", c, ground, Capacitor{1});
  n.add("damper", c, ground, Conductance{0.25});
  n.add("force", ground, a, CurrentSource{u});
  return n;
}

// Index 2 twice over: inductors in series fed by a current source, capacitors in parallel.
Network make_double_index_two() {
  Network n;
  const int u = n.add_input("current");
  const NodeId a = electrical(n, "a"), b = electrical(n, "b"), c = electrical(n, "c");
  const NodeId d = electrical(n, "d");
  n.add("source", ground, a, CurrentSource{u});
  n.add("l1", a, b, Inductor{0.1});
  n.add("l2", b, c, Inductor{0.3});
  n.add("c1", c, ground, Capacitor{2});
  n.add("link", c, d, VoltageSource{});
  n.add("c2", d, ground, Capacitor{3});
  n.add("r", d, ground, Resistor{4});
  return n;
}

double find(const NetworkEquations& equations, const Eigen::VectorXd& x, const char* unknown) {
  const auto& names = equations.descriptor().unknown_names;
  for (std::size_t i = 0; i < names.size(); ++i) {
    if (names[i] == unknown) return x(static_cast<Eigen::Index>(i));
  }
  ADD_FAILURE() << "no unknown " << unknown;
  return 0;
}

TEST(Reduction, gives_the_descriptors_frequency_response_in_every_unknown) {
  // x(s) = [recover_state (sI - A)^-1 B + recover_input + s recover_rate] u(s)        (red-1)
  for (const auto& make : {make_rl, make_forced_inductor, make_capacitor_loop, make_rigid_masses,
                           make_double_index_two}) {
    const NetworkEquations equations(make());
    const Reduction r = reduce(equations.descriptor());
    for (const Complex s : {Complex(0, 0.01), Complex(0, 3), Complex(-0.4, 80), Complex(25, 0)}) {
      const MatrixXcd wanted = solve_descriptor(equations.descriptor(), s);
      const Eigen::Index n = r.A.rows();
      const MatrixXcd pencil = s * MatrixXcd::Identity(n, n) - r.A;
      const MatrixXcd w = pencil.partialPivLu().solve(r.B.cast<Complex>());
      const MatrixXcd found = r.recover_state * w + r.recover_input + s * r.recover_rate;
      EXPECT_LE((found - wanted).norm(), rounding * wanted.norm()) << "s = " << s;
    }
  }
}

TEST(Reduction, index_1_keeps_one_state_per_inductor_and_needs_no_derivative) {
  const NetworkEquations equations(make_rl());
  const Reduction r = reduce(equations.descriptor());
  ASSERT_EQ(r.A.rows(), 1);
  EXPECT_NEAR(r.A(0, 0), -3 / 0.2, rounding * 15);  // -R/L
  EXPECT_TRUE(r.recover_rate.isZero(0));
}

TEST(Reduction, index_2_of_a_forced_inductor_leaves_the_derivative_in_its_voltage_only) {
  const NetworkEquations equations(make_forced_inductor());
  const Reduction r = reduce(equations.descriptor());
  ASSERT_EQ(r.A.rows(), 1) << "the speed is the only state left";
  EXPECT_NEAR(r.A(0, 0), -0.5 / 4, rounding);  // -b/J: an ideal current source adds no damping
  const Eigen::VectorXd rate = r.recover_rate.col(0);
  EXPECT_NEAR(find(equations, rate, "a"), 0.5, rounding);  // L
  EXPECT_NEAR(find(equations, rate, "b"), 0.5, rounding);
  EXPECT_NEAR(find(equations, rate, "emf"), 0, rounding);
  EXPECT_NEAR(find(equations, rate, "shaft"), 0, rounding);
  EXPECT_NEAR(find(equations, r.recover_input.col(0), "l"), 1, rounding);
}

TEST(Reduction, index_2_of_a_capacitor_loop_divides_the_step_and_moves_the_input_into_the_state) {
  // v_b = w + F u with F = C1/(C1 + C2), dw/dt = -(w + F u)/(R (C1 + C2)); i_source = -C_s u' + …
  const NetworkEquations equations(make_capacitor_loop());
  const Reduction r = reduce(equations.descriptor());
  ASSERT_EQ(r.A.rows(), 1);
  EXPECT_NEAR(r.A(0, 0), -1 / (0.5 * 4), rounding);
  EXPECT_NEAR(find(equations, r.recover_input.col(0), "b"), 0.75, rounding);
  EXPECT_NEAR(find(equations, r.recover_rate.col(0), "b"), 0, rounding);
  EXPECT_NEAR(find(equations, r.recover_rate.col(0), "source"), -0.75, rounding);  // series C
}

TEST(Reduction, index_2_of_rigid_masses_moves_their_sum) {
  const NetworkEquations equations(make_rigid_masses());
  const Reduction r = reduce(equations.descriptor());
  ASSERT_EQ(r.A.rows(), 3);
  // Undamped the pair would resonate at sqrt(k (1/8 + 1/1)); with the light damper the product of
  // the poles is -k b / (8 m_c), the constant term of the characteristic polynomial.
  const Complex product = compute_poles(r.A).prod();
  EXPECT_NEAR(product.real(), -50 * 0.25 / 8, 1e-11);
  // A step of force is felt as acceleration 1/8 of both: no jump, no impulse.
  EXPECT_NEAR(find(equations, r.recover_input.col(0), "a"), 0, rounding);
  EXPECT_NEAR(find(equations, r.recover_state * r.B.col(0), "b"), 1.0 / 8, rounding);
  EXPECT_NEAR(find(equations, r.recover_input.col(0), "joint"), 6.0 / 8, rounding);
}

TEST(Reduction, initial_state_keeps_the_momentum_of_rigid_masses) {
  const NetworkEquations equations(make_rigid_masses());
  const Reduction r = reduce(equations.descriptor());
  Eigen::VectorXd wanted = Eigen::VectorXd::Zero(equations.descriptor().size());
  wanted(0) = 4;   // a, 2 kg
  wanted(1) = -2;  // b, 6 kg
  wanted(2) = 9;   // c, 1 kg
  const Eigen::VectorXd x = r.recover_state * (r.initialize * wanted);
  const double together = (2 * 4.0 + 6 * -2.0) / 8;
  EXPECT_NEAR(find(equations, x, "a"), together, rounding);
  EXPECT_NEAR(find(equations, x, "b"), together, rounding);
  EXPECT_NEAR(find(equations, x, "c"), 9, 9 * rounding);
}

TEST(Reduction, initial_state_keeps_charge_and_flux) {
  const NetworkEquations equations(make_double_index_two());
  const Reduction r = reduce(equations.descriptor());
  Eigen::VectorXd wanted = Eigen::VectorXd::Zero(equations.descriptor().size());
  const auto& names = equations.descriptor().unknown_names;
  for (std::size_t i = 0; i < names.size(); ++i) {
    if (names[i] == "c") wanted(static_cast<Eigen::Index>(i)) = 5;
    if (names[i] == "d") wanted(static_cast<Eigen::Index>(i)) = -1;
    if (names[i] == "l1") wanted(static_cast<Eigen::Index>(i)) = 7;  // source at zero: stops
  }
  const Eigen::VectorXd x = r.recover_state * (r.initialize * wanted);
  EXPECT_NEAR(find(equations, x, "c"), (2 * 5.0 + 3 * -1.0) / 5, rounding);
  EXPECT_NEAR(find(equations, x, "l1"), 0, rounding);

  // Two inductors in a closed ring end up with one current of the same flux linkage.
  Network ring;
  const NodeId a = electrical(ring, "a");
  ring.add("l1", ground, a, Inductor{0.1});
  ring.add("l2", a, ground, Inductor{0.3});
  const NetworkEquations ring_equations(ring);
  const Reduction ring_reduction = reduce(ring_equations.descriptor());
  const Eigen::VectorXd y =
      ring_reduction.recover_state * (ring_reduction.initialize * Eigen::Vector3d(0, 8, 4));
  EXPECT_NEAR(find(ring_equations, y, "l1"), (0.1 * 8 + 0.3 * 4) / 0.4, 8 * rounding);
  EXPECT_NEAR(find(ring_equations, y, "l2"), (0.1 * 8 + 0.3 * 4) / 0.4, 8 * rounding);
}

TEST(Reduction, takes_component_values_over_eighteen_decades) {
  // 1 pF with 1 Mohm beside 1 kg with 1 uN.s/m: the poles are as if each were alone.
  Network n;
  const NodeId a = electrical(n, "a"), shaft = mechanical(n, "shaft");
  n.add("r", a, ground, Resistor{1e6});
  n.add("c", a, ground, Capacitor{1e-12});
  n.add("mass", shaft, ground, Capacitor{1});
  n.add("damper", shaft, ground, Conductance{1e-6});
  const Reduction r = reduce(NetworkEquations(n).descriptor());
  ASSERT_EQ(r.A.rows(), 2);
  const Eigen::VectorXcd poles = compute_poles(r.A);
  EXPECT_NEAR(poles.real().minCoeff() / -1e6, 1, rounding);
  EXPECT_NEAR(poles.real().maxCoeff() / -1e-6, 1, rounding);
}

// A long ladder with an index-2 place at either end: hundreds of unknowns, of which the algebraic
// ones between the capacitors make some blocks dense.
Network make_long_ladder(int sections) {
  Network n;
  const int u = n.add_input("voltage"), j = n.add_input("current");
  NodeId node = electrical(n, "start");
  n.add("source", node, ground, VoltageSource{u});
  n.add("c.start", node, ground, Capacitor{2e-3});  // across the source: its current has u'
  for (int i = 0; i < sections; ++i) {
    const std::string name = std::to_string(i);
    const double vary = std::pow(10, 0.5 * std::sin(1.7 * i));
    const NodeId inner = electrical(n, ("inner" + name).c_str());
    const NodeId next = electrical(n, ("node" + name).c_str());
    n.add("r" + name, node, inner, Resistor{3 * vary});
    n.add("l" + name, inner, next, Inductor{0.2 / vary});
    if (i % 4 != 1) n.add("c" + name, next, ground, Capacitor{1e-3 * vary});
    n.add("g" + name, next, ground, Resistor{50 * vary});
    node = next;
  }
  const NodeId end = electrical(n, "end");
  n.add("l.end", node, end, Inductor{0.1});
  n.add("feed", ground, end, CurrentSource{j});  // decides the inductor's current
  return n;
}

TEST(Reduction, of_hundreds_of_unknowns_gives_the_descriptors_response) {
  const NetworkEquations equations(make_long_ladder(100));
  ASSERT_GT(equations.descriptor().size(), 300);
  const Reduction r = reduce(equations.descriptor());
  EXPECT_EQ(r.A.rows(), 100 + 75) << "inductors and capacitors but for those at the ends";
  for (const Complex s : {Complex(0, 0.01), Complex(0, 30), Complex(-0.4, 800)}) {
    const MatrixXcd wanted = solve_descriptor(equations.descriptor(), s);
    const MatrixXcd pencil = s * MatrixXcd::Identity(r.A.rows(), r.A.rows()) - r.A;
    const MatrixXcd w = pencil.partialPivLu().solve(r.B.cast<Complex>());
    const MatrixXcd found = r.recover_state * w + r.recover_input + s * r.recover_rate;
    // A hundred times the unknowns of the small networks, their roundings in sequence.
    EXPECT_LE((found - wanted).norm(), 100 * rounding * wanted.norm()) << "s = " << s;
  }
}

TEST(Reduction, a_network_of_resistors_has_no_state) {
  Network n;
  const int u = n.add_input("voltage");
  const NodeId a = electrical(n, "a"), b = electrical(n, "b");
  n.add("source", a, ground, VoltageSource{u});
  n.add("r1", a, b, Resistor{1});
  n.add("r2", b, ground, Resistor{3});
  const NetworkEquations equations(n);
  const Reduction r = reduce(equations.descriptor());
  EXPECT_EQ(r.A.rows(), 0);
  EXPECT_NEAR(r.reduce(equations.across(b)).input(u), 0.75, rounding);
}

// ---- what cannot be reduced

// The place of the refusal, which must be numerical.
std::string refusal(const std::function<void(Network&)>& build) {
  Network network;
  network.add_input("u");
  network.add_input("w");
  build(network);
  try {
    (void)reduce(NetworkEquations(network).descriptor());
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::numerical);
    return error.place() + (error.message().find("index 3") != std::string::npos ? " index 3" : "");
  }
  return "accepted";
}

TEST(SingularNetwork, names_the_elements_of_an_island_without_a_reference) {
  EXPECT_EQ(refusal([](Network& n) {
              const NodeId a = electrical(n, "a"), b = electrical(n, "b"), c = electrical(n, "c");
              n.add("grounded", c, ground, Resistor{1});
              n.add("island.r", a, b, Resistor{1});
              n.add("island.c", a, b, Capacitor{1});
            }),
            "island.c, island.r");
}

TEST(SingularNetwork, names_the_sources_of_a_voltage_loop) {
  EXPECT_EQ(refusal([](Network& n) {
              const NodeId a = electrical(n, "a"), b = electrical(n, "b");
              n.add("battery", a, ground, VoltageSource{0});
              n.add("ammeter", a, b, VoltageSource{});
              n.add("amplifier", b, ground, VoltageSource{1});
              n.add("load", b, ground, Resistor{1});
            }),
            "ammeter, amplifier, battery");
}

TEST(SingularNetwork, names_the_sources_of_a_current_cut_set) {
  EXPECT_EQ(refusal([](Network& n) {
              const NodeId a = electrical(n, "a");
              n.add("up", ground, a, CurrentSource{0});
              n.add("down", a, ground, CurrentSource{1});
              const NodeId b = electrical(n, "b");
              n.add("load", b, ground, Resistor{1});
            }),
            "down, up");
}

TEST(SingularNetwork, names_the_island_among_hundreds_of_elements) {
  EXPECT_EQ(refusal([](Network& n) {
              n = make_long_ladder(100);
              const NodeId a = electrical(n, "a"), b = electrical(n, "b"), c = electrical(n, "c");
              n.add("island.ab", a, b, Resistor{3});
              n.add("island.bc", b, c, Resistor{7});
              n.add("island.ca", c, a, Resistor{11});
            }),
            "island.ab, island.bc, island.ca");
}

TEST(SingularNetwork, an_isolated_winding_floats) {
  EXPECT_EQ(refusal([](Network& n) {
              const NodeId a = electrical(n, "a"), b = electrical(n, "b"), c = electrical(n, "c");
              n.add("source", a, ground, VoltageSource{0});
              n.add("transformer", a, ground, Transformer{2, b, c});
              n.add("load", b, c, Resistor{1});
            }),
            "load, transformer");
}

// A current source decides i_1 of l1, its voltage through g decides i_2 of l2, and so on: each
// stage differentiates once more.
void add_differentiators(Network& n, double inductance, double transconductance) {
  const NodeId a = electrical(n, "a"), b = electrical(n, "b");
  n.add("source", ground, a, CurrentSource{0});
  n.add("l1", a, ground, Inductor{inductance});
  n.add("stage", ground, b, VoltageControlledCurrentSource{transconductance, a, ground});
  n.add("l2", b, ground, Inductor{inductance});
}

TEST(Reduction, index_3_is_refused_whatever_the_units) {
  for (const double inductance : {1.0, 1e-3, 1e-6}) {
    for (const double transconductance : {1.0, 1e-4}) {
      EXPECT_EQ(refusal([&](Network& n) { add_differentiators(n, inductance, transconductance); }),
                "network index 3")
          << inductance << " H, " << transconductance << " S";
    }
  }
}

}  // namespace
}  // namespace gyrator
