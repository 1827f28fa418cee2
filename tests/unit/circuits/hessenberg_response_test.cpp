#include "gyrator/circuits/hessenberg_response.hpp"

#include "gyrator/circuits/descriptor.hpp"
#include "gyrator/circuits/reduction.hpp"

#include <algorithm>
#include <cmath>
#include <complex>
#include <limits>
#include <numbers>
#include <random>
#include <string>
#include <vector>

#include <gtest/gtest.h>

namespace gyrator {
namespace {

using Complex = std::complex<double>;

struct Section {
  double resistance, inductance, capacitance;
};

// Sections of R and L in series and C to ground, open at the far end, behind a voltage source.
struct Ladder {
  Network network;
  ElementId source;
  NodeId far = ground;

  explicit Ladder(const std::vector<Section>& sections) {
    const int u = network.add_input("u");
    NodeId node = network.add_node("start", Domain::electrical);
    source = network.add("source", node, ground, VoltageSource{u});
    for (std::size_t i = 0; i < sections.size(); ++i) {
      const std::string name = std::to_string(i);
      const NodeId inner = network.add_node("inner" + name, Domain::electrical);
      const NodeId next = network.add_node("node" + name, Domain::electrical);
      network.add("r" + name, node, inner, Resistor{sections[i].resistance});
      network.add("l" + name, inner, next, Inductor{sections[i].inductance});
      network.add("c" + name, next, ground, Capacitor{sections[i].capacitance});
      node = next;
    }
    far = node;
  }
};

// Input admittance and far-end voltage, by the chain of impedances from the far end.
struct ChainResponse {
  Complex admittance, voltage;
};
ChainResponse respond(const std::vector<Section>& sections, Complex s) {
  ChainResponse r{0.0, 1.0};
  for (std::size_t i = sections.size(); i-- > 0;) {
    const Complex shunt = r.admittance + s * sections[i].capacitance;
    const Complex series = sections[i].resistance + s * sections[i].inductance;
    r.voltage /= 1.0 + series * shunt;
    r.admittance = shunt / (1.0 + series * shunt);
  }
  return r;
}

std::vector<Section> draw_sections(unsigned seed) {
  std::mt19937 generator(seed);
  std::uniform_real_distribution<double> decades(-1, 1);
  std::vector<Section> sections(2 + seed % 5);
  for (auto& section : sections) {
    section.resistance = 5 * std::pow(10, decades(generator));
    section.inductance = 1e-3 * std::pow(10, decades(generator));
    section.capacitance = 1e-4 * std::pow(10, decades(generator));
  }
  return sections;
}

// The resonances lie around 500 Hz.
std::vector<Complex> sample_points() {
  std::vector<Complex> points;
  for (double hz = 0.1; hz < 1e5; hz *= 2.2) points.emplace_back(0, 2 * std::numbers::pi * hz);
  points.emplace_back(300, 2000);
  return points;
}

constexpr unsigned seeds = 20;

// Voltages come out to some roundings of the source's 1 V, and currents to that over the impedance
// that couples them (the smallest R or sqrt(L/C)), however small they are themselves: at
// low frequency the capacitors let next to nothing through.
double current_tolerance(const std::vector<Section>& sections, Complex current) {
  double impedance = std::numeric_limits<double>::infinity();
  for (const Section& section : sections) {
    impedance = std::min(
        {impedance, section.resistance, std::sqrt(section.inductance / section.capacitance)});
  }
  return 1e-14 / impedance + 1e-12 * std::abs(current);
}

TEST(FrequencyResponse, of_the_descriptor_is_the_ladders_chain_of_impedances) {
  for (unsigned seed = 0; seed < seeds; ++seed) {
    const auto sections = draw_sections(seed);
    const Ladder ladder(sections);
    const NetworkEquations equations(ladder.network);
    for (const Complex s : sample_points()) {
      const Eigen::MatrixXcd x = solve_descriptor(equations.descriptor(), s);
      const ChainResponse expected = respond(sections, s);
      const Complex admittance = -(equations.through(ladder.source).x * x)(0);
      const Complex voltage = (equations.across(ladder.far).x * x)(0);
      EXPECT_LE(std::abs(admittance - expected.admittance), current_tolerance(sections, admittance))
          << seed << " at " << s;
      EXPECT_LE(std::abs(voltage / expected.voltage - 1.0), 1e-12) << seed << " at " << s;
    }
  }
}

// Outputs: the source's current [A] and the far voltage [V].
StateSpace reduce_ladder(const Ladder& ladder) {
  const NetworkEquations equations(ladder.network);
  const Reduction reduction = reduce(equations.descriptor());
  const ReducedForm current = reduction.reduce(equations.through(ladder.source));
  const ReducedForm voltage = reduction.reduce(equations.across(ladder.far));
  StateSpace system{reduction.A, reduction.B, Eigen::MatrixXd(2, reduction.A.rows()),
                    Eigen::MatrixXd(2, 1)};
  system.C << current.state, voltage.state;
  system.D << current.input, voltage.input;
  return system;
}

TEST(HessenbergResponse, agrees_with_the_descriptor_on_random_ladders) {
  for (unsigned seed = 0; seed < seeds; ++seed) {
    const auto sections = draw_sections(seed);
    const Ladder ladder(sections);
    HessenbergResponse response(reduce_ladder(ladder));
    const NetworkEquations equations(ladder.network);
    Eigen::MatrixXcd found;
    for (const Complex s : sample_points()) {
      const Eigen::MatrixXcd x = solve_descriptor(equations.descriptor(), s);
      response.evaluate(s, found);
      ASSERT_EQ(found.rows(), 2);
      ASSERT_EQ(found.cols(), 1);
      const Complex current = (equations.through(ladder.source).x * x)(0);
      const Complex voltage = (equations.across(ladder.far).x * x)(0);
      EXPECT_LE(std::abs(found(0, 0) - current), current_tolerance(sections, current))
          << seed << " at " << s;
      // The orthogonal similarity mixes all states: a voltage is known against the source's 1 V or
      // against itself at a resonance, not against itself where the ladder lets nothing pass.
      EXPECT_LE(std::abs(found(1, 0) - voltage), 1e-12 * std::max(1.0, std::abs(voltage)))
          << seed << " at " << s;
    }
  }
}

TEST(HessenbergResponse, serves_none_one_and_two_states_and_several_inputs) {
  // G = C (sI - A)^-1 B + D by hand for sizes that have no Hessenberg form to speak of.
  const Complex s(0.5, 2);
  Eigen::MatrixXcd found;

  StateSpace gain{Eigen::MatrixXd(0, 0), Eigen::MatrixXd(0, 2), Eigen::MatrixXd(1, 0),
                  Eigen::MatrixXd(1, 2)};
  gain.D << 3, -4;
  HessenbergResponse(gain).evaluate(s, found);
  EXPECT_EQ(found(0, 0), Complex(3));
  EXPECT_EQ(found(0, 1), Complex(-4));

  StateSpace lag{Eigen::MatrixXd::Constant(1, 1, -7), Eigen::MatrixXd::Constant(1, 1, 2),
                 Eigen::MatrixXd::Constant(1, 1, 5), Eigen::MatrixXd::Constant(1, 1, 1)};
  HessenbergResponse(lag).evaluate(s, found);
  EXPECT_LE(std::abs(found(0, 0) - (10.0 / (s + 7.0) + 1.0)), 1e-15);

  // A damped oscillator, position from force and from initial velocity's place.
  StateSpace oscillator{Eigen::MatrixXd(2, 2), Eigen::MatrixXd(2, 2), Eigen::MatrixXd(1, 2),
                        Eigen::MatrixXd::Zero(1, 2)};
  oscillator.A << 0, 1, -40, -0.3;
  oscillator.B << 0, 1, 1, 0;
  oscillator.C << 1, 0;
  HessenbergResponse(oscillator).evaluate(s, found);
  const Complex denominator = s * s + 0.3 * s + 40.0;
  EXPECT_LE(std::abs(found(0, 0) - 1.0 / denominator), 1e-16);
  EXPECT_LE(std::abs(found(0, 1) - (s + 0.3) / denominator), 1e-16);
}

TEST(HessenbergResponse, stays_accurate_where_states_have_units_far_apart) {
  // Two decoupled lags coupled through 1e9 and 1e-9: balancing is what saves the digits.
  StateSpace system{Eigen::MatrixXd(3, 3), Eigen::MatrixXd(3, 1), Eigen::MatrixXd(1, 3),
                    Eigen::MatrixXd::Zero(1, 1)};
  system.A << -1, 1e9, 0, -1e-9, -2, 1e6, 0, 3e-6, -4;
  system.B << 0, 0, 1;
  system.C << 1e-15, 0, 0;
  HessenbergResponse response(system);
  Eigen::MatrixXcd found;
  for (const double omega : {1e-3, 0.7, 2.0, 5.0, 1e3}) {
    const Complex s(0, omega);
    // Chain 3 -> 2 -> 1 with the two products of the loops 1e9 * -1e-9 = -1 and 1e6 * 3e-6 = 3.
    const Complex determinant = (s + 1.0) * ((s + 2.0) * (s + 4.0) - 3.0) + (s + 4.0);
    const Complex expected = 1e-15 * 1e15 / determinant;
    response.evaluate(s, found);
    EXPECT_LE(std::abs(found(0, 0) / expected - 1.0), 1e-13) << omega;
  }
}

}  // namespace
}  // namespace gyrator
