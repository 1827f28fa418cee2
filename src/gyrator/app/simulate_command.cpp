#include "gyrator/core/error.hpp"
#include "gyrator/core/interrupt.hpp"
#include "gyrator/core/text.hpp"
#include "gyrator/documents/csv.hpp"
#include "gyrator/studies/model_format.hpp"
#include "gyrator/studies/results.hpp"

#include <memory>

#include <fmt/core.h>

#include "commands.hpp"
#include "common_options.hpp"
#include "usage_errors.hpp"

namespace gyrator::app {
namespace {

struct Options {
  CommonOptions common;
  std::string engine;
  std::string duration, trace_step;
  double tolerance = 1e-9;
  long max_steps = 100000;
};

EngineKind parse_engine(const std::string& name) {
  if (name == "exact") return EngineKind::exact;
  if (name == "cvode") return EngineKind::cvode;
  if (name == "odeint") return EngineKind::odeint;
  throw Error(ErrorCode::bad_input, "--engine",
              describe_unknown_name("engine", name, {"exact", "cvode", "odeint"}));
}

std::string describe_outcome(const nlohmann::json& result, const MotionUnits& units) {
  const std::string outcome = result["classification"];
  if (outcome == "settles") return "settles";
  if (outcome == "diverges") {
    return result["stopped_early"].get<bool>() ? "diverges (stopped: grew beyond all bounds)"
                                               : "diverges";
  }
  return fmt::format("oscillates on (limit cycle) at {}, amplitude {}",
                     describe_frequency(result["oscillation"]["frequency_hz"]),
                     format_quantity(result["oscillation"]["amplitude"], units.position));
}

// How warm the winding became, where the model follows it.
std::string describe_winding(const nlohmann::json& result) {
  if (!result.contains("winding")) return "";
  const auto& winding = result["winding"];
  std::string text =
      fmt::format("\nwinding: {:.4g} K above the reference at the end, {:.4g} K at most\n",
                  winding["final_rise"].get<double>(), winding["largest_rise"].get<double>());
  if (winding["overheats"].get<bool>())
    text += "No winding survives this: from there on the run is fiction.\n";
  return text;
}

std::string describe(const Model& model, const nlohmann::json& result, bool verbose) {
  const MotionUnits& units = units_of(model.device.motion);
  const auto& e = result["energy"];
  std::string text = fmt::format(
      "{}: {}\n{}, {:g} s, engine {}{}\n\nenergy ledger [J]\n", model.name,
      describe_outcome(result, units), describe_count(result["steps"], "sample"),
      result["final_time_s"].get<double>(), result["engine"].get<std::string>(),
      result["nonlinear_element"].is_null()
          ? ""
          : fmt::format(" ({} is not linear)", result["nonlinear_element"].get<std::string>()));
  const auto row = [&](const char* name, double value) {
    text += fmt::format("  {:<34}{:>14.6g}\n", name, value);
  };
  row("stored at the start", e["stored_initially"]);
  row("+ done by the operator", e["operator"]);
  row("+ delivered by the amplifier", e["source"]);
  row("- turned into heat", e["dissipated"]);
  row("= stored at the end", e["stored"]);
  row("not accounted for (residual)", e["residual"]);
  if (const auto& hardness = result["rate_hardness"]; !hardness.is_null())
    text += fmt::format("\nfirst contact: rate-hardness {}\n",
                        format_quantity(hardness.get<double>(), units.stiffness));
  text += describe_winding(result);
  if (verbose) {
    const auto& oscillation = result["oscillation"];
    text += fmt::format(
        "\nmotion in the last third\n  growth of the oscillation {:.6g} (above 1 it grows)\n"
        "  frequency {}, amplitude {}\n",
        result["growth"].get<double>(), describe_frequency(oscillation["frequency_hz"]),
        format_quantity(oscillation["amplitude"], units.position));
  }
  return text + describe_nominal_values(model, "Simulated");
}

// The run up to its failure, in the files that were asked for; then the failure itself.
[[noreturn]] void deliver_failed(const CommonOptions& options, const Model& model,
                                 const TimeRun& run) {
  const Error& failure = *run.failure;
  std::vector<std::string> files;
  for (const auto& file : {options.csv, options.svg, options.png, options.output}) {
    if (!file.empty()) files.push_back(file);
  }
  if (files.empty()) throw failure;
  acknowledge_interrupt();
  if (!options.csv.empty()) write_csv(options.csv, run.trace.names, run.trace.columns);
  CommonOptions only_files = options;
  only_files.json = false;
  only_files.quiet = true;
  deliver(only_files, make_simulation_result(model, run), "");
  throw Error(failure.code(), failure.place(),
              fmt::format("{}; the run up to t = {:g} s is in {}", failure.message(),
                          run.trace.column("time_s").back(), join(files)));
}

void run(const Options& options) {
  check_outputs(options.common);
  SimulationRequest request;
  if (!options.engine.empty()) request.engine = parse_engine(options.engine);
  request.engine_options.relative_tolerance = options.tolerance;
  request.engine_options.max_steps = options.max_steps;
  if (!options.duration.empty())
    request.duration = parse_option_time("--duration", options.duration);
  if (!options.trace_step.empty())
    request.trace_step = parse_option_time("--trace-step", options.trace_step);
  request.quiet = options.common.quiet;
  request.keep_failed = true;
  const Model model = load_model(options.common.model);
  const TimeRun simulated = run_simulation(model, request);
  if (simulated.failure) deliver_failed(options.common, model, simulated);
  if (!options.common.csv.empty())
    write_csv(options.common.csv, simulated.trace.names, simulated.trace.columns);
  const nlohmann::json result = make_simulation_result(model, simulated);
  deliver(options.common, result, describe(model, result, options.common.verbose));
}

}  // namespace

void add_simulate_command(CLI::App& app, int&) {
  auto options = std::make_shared<Options>();
  CLI::App* command = app.add_subcommand(
      "simulate", "The motion: plant, sample and hold, controller; traces and energy ledger");
  add_common_options(*command, options->common, "Write the trace, one row per sample instant",
                     "gyrator simulate examples/rc_display.json --csv trace.csv --png trace.png");
  command
      ->add_option("--engine", options->engine,
                   "exact (matrix exponentials; linear models, and those that friction, stops and "
                   "limits make linear in pieces), cvode (reference) or odeint; by default exact "
                   "where it applies, else cvode")
      ->type_name("NAME")
      ->check(not_empty());
  command->add_option("--duration", options->duration, "Simulated time instead of the model's")
      ->type_name("TIME")
      ->check(not_empty());
  command->add_option("--trace-step", options->trace_step, "Also trace in between, such as 10us")
      ->type_name("TIME")
      ->check(not_empty());
  command->add_option("--tolerance", options->tolerance, "Relative tolerance of cvode and odeint")
      ->capture_default_str()
      ->check(number_between(1e-14, 1e-2));
  command
      ->add_option("--max-steps", options->max_steps,
                   "Most integrator steps between two samples (cvode, odeint)")
      ->capture_default_str()
      ->check(whole_number_between(1, 1000000000));
  command->callback([options] { run(*options); });
}

}  // namespace gyrator::app
