#include "gyrator/studies/spice_check.hpp"

#include "gyrator/core/error.hpp"
#include "gyrator/passivity/port_response.hpp"
#include "gyrator/studies/ngspice.hpp"
#include "gyrator/studies/results.hpp"

#include <algorithm>
#include <cmath>
#include <complex>

#include <fmt/core.h>

namespace gyrator {
namespace {

// Sums of some hundred roundings, magnified where the port's velocity is a small difference.
constexpr double frequency_tolerance = 1e-6;
// ngspice's own: its trapezoidal steps, fifty or more to a sample period.
constexpr double time_tolerance = 1e-4;

void check_columns(const NgspiceTable& table, std::size_t count, const std::string& file) {
  if (table.columns.size() == count && !table.columns[0].empty()) return;
  throw Error(ErrorCode::numerical, "ngspice",
              fmt::format("{} has {} columns where {} belong", file, table.columns.size(), count));
}

SpiceDeviation compare_response(const std::string& quantity, const NgspiceTable& table,
                                std::size_t column, const std::vector<PortResponse>& ours,
                                std::complex<double> PortResponse::*member) {
  SpiceDeviation found{quantity, 0, table.columns[0][0], frequency_tolerance, false};
  for (std::size_t i = 0; i < ours.size(); ++i) {
    const std::complex<double> theirs(table.columns[column][i], table.columns[column + 1][i]);
    const std::complex<double> mine = ours[i].*member;
    const double off = theirs == mine ? 0 : std::abs(theirs - mine) / std::abs(mine);
    if (off <= found.worst || std::isnan(found.worst)) continue;  // a NaN is taken and stays
    found.worst = off;
    found.at = table.columns[0][i];
  }
  return found;
}

SpiceDeviation compare_motion(const std::string& quantity, const NgspiceTable& table,
                              std::size_t column, const Trace& trace, double largest) {
  const auto& time = trace.column("time_s");
  const auto& ours = trace.column(quantity);
  const auto& their_time = table.columns[0];
  const auto& theirs = table.columns[column];
  SpiceDeviation found{quantity, 0, 0, time_tolerance, true};
  // ngspice's first row is its first step, after t = 0.
  for (std::size_t k = 1; k < time.size(); ++k) {
    // It steps onto every sample instant, up to rounding: interpolation only takes that out.
    const auto next = static_cast<std::size_t>(
        std::lower_bound(their_time.begin(), their_time.end() - 1, time[k]) - their_time.begin());
    const std::size_t before = next > 0 ? next - 1 : 0;
    const double span = their_time[next] - their_time[before];
    const double part =
        span > 0 ? std::clamp((time[k] - their_time[before]) / span, 0.0, 1.0) : 1.0;
    const double value = theirs[before] + part * (theirs[next] - theirs[before]);
    const double off = value == ours[k] ? 0 : std::abs(value - ours[k]) / largest;
    if (off <= found.worst || std::isnan(found.worst)) continue;
    found.worst = off;
    found.at = time[k];
  }
  return found;
}

}  // namespace

std::vector<SpiceDeviation> check_spice_deck(const Model& model, const SpiceRequest& request,
                                             const SpiceDeck& deck) {
  const auto tables = run_ngspice(deck.text, {deck.impedance_file, deck.motion_file});
  const NgspiceTable& response = tables[0];
  const NgspiceTable& motion = tables[1];
  check_columns(response, 5, deck.impedance_file);
  check_columns(motion, deck.has_current ? 5 : 4, deck.motion_file);
  const auto ours = compute_port_response(model.device, response.columns[0]);
  std::vector<SpiceDeviation> found{
      compare_response("impedance", response, 1, ours, &PortResponse::impedance),
      compare_response("actuation", response, 3, ours, &PortResponse::actuation)};

  // What rings between the samples may be far larger than what is left of it there.
  SimulationRequest fine;
  fine.duration = request.duration;
  fine.trace_step = model.sampling.period / Rational(16);
  const TimeRun run = run_simulation(model, fine);
  const auto compare = [&](const std::string& quantity, std::size_t column) {
    double largest = 0;
    for (const double value : run.trace.column(quantity))
      largest = std::max(largest, std::abs(value));
    found.push_back(compare_motion(quantity, motion, column, deck.run.trace, largest));
  };
  compare("position", 1);
  compare("velocity", 2);
  if (deck.has_current) compare("current", 4);
  return found;
}

}  // namespace gyrator
