#include "gyrator/circuits/operating_point.hpp"

#include "gyrator/circuits/descriptor.hpp"
#include "gyrator/core/error.hpp"

#include <cmath>
#include <string>

#include <boost/math/special_functions/lambert_w.hpp>
#include <gtest/gtest.h>

namespace gyrator {
namespace {

// V - R - diode to ground; the diode is element 2.
Network make_diode_circuit(double voltage, double resistance, const Diode& diode) {
  Network network;
  const NodeId source = network.add_node("source", Domain::electrical);
  const NodeId anode = network.add_node("anode", Domain::electrical);
  network.add("supply", source, ground, ConstantVoltageSource{voltage});
  network.add("resistor", source, anode, Resistor{resistance});
  network.add("diode", anode, ground, diode);
  return network;
}

TEST(OperatingPoint, of_a_diode_behind_a_resistor_is_lamberts) {
  const Diode diode{.saturation_current = 3e-12, .emission_voltage = 0.03};
  for (const double V : {0.1, 0.7, 5.0, 12.0}) {
    for (const double R : {1.0, 1e3, 1e6}) {
      const OperatingPoint point = find_operating_point(make_diode_circuit(V, R, diode));
      // i = (V_e/R) W((I_s R/V_e) e^((V + I_s R)/V_e)) - I_s
      const double I = diode.saturation_current;
      const double U = diode.emission_voltage;
      const double i = U / R * boost::math::lambert_w0(I * R / U * std::exp((V + I * R) / U)) - I;
      const double v = V - R * i;
      // The difference V - R i loses what V is larger than v; gmin takes v times 1e-12 S.
      const double known_to = 1e-13 * V + 1e-12 * v * std::min(R, U / i);
      EXPECT_NEAR(point.arguments[0], v, known_to) << V << " V, " << R << " ohm";
      EXPECT_NEAR(point.slopes[2], (i + I) / U, (i + I) / U * 2 * known_to / U) << V << ", " << R;
    }
  }
}

TEST(OperatingPoint, gives_the_linear_equations_the_slope_there) {
  const Diode diode;
  Network network = make_diode_circuit(2, 100, diode);
  const int input = network.add_input("probe");
  const NodeId anode = *network.find_node("anode");
  network.add("probe", ground, anode, CurrentSource{input});
  const NetworkEquations equations(network);
  const Eigen::MatrixXcd x = solve_descriptor(equations.descriptor(), 0.0);
  ASSERT_EQ(x.cols(), 1);
  const double slope = find_operating_point(network).slopes[2];
  EXPECT_GT(slope, 0.1);  // some 13 mA over 26 mV
  const double resistance = (equations.across(anode).x * x.col(0))(0).real();
  EXPECT_NEAR(resistance * (slope + 1.0 / 100), 1, 1e-12);
}

TEST(OperatingPoint, is_zero_without_constant_sources) {
  Network network;
  const NodeId node = network.add_node("node", Domain::electrical);
  network.add("diode", node, ground, Diode{});
  network.add("clamp", node, ground, VoltageClamp{5, 0.1});
  network.add("capacitor", node, ground, Capacitor{1e-6});
  const OperatingPoint point = find_operating_point(network);
  EXPECT_EQ(point.arguments, (std::vector<double>{0, 0}));
  EXPECT_NEAR(point.slopes[0], 1e-14 / 0.025852, 1e-18);
  EXPECT_EQ(point.slopes[1], 0);
}

TEST(OperatingPoint, saturates_an_amplifier_and_says_how_far_its_gain_holds) {
  // A follower by an amplifier of 1e5 and 12 V, asked for 15 V: at its limit, without gain.
  for (const double asked : {3.0, 15.0}) {
    Network network;
    const NodeId in = network.add_node("in", Domain::electrical);
    const NodeId out = network.add_node("out", Domain::electrical);
    network.add("input", in, ground, ConstantVoltageSource{asked});
    network.add("amplifier", out, ground, LimitedVoltageControlledVoltageSource{1e5, 12, in, out});
    network.add("load", out, ground, Resistor{1e3});
    const OperatingPoint point = find_operating_point(network);
    const bool saturated = asked > 12;
    const double expected = saturated ? 12 : asked * 1e5 / (1e5 + 1);
    EXPECT_NEAR(point.unknowns(out.index - 1), expected, 1e-9) << asked;  // 1e5 * rounding * 12 V
    EXPECT_EQ(point.slopes[1], saturated ? 0 : 1e5) << asked;
    const auto ranges = find_linear_ranges(network);
    ASSERT_EQ(ranges.size(), 1u);
    if (saturated) {
      EXPECT_NEAR(ranges[0].from, 12e-5, 1e-15);
      EXPECT_EQ(ranges[0].to, INFINITY);
    } else {
      EXPECT_NEAR(ranges[0].to, 12e-5, 1e-15);
      EXPECT_NEAR(ranges[0].from, -12e-5, 1e-15);
    }
  }
}

TEST(OperatingPoint, keeps_a_node_between_two_clamps_by_their_leaks) {
  Network network;
  const int input = network.add_input("voltage");
  const NodeId top = network.add_node("top", Domain::electrical);
  const NodeId middle = network.add_node("middle", Domain::electrical);
  network.add("source", top, ground, VoltageSource{input});
  network.add("upper", top, middle, VoltageClamp{5, 0.1});
  network.add("lower", middle, ground, VoltageClamp{5, 0.1});
  const NetworkEquations equations(network);
  const Eigen::MatrixXcd x = solve_descriptor(equations.descriptor(), 0.0);
  EXPECT_NEAR((equations.across(middle).x * x.col(0))(0).real(), 0.5, 1e-12);
}

TEST(OperatingPoint, holds_what_moves_at_rest) {
  // A biased motor: its current is V/R although the shaft is free to run.
  Network network;
  const NodeId terminal = network.add_node("terminal", Domain::electrical);
  const NodeId emf = network.add_node("emf", Domain::electrical);
  const NodeId shaft = network.add_node("shaft", Domain::mechanical);
  network.add("supply", terminal, ground, ConstantVoltageSource{6});
  const ElementId winding = network.add("winding", terminal, emf, Resistor{3});
  network.add("motor", emf, ground, Transformer{0.05, shaft, ground});
  network.add("inertia", shaft, ground, Capacitor{1e-5});
  network.add("brake", shaft, ground, SaturatingConductance{1e-3, 0.01});
  const OperatingPoint point = find_operating_point(network);
  const NetworkEquations equations(network);
  EXPECT_NEAR(equations.through(winding).x * point.unknowns, 2, 1e-12);
  EXPECT_EQ(point.arguments[0], 0);
}

TEST(OperatingPoint, refuses_a_bias_that_never_comes_to_rest_by_name) {
  Network network;
  const NodeId node = network.add_node("node", Domain::electrical);
  network.add("bias", ground, node, ConstantCurrentSource{1});
  network.add("store", node, ground, Capacitor{1e-6});
  try {
    (void)find_operating_point(network);
    ADD_FAILURE() << "a current into a capacitor has no steady state";
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::numerical);
    EXPECT_NE(error.place().find("bias"), std::string::npos) << error.place();
  }
}

}  // namespace
}  // namespace gyrator
