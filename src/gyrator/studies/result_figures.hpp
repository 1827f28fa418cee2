#pragma once

#include "gyrator/plots/plot.hpp"

#include <string>
#include <vector>

#include <nlohmann/json.hpp>

namespace gyrator {

// The figures of the commands' JSON results; the same ones for --svg, --png and the report.
// Labels take their units from the result's "units". Each throws bad_input, naming the command
// and the key, where a key is missing or of the wrong kind; a null in an array breaks the line.

/// |Z| and Re Z, then |A| and the phase of A, over frequency. Negative Re Z (an active
/// frequency) is shown as its magnitude in vermillion.
Figure impedance_figure(const nlohmann::json& result);

/// Damping over frequency on a logarithmic and a linear axis, up to the Nyquist frequency, with
/// the zero line; the disk of loop responses at the worst frequency with the critical point −1/H;
/// and the counterexample's run. The last two only where the result has them.
Figure passivity_figure(const nlohmann::json& result);

/// Largest stiffness over virtual damping, one boundary per criterion, and the model's point.
Figure zwidth_figure(const nlohmann::json& result);
/// The cells of a boundary by time, one filled curve per outcome.
std::vector<Curve> time_map_cells(const nlohmann::json& boundary);

/// Position, velocity, effort and (where booked) energy over time, one under the other.
Figure simulate_figure(const nlohmann::json& result);

/// Largest passive stiffness over virtual damping, one curve for each design.
Figure comparison_figure(const nlohmann::json& result);

/// Simulated regions over the plane of damping and dry friction, with the analytic borders.
Figure stability_map_figure(const nlohmann::json& result);

/// Histogram of the passive limit over the tolerances, with the nominal, the worst and the model's
/// own stiffness; and what each part does alone, as bars.
Figure tolerance_figure(const nlohmann::json& result);
/// The left sides of Llewellyn's conditions and |Z_te/Z_e| over frequency, one curve for each
/// rendering.
Figure two_port_figure(const nlohmann::json& result);

/// What the textbook criterion misses: the boundaries in the K–B plane with the model's own
/// point, and the run of the operator that makes the loop diverge in between. `zwidth` may be
/// null, and the passivity result without counterexample; at least one must be there.
Figure finding_figure(const nlohmann::json& passivity, const nlohmann::json& zwidth);

/// The figure of any command's result, by its "command". Throws bad_input, listing the known
/// ones, for another.
Figure result_figure(const nlohmann::json& result);

/// The commands whose results have a figure and a section in the report.
std::vector<std::string> known_result_commands();

}  // namespace gyrator
