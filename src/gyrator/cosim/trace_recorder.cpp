#include "gyrator/cosim/trace_recorder.hpp"

#include "gyrator/core/error.hpp"

#include <algorithm>

#include <fmt/core.h>
#include <fmt/ranges.h>

namespace gyrator {

const std::vector<double>& Trace::column(const std::string& name) const {
  const auto it = std::find(names.begin(), names.end(), name);
  if (it == names.end()) {
    throw Error(ErrorCode::bad_input, "trace",
                fmt::format("no column \"{}\": there are {}", name, fmt::join(names, ", ")));
  }
  return columns[static_cast<std::size_t>(it - names.begin())];
}

TraceRecorder::TraceRecorder(const Plant& plant, Engine& engine,
                             const RunningController& controller, Trace& trace, Options options)
    : plant_(plant), engine_(engine), controller_(controller), trace_(trace), options_(options) {
  auto& names = trace_.names;
  names = {"time_s", "position", "velocity", "effort", "command"};
  for (const auto& signal : plant.others) names.push_back(signal.name);
  const bool wave = plant.sensor_position.name == wave_integral_name;
  names.insert(names.end(), {wave ? "measured_wave_integral" : "measured_position", "held_command",
                             "held_command_after"});
  for (const auto& signal : plant.others) {
    if (jumps(signal)) names.push_back(signal.name + "_after");
  }
  if (jumps(plant.port_effort)) names.emplace_back("effort_after");
  if (options_.external_effort) names.emplace_back("external_effort");
  if (options_.ledger) {
    names.insert(names.end(),
                 {"energy_operator", "energy_source", "energy_stored", "energy_dissipated"});
  }
  const auto told = controller.signal_names();
  names.insert(names.end(), told.begin(), told.end());
  told_.resize(told.size());
  trace_.columns.assign(names.size(), {});
  z_.resize(plant.states() + plant.inputs());
}

// Whether a step of the command shows in a signal at once.
bool TraceRecorder::jumps(const Signal& signal) const {
  if (signal.input(0) != 0) return true;
  return plant_.nonlinear && !signal.input.segment(2, signal.input.size() - 3).isZero(0);
}

void TraceRecorder::reserve(std::size_t rows) {
  for (auto& column : trace_.columns) column.reserve(rows);
}

double TraceRecorder::row_size() const {
  return static_cast<double>(trace_.names.size() * sizeof(double));
}

double TraceRecorder::stored(const Eigen::Vector2d& u, const PlantState& state) {
  z_ << state.xi, engine_.inputs(u, state);
  return z_.dot(plant_.energy.stored * z_);
}

void TraceRecorder::record(const TraceRow& row, const Eigen::Vector2d& u, const PlantState& state) {
  std::size_t at = 0;
  const auto put = [&](double value) { trace_.columns[at++].push_back(value); };
  before_ = engine_.inputs(u, state);
  after_ = engine_.inputs(Eigen::Vector2d(row.held_after, u(1)), state);
  const auto value = [&](const Signal& s, bool after) {
    return s.value(state.xi, after ? after_ : before_);
  };
  put(row.time);
  put(value(plant_.port_position, false));
  put(value(plant_.port_velocity, false));
  put(value(plant_.port_effort, false));
  put(row.command);
  for (const auto& signal : plant_.others) put(value(signal, false));
  put(row.measured);
  put(u(0));
  put(row.held_after);
  for (const auto& signal : plant_.others) {
    if (jumps(signal)) put(value(signal, true));
  }
  if (jumps(plant_.port_effort)) put(value(plant_.port_effort, true));
  if (options_.external_effort) put(u(1));
  if (options_.ledger) {
    put(state.operator_work);
    put(state.source_work);
    put(stored(u, state));
    put(state.dissipated);
  }
  controller_.read_signals(told_);
  for (const double told : told_) put(told);
}

}  // namespace gyrator
