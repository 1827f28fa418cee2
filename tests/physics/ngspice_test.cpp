#include "gyrator/circuits/descriptor.hpp"
#include "gyrator/circuits/reduction.hpp"
#include "gyrator/circuits/state_space.hpp"
#include "gyrator/core/error.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

#include "support/ngspice_comparison.hpp"
#include "support/random_networks.hpp"

// Two hundred random networks in ngspice and in ours: what the netlist says is what we compute.

namespace gyrator {
namespace {

using testing::NgspiceAnalysis;
using testing::NgspiceDeviation;

// Both solve the same equations; what is lost is rounding times the equations' condition.
constexpr double response_tolerance = 1e-6;
// Gear's second-order rule at 0.5 % of a time constant per step: (0.005)^2 / 3 for each, of some.
constexpr double motion_tolerance = 1e-4;

// Frequencies where the network's poles are. Over time, held inputs for a few to a hundred time
// constants of its fastest pole, of which every step is 0.5 %; only where all poles are stable and
// none is so fast that it can only be rounding (an infinite one, met once).
NgspiceAnalysis choose_analysis(const Network& network, std::uint64_t seed) {
  constexpr double radians_per_step = 0.005;
  constexpr int periods = 6;
  testing::Draw draw(seed + 1000);
  NgspiceAnalysis analysis;
  const Eigen::MatrixXd A = reduce(NetworkEquations(network).descriptor()).A;
  double typical = 1e4;
  double fastest = 1e4;
  if (A.rows() > 0) {
    const Eigen::VectorXcd poles = compute_poles(A);
    typical = std::exp(poles.cwiseAbs().array().max(1e-3).log().mean());
    fastest = poles.cwiseAbs().maxCoeff();
    if (poles.real().maxCoeff() > 1e-9 * fastest || fastest > 1e12) typical = 0;
    if (fastest < 1) typical = fastest = 1e4;  // integrators alone
  }
  const bool stable = typical > 0;
  analysis.from_hz = (stable ? typical : fastest) / 200;
  analysis.to_hz = (stable ? typical : fastest) * 5;
  analysis.period = draw.decades(1, 20) / fastest;
  analysis.largest_step = radians_per_step / fastest;
  for (int k = 0; k < periods && stable; ++k) analysis.held.push_back(draw.between(-1, 1));
  return analysis;
}

TEST(Ngspice, agrees_on_two_hundred_random_networks_over_frequency_and_over_time) {
  constexpr std::uint64_t count = 200;
  int with_motion = 0;
  double worst_response = 0;
  double worst_motion = 0;
  for (std::uint64_t seed = 0; seed < count; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    const Network network = testing::make_random_network(seed);
    const NgspiceAnalysis analysis = choose_analysis(network, seed);
    const NgspiceDeviation found = testing::compare_with_ngspice(network, analysis);
    EXPECT_LE(found.response, response_tolerance);
    EXPECT_LE(found.motion, motion_tolerance);
    with_motion += found.compared_nodes > 0 ? 1 : 0;
    worst_response = std::max(worst_response, found.response);
    worst_motion = std::max(worst_motion, found.motion);
  }
  EXPECT_GE(with_motion, count * 9 / 10);
  RecordProperty("worst_response", fmt::format("{:.2e}", worst_response));
  RecordProperty("worst_motion", fmt::format("{:.2e}", worst_motion));
}

}  // namespace
}  // namespace gyrator
