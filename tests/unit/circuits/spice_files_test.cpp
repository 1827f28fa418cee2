#include "gyrator/circuits/spice_subcircuit.hpp"

#include <cstdint>
#include <filesystem>
#include <random>
#include <string>
#include <vector>

#include "support/scratch_folder.hpp"
#include "unit/circuits/spice_bench.hpp"

// Files as KiCad and LTspice write them, and what becomes of them when they are damaged.

namespace gyrator {
namespace {

using Complex = std::complex<double>;

const std::filesystem::path folder = "tests/data/spice";

Complex parallel(Complex x, Complex y) {
  return x * y / (x + y);
}

TEST(SpiceFiles, a_netlist_of_kicad_has_its_impedance) {
  const SpiceCircuit circuit = read_subcircuit(folder / "kicad_snubber.cir", "snubber");
  check_two_terminals(circuit);
  for (const double hz : {1.0, 100.0, 1e4, 1e6}) {
    const Complex s = s_of(hz);
    const Complex snubber = 4.7 + 1.0 / (220e-6 * s);
    const Complex choke = parallel(2.2e-3 * s + 0.15, 1.0 / (5e-9 * s));
    // Six elements; node admittances of up to 1e7 to one lose that much of 1e-16 at 1 MHz.
    EXPECT_TRUE(is_near(compute_impedance(circuit, s), parallel(snubber, choke + 33.0), 1e-12))
        << hz;
  }
}

TEST(SpiceFiles, a_netlist_of_ltspice_has_its_impedance) {
  const SpiceCircuit circuit = read_subcircuit(folder / "ltspice_coupled.net", "damp");
  check_two_terminals(circuit);
  for (const double hz : {1.0, 100.0, 1e4}) {
    const Complex s = s_of(hz);
    // Both windings with their resistance; the second is closed by the capacitor and its own. The
    // instance's Kc = 0.95 is not this circuit's, whose Kc is the global 0.5.
    const double mutual = 0.5 * std::sqrt(10e-3 * 2.5e-3);
    const Complex first = 10e-3 * s + 1.5;
    const Complex second = 2.5e-3 * s + 0.75 + 0.02 + 1.0 / (47e-6 * s);
    const Complex transformed = first - mutual * mutual * s * s / second;
    const Complex load = parallel(4.7e3, 1e6);
    EXPECT_TRUE(is_near(compute_impedance(circuit, s), transformed + load, 1e-12)) << hz;
  }
}

TEST(SpiceFiles, a_netlist_in_utf16_with_op_amps_has_its_impedance) {
  const SpiceCircuit circuit =
      read_subcircuit(folder / "ltspice_gyrator.net", "simulated_inductor");
  check_two_terminals(circuit);
  EXPECT_EQ(circuit.place, (folder / "ltspice_gyrator.net").string() + ":5");
  for (const double hz : {10.0, 1e3, 1e5}) {
    const Complex s = s_of(hz);
    // Z = s R^2 C with ideal op-amps. A gain of A leaves an error of 2 q / A, q the largest ratio
    // of two impedances of the chain; the tolerance is twice that.
    const double ratio = std::abs(1e3 * 1e-6 * s);
    const double tolerance = 4 * std::max(ratio, 1 / ratio) / 1e9;
    EXPECT_TRUE(is_near(compute_impedance(circuit, s), 1e3 * 1e3 * 1e-6 * s, tolerance)) << hz;
  }
}

// A change that a slip of an editor, a transfer or a merge could make.
std::string damage(std::string text, std::mt19937& random) {
  const auto below = [&](std::size_t end) { return end == 0 ? 0 : random() % end; };
  const int changes = 1 + static_cast<int>(below(4));
  for (int i = 0; i < changes; ++i) {
    const std::size_t at = below(text.size());
    const std::size_t length = std::min(below(40), text.size() - at);
    const std::size_t line = text.find('\n', at) == std::string::npos ? 0 : text.find('\n', at);
    const std::size_t next = std::min(text.find('\n', line + 1), text.size());
    switch (below(7)) {
      case 0:
        if (!text.empty()) text[at] = static_cast<char>(below(256));
        break;
      case 1:
        text.erase(at, length);
        break;
      case 2:
        text.insert(below(text.size()), text.substr(at, length));
        break;
      case 3:  // a line away
        text.erase(line, next - line);
        break;
      case 4:  // a line twice, elsewhere
        text.insert(line, text.substr(line, next - line));
        break;
      case 5: {
        constexpr std::string_view pieces[] = {
            "{", "}",     "'",   "=",         "(",   ")",   "+",       "**",
            "-", "1e999", "\n+", "\n.ends\n", " 0 ", "X1 ", "poly(1)", "params:"};
        text.insert(at, pieces[below(std::size(pieces))]);
        break;
      }
      default:
        text.resize(at);
    }
  }
  return text;
}

TEST(SpiceFiles, damaged_files_are_read_or_refused_and_nothing_else) {
  constexpr int trials = 1500;
  int accepted = 0;
  int refused = 0;
  for (const char* name : {"kicad_snubber.cir", "ltspice_coupled.net", "ltspice_gyrator.net"}) {
    const std::string text = read_text(folder / name);
    for (std::uint32_t seed = 0; seed < trials; ++seed) {
      std::mt19937 random(seed);
      const std::string damaged = damage(text, random);
      try {
        const SpiceCircuit circuit =
            parse_subcircuit(damaged, folder / name,
                             seed % 4 == 0 ? ""
                                           : (name[0] == 'k'   ? "snubber"
                                              : name[8] == 'c' ? "damp"
                                                               : "simulated_inductor"),
                             {.allow_negative = seed % 2 == 0});
        if (circuit.pin_count == 2) compute_impedance(circuit, s_of(123));
        ++accepted;
      } catch (const Error& error) {
        ++refused;
        EXPECT_FALSE(error.place().empty()) << error.what();
        EXPECT_FALSE(error.message().empty()) << error.what();
      }
    }
  }
  // Both happen often: neither the damage nor the reader is trivial.
  EXPECT_GT(accepted, trials / 4);
  EXPECT_GT(refused, trials / 4);
}

}  // namespace
}  // namespace gyrator
