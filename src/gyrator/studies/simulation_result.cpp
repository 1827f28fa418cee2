#include "gyrator/studies/simulation_result.hpp"

#include "gyrator/cosim/rate_hardness.hpp"
#include "gyrator/mechanics/plant.hpp"
#include "gyrator/mechanics/stability.hpp"
#include "gyrator/studies/operating_point_fields.hpp"
#include "gyrator/studies/progress.hpp"
#include "gyrator/studies/result_parts.hpp"

#include <algorithm>
#include <cmath>

#include <fmt/core.h>

namespace gyrator {
namespace {

using nlohmann::json;

constexpr std::size_t most_trace_rows = 5000;

// The ledger is the check of every run: what it cannot account for did not happen.
void check_ledger(const Model& model, const TimeRun& run, double tolerance) {
  const EnergyLedger& e = run.energy;
  const double moved =
      std::abs(e.operator_work) + std::abs(e.source) + e.dissipated + e.stored + e.stored_initially;
  if (std::abs(e.residual) <= tolerance * moved) return;
  const FastestElement fastest =
      find_fastest_element(build_device_network(model.device, model.held_by));
  if (!std::isfinite(e.residual)) {
    throw Error(ErrorCode::numerical, fmt::format("t = {:g} s", run.final_time_s),
                "the numbers of the run are no longer finite: an initial value or a component is "
                "out of all proportion");
  }
  if (find_nonlinear_element(model)) {
    throw Error(ErrorCode::numerical, fmt::format("t = {:g} s", run.final_time_s),
                fmt::format("the energy ledger does not close (residual {:.3g} J of {:.3g} J "
                            "moved): lower --tolerance",
                            e.residual, moved));
  }
  throw Error(ErrorCode::numerical, fastest.element,
              fmt::format("the energy ledger does not close (residual {:.3g} J of {:.3g} J moved, "
                          "t = {:g} s): this element "
                          "gives a pole at {:.3g} rad/s, too fast to be resolved beside the "
                          "sampling; leave it out (0) or "
                          "give it a realistic value",
                          e.residual, moved, run.final_time_s, fastest.rate));
}

// The last tick must lie within the recording, up to the rounding of its decimals.
void check_recording(const Model& model, const Rational& duration) {
  const auto* recorded = std::get_if<RecordedGesture>(&model.gesture->gesture);
  if (!recorded) return;
  const Rational ticks(floor_divide(duration, model.sampling.period));
  const double last = (ticks * model.sampling.period).to_double();
  const double length = recorded->time.back() - recorded->time.front();
  if (length >= last * (1 - 1e-9)) return;
  throw Error(ErrorCode::bad_input, recorded->end_place,
              fmt::format("the recording ends after {:g} s, the run of {} after {:g} s: shorten "
                          "the duration, or record for longer",
                          length, model.file, last));
}

SimulationOptions options_of(const Model& model, const SimulationRequest& request) {
  SimulationOptions options;
  options.duration = request.duration.value_or(model.duration);
  options.initial_position = model.initial_position;
  options.initial_velocity = model.initial_velocity;
  options.external_effort = model.external_effort;
  options.gesture = model.gesture;
  options.dac = model.dac;
  options.seed = model.seed;
  options.engine_options = request.engine_options;
  options.trace_step = request.trace_step;
  options.keep_failed = request.keep_failed;
  return options;
}

}  // namespace

TimeRun run_simulation(const Model& model, const SimulationRequest& request) {
  naming_file(model, [&] { require_stable_device(model.device); });
  SimulationOptions options = options_of(model, request);
  if (model.gesture) check_recording(model, options.duration);
  const double samples = options.duration.to_double() / model.sampling.period.to_double();
  Progress progress("simulate", static_cast<std::uint64_t>(samples), request.quiet);
  options.on_progress = [&](long done) { progress.advance(static_cast<std::uint64_t>(done)); };
  const Plant plant = build_moving_plant(build_device_network(model.device, model.held_by));
  options.engine = request.engine.value_or(choose_engine(plant));
  TimeRun run;
  try {
    run = simulate(plant, model.sensor, model.sampled_controller(), model.sampling, options);
  } catch (const Error& error) {
    // The simulation knows keys, not files and options.
    if (error.code() != ErrorCode::bad_input) throw;
    std::string place = model.file + ": /" + error.place();
    if (error.place() == "simulation/duration" && request.duration) place = "--duration";
    if (error.place() == "engine") place = "--engine";
    throw Error(error.code(), place, error.message());
  }
  if (run.failure) return run;
  try {
    check_ledger(model, run, std::max(1e-6, 100 * request.engine_options.relative_tolerance));
  } catch (const Error& error) {
    if (!request.keep_failed) throw;
    run.failure = error;
  }
  return run;
}

namespace {

// Columns of the trace every `stride` rows; those of the ledger apart, without their prefix.
void add_trace(json& result, const Trace& traced) {
  const std::size_t rows = traced.columns.front().size();
  const std::size_t stride =
      std::max<std::size_t>(1, (rows + most_trace_rows - 1) / most_trace_rows);
  json trace = json::object();
  json energy_trace = json::object();
  for (std::size_t c = 0; c < traced.names.size(); ++c) {
    json column = json::array();
    for (std::size_t row = 0; row < rows; row += stride) column.push_back(traced.columns[c][row]);
    const std::string& name = traced.names[c];
    constexpr std::string_view prefix = "energy_";
    if (name == "time_s") energy_trace[name] = column;
    if (name.starts_with(prefix)) {
      energy_trace[name.substr(prefix.size())] = std::move(column);
    } else {
      trace[name] = std::move(column);
    }
  }
  result["trace"] = std::move(trace);
  result["trace_rows_per_sample"] = 1.0 / static_cast<double>(stride);
  if (energy_trace.size() > 1) result["energy_trace"] = std::move(energy_trace);
}

void add_outcome(json& result, const TimeRun& run) {
  if (run.failure) {
    result["failure"] = {{"place", run.failure->place()},
                         {"message", run.failure->message()},
                         {"exit_code", static_cast<int>(run.failure->code())}};
    result["classification"] = result["growth"] = result["oscillation"] = nullptr;
    return;
  }
  result["classification"] = name_of(run.classification.outcome);
  result["growth"] = run.classification.growth;
  result["oscillation"] = {{"frequency_hz", run.classification.frequency_hz},
                           {"amplitude", run.classification.amplitude}};
}

json find_first_hardness(const Model& model, const TimeRun& run) {
  const bool even_clock = model.sampling.jitter == Rational(0);
  if (!has_contact(model.controller.law) || !even_clock) return nullptr;
  const auto hardness = find_rate_hardness(run.trace, model.sampling.period.to_double());
  return hardness ? json(*hardness) : json(nullptr);
}

}  // namespace

json make_simulation_result(const Model& model, const TimeRun& run) {
  json result = start_result("simulate", model);
  const auto nonlinear = find_nonlinear_element(model);
  result["engine"] = run.engine == EngineKind::exact   ? "exact"
                     : run.engine == EngineKind::cvode ? "cvode"
                                                       : "odeint";
  result["nonlinear_element"] = nonlinear ? json(*nonlinear) : json(nullptr);
  result["final_time_s"] = run.final_time_s;
  result["steps"] = run.steps;
  result["stopped_early"] = run.stopped_early;
  result["seed"] = model.seed;
  add_outcome(result, run);
  result["rate_hardness"] = find_first_hardness(model, run);
  const EnergyLedger& e = run.energy;
  result["energy"] = {{"operator", e.operator_work}, {"source", e.source},
                      {"stored", e.stored},          {"stored_initially", e.stored_initially},
                      {"dissipated", e.dissipated},  {"residual", e.residual}};
  const Mechanics& mechanics = model.device.mechanics;
  if (find_dry_friction(mechanics) || mechanics.stops) {
    result["contact_events"] = {{"sticks", run.events.sticks},
                                {"slips", run.events.slips},
                                {"impacts", run.events.impacts}};
  }
  const auto& names = run.trace.names;
  if (std::find(names.begin(), names.end(), "winding_temperature_rise") != names.end()) {
    const auto& rise = run.trace.column("winding_temperature_rise");
    const double largest = *std::max_element(rise.begin(), rise.end());
    result["winding"] = {{"final_rise", rise.back()},
                         {"largest_rise", largest},
                         {"overheats", largest > hottest_rise}};
  }
  add_trace(result, run.trace);
  return result;
}

}  // namespace gyrator
