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
    if (jumps(signal)) jumping_.push_back(&signal);
  }
  if (jumps(plant.port_effort)) jumping_.push_back(&plant.port_effort);
  for (const Signal* signal : jumping_)
    names.push_back((signal == &plant.port_effort ? "effort" : signal->name) + "_after");
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
  return stored_under(engine_.inputs(u, state), state);
}

double TraceRecorder::stored_under(const Eigen::VectorXd& inputs, const PlantState& state) {
  z_ << state.xi, inputs;
  gradient_.noalias() = plant_.energy.stored * z_;
  return z_.dot(gradient_);
}

void TraceRecorder::record(const TraceRow& row, const Eigen::Vector2d& u, const PlantState& state) {
  std::size_t at = 0;
  const auto put = [&](double value) { trace_.columns[at++].push_back(value); };
  before_ = engine_.inputs(u, state);
  const auto put_before = [&](const Signal& signal) { put(signal.value(state.xi, before_)); };
  put(row.time);
  put_before(plant_.port_position);
  put_before(plant_.port_velocity);
  put_before(plant_.port_effort);
  put(row.command);
  for (const auto& signal : plant_.others) put_before(signal);
  put(row.measured);
  put(u(0));
  put(row.held_after);
  if (!jumping_.empty()) {
    const bool same = row.held_after == u(0);
    const auto& after =
        same ? before_ : engine_.inputs(Eigen::Vector2d(row.held_after, u(1)), state);
    for (const Signal* signal : jumping_) put(signal->value(state.xi, after));
  }
  if (options_.external_effort) put(u(1));
  if (options_.ledger) {
    put(state.operator_work);
    put(state.source_work);
    put(stored_under(before_, state));
    put(state.dissipated);
  }
  controller_.read_signals(told_);
  for (const double told : told_) put(told);
}

}  // namespace gyrator
