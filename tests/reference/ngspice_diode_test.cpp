#include "gyrator/circuits/operating_point.hpp"

#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "support/scratch_folder.hpp"

// A diode clamp beside ngspice: the same circuit, solved by a simulator that shares no code.

namespace gyrator {
namespace {

constexpr double boltzmann_over_charge = 8.617333262e-5;  // [V/K]
constexpr double ngspice_temperature = 300.15;            // its default, 27 degrees Celsius [K]

// Source - 1 kohm - out; out - diode - 2 V supply; ground - diode - out; 10 kohm at out.
double solve_here(double source) {
  Network network;
  const NodeId in = network.add_node("in", Domain::electrical);
  const NodeId out = network.add_node("out", Domain::electrical);
  const NodeId supply = network.add_node("supply", Domain::electrical);
  const Diode diode{.saturation_current = 1e-14,
                    .emission_voltage = 1.2 * boltzmann_over_charge * ngspice_temperature};
  network.add("source", in, ground, ConstantVoltageSource{source});
  network.add("supply", supply, ground, ConstantVoltageSource{2});
  network.add("series", in, out, Resistor{1e3});
  network.add("load", out, ground, Resistor{1e4});
  network.add("upper", out, supply, diode);
  network.add("lower", ground, out, diode);
  return find_operating_point(network).unknowns(out.index - 1);
}

std::vector<double> solve_by_ngspice(const std::filesystem::path& folder, double from, double to,
                                     double step) {
  const std::filesystem::path netlist = folder / "clamp.cir";
  const std::filesystem::path table = folder / "clamp.txt";
  std::ofstream(netlist) << "diode clamp\nV1 in 0 0\nV2 supply 0 2\nR1 in out 1k\nR2 out 0 10k\n"
                            "D1 out supply d\nD2 0 out d\n.model d D(IS=1e-14 N=1.2)\n"
                            ".options reltol=1e-10 vntol=1e-13 abstol=1e-16\n.control\n"
                         << "set numdgt=15\ndc V1 " << from << ' ' << to << ' ' << step
                         << "\nwrdata " << table.string() << " v(out)\nquit\n.endc\n.end\n";
  const std::string command = "ngspice -b " + netlist.string() + " > /dev/null 2>&1";
  if (std::system(command.c_str()) != 0) return {};
  std::ifstream file(table);
  std::vector<double> values;
  for (double v = 0, out = 0; file >> v >> out;) values.push_back(out);
  return values;
}

TEST(NgspiceDiode, a_clamp_of_two_diodes_rests_where_ngspice_says) {
  if (std::system("command -v ngspice > /dev/null") != 0)
    GTEST_SKIP() << "ngspice is not installed";
  const ScratchFolder scratch;
  const std::vector<double> expected = solve_by_ngspice(scratch.path(), -10, 10, 0.5);
  ASSERT_EQ(expected.size(), 41u);
  for (std::size_t k = 0; k < expected.size(); ++k) {
    const double source = -10 + 0.5 * static_cast<double>(k);
    // ngspice's Newton stops at 1e-10 of a voltage; its k/q differs in the seventh digit.
    EXPECT_NEAR(solve_here(source), expected[k], 1e-6) << source;
  }
}

}  // namespace
}  // namespace gyrator
