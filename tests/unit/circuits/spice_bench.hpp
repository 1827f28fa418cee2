#pragma once

#include "gyrator/circuits/descriptor.hpp"
#include "gyrator/circuits/spice_subcircuit.hpp"
#include "gyrator/core/error.hpp"

#include <complex>
#include <numbers>
#include <string>
#include <string_view>

#include <gtest/gtest.h>

namespace gyrator {

/// Impedance between the two pins of a circuit [ohm], the second at ground.
inline std::complex<double> compute_impedance(const SpiceCircuit& circuit, std::complex<double> s) {
  Network network;
  const NodeId terminal = network.add_node("terminal", Domain::electrical);
  network.add("drive", ground, terminal, CurrentSource{network.add_input("current")});
  add_subcircuit(network, circuit, "circuit", {terminal, ground});
  const NetworkEquations equations(network);
  return (equations.across(terminal).x * solve_descriptor(equations.descriptor(), s))(0);
}

/// A subcircuit SNUB with pins a and b around the lines, in a file "test.cir" whose line 2 is the
/// first of them.
inline SpiceCircuit read_lines(const std::string& lines, const SpiceReadOptions& options = {}) {
  return parse_subcircuit(".subckt SNUB a b\n" + lines + "\n.ends\n", "test.cir", "SNUB", options);
}

inline std::complex<double> s_of(double hz) {
  return {0, 2 * std::numbers::pi * hz};
}

/// The text of the refusal, which must be bad_input.
template <class Act>
std::string refusal(Act act) {
  try {
    act();
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::bad_input);
    return error.what();
  }
  return "accepted";
}

inline std::string refuse_lines(const std::string& lines, const SpiceReadOptions& options = {}) {
  return refusal([&] { read_lines(lines, options); });
}

/// Whether the text mentions all of the parts.
inline testing::AssertionResult mentions(std::string_view text,
                                         std::initializer_list<std::string_view> parts) {
  for (const std::string_view part : parts) {
    if (text.find(part) == std::string_view::npos) {
      return testing::AssertionFailure() << "no '" << part << "' in: " << text;
    }
  }
  return testing::AssertionSuccess();
}

/// |found - expected| <= tolerance |expected|
inline testing::AssertionResult is_near(std::complex<double> found, std::complex<double> expected,
                                        double tolerance) {
  if (std::abs(found - expected) <= tolerance * std::abs(expected)) {
    return testing::AssertionSuccess();
  }
  return testing::AssertionFailure() << found << " instead of " << expected;
}

}  // namespace gyrator
