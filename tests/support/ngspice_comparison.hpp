#pragma once

#include "gyrator/circuits/descriptor.hpp"
#include "gyrator/circuits/reduction.hpp"
#include "gyrator/circuits/spice_writer.hpp"
#include "gyrator/circuits/state_space.hpp"
#include "gyrator/studies/ngspice.hpp"

#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include <fmt/core.h>

// A network in ngspice beside ourselves: every node's voltage over frequency, and over time under a
// held random input.

namespace gyrator::testing {

struct NgspiceAnalysis {
  double from_hz = 1, to_hz = 1e5;
  int points_per_decade = 3;
  double period = 1e-3;           ///< of the held input [s]
  std::vector<double> held = {};  ///< its values, from t = 0; empty for no transient
  double largest_step = 1e-5;     ///< [s]
};

/// An edge of the held input lasts so many periods; ours jumps in the middle of it, which differs
/// in the second order only.
inline constexpr double edge_periods = 1e-4;

struct NgspiceDeviation {
  double response = 0;     ///< of the node's magnitude, no smaller than 1e-3 of the largest node's
  double motion = 0;       ///< of the node's largest over the run
  int compared_nodes = 0;  ///< over time: those without an impulse at a step of the input
};

inline std::string write_comparison_deck(const Network& network, const NgspiceAnalysis& analysis) {
  // Input i has 1/(i + 1) in AC; all are held together in the transient.
  const double edge = edge_periods * analysis.period;
  SpiceOptions options;
  for (std::size_t i = 0; i < network.inputs().size(); ++i) {
    std::string text = fmt::format("DC 0 AC {:.17g}", 1.0 / static_cast<double>(i + 1));
    double before = 0;
    if (!analysis.held.empty()) text += " PWL(";
    for (std::size_t k = 0; k < analysis.held.size(); ++k) {
      const double t = static_cast<double>(k) * analysis.period;
      const double value = analysis.held[k];
      text += fmt::format("\n+ {:.17g} {:.17g} {:.17g} {:.17g} {:.17g} {:.17g}", t, before,
                          t + edge, value, t + analysis.period / 2, value);
      before = value;
    }
    if (!analysis.held.empty()) {
      text += fmt::format("\n+ {:.17g} {:.17g})",
                          static_cast<double>(analysis.held.size()) * analysis.period, before);
    }
    options.inputs.push_back(text);
  }
  const SpiceNetlist netlist = write_spice_netlist(network, options);
  std::string nodes;
  for (std::size_t i = 1; i < netlist.nodes.size(); ++i) nodes += " v(" + netlist.nodes[i] + ")";
  // Gear's rule, since the trapezoidal one rings in the voltages of inductors after an edge. Steps
  // are set by largest_step, not by ngspice's estimate of its error, which rounding spoils on
  // the short steps after an edge.
  std::string deck = "comparison\n" + netlist.lines;
  deck += fmt::format(
      ".options noopac method=gear reltol=1e-4 abstol=1e-6 trtol=1e3 minbreak={:.17g}\n"
      ".control\nset numdgt=16\nset wr_singlescale\nset wr_vecnames\n"
      "ac dec {} {:.17g} {:.17g}\nwrdata response.data{}\n",
      edge / 100, analysis.points_per_decade, analysis.from_hz, analysis.to_hz, nodes);
  if (!analysis.held.empty()) {
    deck += fmt::format("tran {0:.17g} {1:.17g} 0 {0:.17g} uic\nwrdata motion.data{2}\n",
                        analysis.largest_step,
                        static_cast<double>(analysis.held.size()) * analysis.period, nodes);
  }
  return deck + "quit\n.endc\n.end\n";
}

inline double compare_response(const NetworkEquations& equations, const NgspiceTable& table) {
  const Descriptor& d = equations.descriptor();
  Eigen::VectorXd inputs(d.B.cols());
  for (Eigen::Index i = 0; i < inputs.size(); ++i) inputs(i) = 1.0 / static_cast<double>(i + 1);
  const auto nodes = static_cast<Eigen::Index>(equations.network().nodes().size()) - 1;
  double worst = 0;
  for (std::size_t row = 0; row < table.columns[0].size(); ++row) {
    const double omega = 2 * std::numbers::pi * table.columns[0][row];
    const Eigen::VectorXcd ours = solve_descriptor(d, {0, omega}) * inputs;
    const double largest = ours.head(nodes).cwiseAbs().maxCoeff();
    for (Eigen::Index node = 0; node < nodes; ++node) {
      const auto column = static_cast<std::size_t>(1 + 2 * node);
      const std::complex<double> theirs(table.columns[column][row], table.columns[column + 1][row]);
      const double off =
          std::abs(theirs - ours(node)) / std::max(std::abs(ours(node)), 1e-3 * largest);
      if (!(off <= worst)) worst = off;  // a NaN is taken
    }
  }
  return worst;
}

// The reduced network under the held input, exact between its steps, on twenty points a period.
inline std::pair<double, int> compare_motion(const NetworkEquations& equations,
                                             const NgspiceTable& table,
                                             const NgspiceAnalysis& analysis) {
  constexpr int points = 20;  // even: ngspice steps onto the middle and the end of a period
  const Reduction reduction = reduce(equations.descriptor());
  const Eigen::VectorXd ones = Eigen::VectorXd::Ones(reduction.B.cols());
  const double late = edge_periods * analysis.period / 2;
  const Eigen::MatrixXd B = reduction.B * ones;
  const HeldStep step = discretize_held(reduction.A, B, analysis.period / points);
  const HeldStep before = discretize_held(reduction.A, B, late);
  const HeldStep after = discretize_held(reduction.A, B, analysis.period / points - late);
  std::vector<ReducedForm> forms;
  const auto nodes = static_cast<int>(equations.network().nodes().size());
  for (int node = 1; node < nodes; ++node)
    forms.push_back(reduction.reduce(equations.across(NodeId{node})));
  std::vector<double> largest(forms.size(), 0);
  std::vector<double> off(forms.size(), 0);
  Eigen::VectorXd w = Eigen::VectorXd::Zero(reduction.A.rows());
  const auto& time = table.columns[0];
  for (std::size_t k = 0; k < analysis.held.size(); ++k) {
    for (int i = 1; i <= points; ++i) {
      const Eigen::VectorXd held = Eigen::VectorXd::Constant(1, analysis.held[k]);
      if (i == 1) {
        const double last = k > 0 ? analysis.held[k - 1] : 0;
        w = before.phi * w + before.gamma * Eigen::VectorXd::Constant(1, last);
      }
      const HeldStep& by = i == 1 ? after : step;
      w = by.phi * w + by.gamma * held;
      const double t = (static_cast<double>(k) + static_cast<double>(i) / points) * analysis.period;
      auto at = static_cast<std::size_t>(
          std::lower_bound(time.begin(), time.end() - 1, t * (1 - 1e-12)) - time.begin());
      for (std::size_t f = 0; f < forms.size(); ++f) {
        const double ours = forms[f].state.dot(w) + forms[f].input.sum() * analysis.held[k];
        largest[f] = std::max(largest[f], std::abs(ours));
        if (i % (points / 2) != 0) continue;
        off[f] = std::max(off[f], std::abs(table.columns[f + 1][at] - ours));
      }
    }
  }
  double worst = 0;
  int compared = 0;
  const double most = *std::max_element(largest.begin(), largest.end());
  for (std::size_t f = 0; f < forms.size(); ++f) {
    const bool has_impulse = forms[f].input_rate.cwiseAbs().maxCoeff() > 1e-12;
    if (has_impulse) continue;
    ++compared;
    if (off[f] > 0) worst = std::max(worst, off[f] / std::max(largest[f], 1e-3 * most));
  }
  return {worst, compared};
}

/// Throws bad_input, saying how to install it, where ngspice is missing.
inline NgspiceDeviation compare_with_ngspice(const Network& network,
                                             const NgspiceAnalysis& analysis) {
  std::vector<std::string> files{"response.data"};
  if (!analysis.held.empty()) files.emplace_back("motion.data");
  const auto tables = run_ngspice(write_comparison_deck(network, analysis), files);
  const NetworkEquations equations(network);
  NgspiceDeviation found;
  found.response = compare_response(equations, tables[0]);
  if (!analysis.held.empty()) {
    std::tie(found.motion, found.compared_nodes) = compare_motion(equations, tables[1], analysis);
  }
  return found;
}

}  // namespace gyrator::testing
