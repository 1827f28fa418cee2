#include "gyrator/core/error.hpp"
#include "gyrator/core/quantity.hpp"
#include "gyrator/core/text.hpp"
#include "gyrator/documents/json_text.hpp"
#include "gyrator/sweeps/sweep_result.hpp"
#include "gyrator/sweeps/sweep_run.hpp"
#include "gyrator/version.hpp"

#include <memory>
#include <string>
#include <vector>

#include <fmt/core.h>

#include "commands.hpp"
#include "common_options.hpp"
#include "regression_commands.hpp"
#include "usage_errors.hpp"

namespace gyrator::app {
namespace {

using nlohmann::json;

struct RunOptions {
  std::string file, analysis, output, timeout, filter;
  std::vector<std::string> vary;
  long sobol = 0, random = 0, seed = 1, threads = 0;
  bool keep_going = false, restart = false, as_json = false, quiet = false;
};

struct ShowOptions {
  std::string file, csv;
  bool as_json = false, verbose = false;
};

SweepStudy make_study_of_model(const RunOptions& options) {
  SweepStudy study;
  study.file = study.model_file = options.file;
  study.model_text = load_json_text(options.file);
  study.analysis = options.analysis;
  if (study.analysis.empty()) {
    throw Error(ErrorCode::bad_input, "--analysis",
                "is missing: say what to compute at each point, such as --analysis zwidth");
  }
  for (const std::string& text : options.vary) study.vary.push_back(parse_variation(text));
  if (options.sobol > 0) study.sampling = SamplingKind::sobol;
  if (options.random > 0) study.sampling = SamplingKind::random;
  study.samples = static_cast<std::size_t>(options.sobol > 0 ? options.sobol : options.random);
  study.seed = static_cast<std::uint64_t>(options.seed);
  return study;
}

SweepStudy read_study(const RunOptions& options) {
  SweepStudy study;
  if (is_study(load_json_file(options.file))) {
    const bool both = !options.vary.empty() || !options.analysis.empty() || options.sobol > 0 ||
                      options.random > 0;
    if (both) {
      throw Error(ErrorCode::bad_input, options.file,
                  "is a study: what varies, analysis and sampling stand in it, not in options");
    }
    study = load_study(options.file);
  } else {
    study = make_study_of_model(options);
  }
  if (!options.timeout.empty())
    study.timeout_s = parse_option_time("--timeout", options.timeout).to_double();
  if (options.keep_going) study.keep_going = true;
  return study;
}

// What gives the same numbers again, without what does not decide them (threads, file names).
std::string describe_command(const RunOptions& options) {
  std::string text = "gyrator study run " + quote_word(options.file);
  for (const std::string& vary : options.vary) text += " --vary " + quote_word(vary);
  if (!options.analysis.empty()) text += " --analysis " + options.analysis;
  if (options.sobol > 0) text += fmt::format(" --sobol {}", options.sobol);
  if (options.random > 0)
    text += fmt::format(" --random {} --seed {}", options.random, options.seed);
  if (!options.timeout.empty()) text += " --timeout " + quote_word(options.timeout);
  if (options.keep_going) text += " --keep-going";
  return text;
}

json counts_json(const SweepCounts& counts) {
  return {{"points", counts.points},
          {"ok", counts.ok},
          {"failed", counts.failed},
          {"timed_out", counts.timed_out}};
}

std::string describe_counts(const SweepCounts& counts) {
  std::string text = fmt::format("{}: {} ok", describe_count(counts.points, "point"), counts.ok);
  if (counts.failed > 0) text += fmt::format(", {} failed", counts.failed);
  if (counts.timed_out > 0) text += fmt::format(", {} timed out", counts.timed_out);
  if (counts.done() < counts.points)
    text += fmt::format(", {} not computed yet", counts.points - counts.done());
  return text;
}

void check_ending(const std::string& output) {
  if (output.ends_with(".h5") || output.ends_with(".hdf5")) return;
  throw Error(ErrorCode::bad_input, "--output",
              fmt::format("'{}': the result is HDF5, a name that ends in .h5 or .hdf5 is expected "
                          "(`gyrator study show FILE --csv` writes columns)",
                          output));
}

// Of a regression study, which says itself what varies.
void run_regression(const RunOptions& options, int& exit_code) {
  const bool has_more = !options.vary.empty() || !options.analysis.empty() || options.sobol > 0 ||
                        options.random > 0 || !options.timeout.empty() || options.keep_going ||
                        options.restart;
  if (has_more) {
    throw Error(ErrorCode::bad_input, options.file,
                "is a regression study: of the options it takes --filter, --threads, --json and "
                "--quiet");
  }
  RegressionRequest request;
  request.files = {options.file};
  request.filter = options.filter;
  request.threads = static_cast<int>(options.threads);
  request.as_json = options.as_json;
  request.quiet = options.quiet;
  run_regression_study(request, options.output, exit_code);
}

void run(const RunOptions& options, int& exit_code) {
  if (is_regression_file(options.file)) return run_regression(options, exit_code);
  if (!options.filter.empty()) {
    throw Error(ErrorCode::bad_input, "--filter",
                "is for regression studies, which have several runs");
  }
  SweepRequest request;
  request.output = options.output;
  request.command_line = describe_command(options);
  request.threads = static_cast<int>(options.threads);
  request.restart = options.restart;
  request.quiet = options.quiet;
  const SweepSummary summary = run_study(
      [&] {
        check_files({{"the model or study", options.file}}, {{"--output", options.output}});
        SweepStudy study = read_study(options);
        check_ending(options.output);
        check_files({{"the model", study.model_file}}, {{"--output", options.output}});
        return SweepPlan(std::move(study));
      },
      request);
  if (summary.is_told_elsewhere) return;
  if (options.as_json) {
    json result = counts_json(summary.counts);
    result["command"] = "study run";
    result["program"] = fmt::format("gyrator {}", version);
    result["output"] = options.output;
    result["resumed"] = summary.resumed;
    result["first_reason"] =
        summary.first_reason.empty() ? json(nullptr) : json(summary.first_reason);
    fmt::print("{}\n", result.dump(-1, ' ', false, json::error_handler_t::replace));
  } else if (!options.quiet) {
    std::string text = describe_counts(summary.counts);
    if (summary.resumed > 0) text += fmt::format(" ({} by an earlier run)", summary.resumed);
    if (!summary.first_reason.empty()) text += "\nfirst failure: " + summary.first_reason;
    fmt::print("{}\n{}\n", text, options.output);
  }
  if (summary.counts.ok > 0) return;
  exit_code = static_cast<int>(ErrorCode::numerical);
  fmt::print(stderr, "gyrator: {}: not one of {} could be computed; the first: {}\n",
             options.output, describe_count(summary.counts.points, "point"), summary.first_reason);
}

json column_json(const Column& column) {
  json values = json::array();
  std::visit(
      [&](const auto& list) {
        for (const auto& value : list) values.push_back(value);  // nan and inf become null
      },
      column.values);
  return {{"name", column.name},
          {"unit", column.attribute("unit")},
          {"role", column.attribute("role")},
          {"values", std::move(values)}};
}

json table_json(const SweepTable& table) {
  json result = counts_json(count_rows(table));
  result["command"] = "study show";
  for (const auto& [name, value] : table.file.attributes)
    std::visit([&, &key = name](const auto& v) { result["attributes"][key] = v; }, value);
  result["point"] = table.points;
  result["columns"] = json::array();
  for (const Column& column : table.file.columns) result["columns"].push_back(column_json(column));
  return result;
}

void show(const ShowOptions& options) {
  check_files({{"the sweep", options.file}}, {{"--csv", options.csv}});
  const SweepTable table = read_sweep(options.file);
  if (!options.csv.empty()) write_sweep_csv(options.csv, table);
  if (options.as_json) {
    fmt::print("{}\n", table_json(table).dump(-1, ' ', false, json::error_handler_t::replace));
    return;
  }
  constexpr std::size_t few = 24;
  const std::size_t rows = options.verbose ? std::max<std::size_t>(1, table.points.size()) : few;
  fmt::print("{}: {}, {}\n\n{}", table.file.attribute("model_name"),
             table.file.attribute("analysis"), describe_counts(count_rows(table)),
             describe_sweep(table, rows));
  if (table.points.size() > rows)
    fmt::print("\n{} points in all; --verbose, --csv or --json gives them\n", table.points.size());
}

std::string describe_analyses() {
  std::string text = "What to compute at each point:";
  for (const SweepAnalysis& analysis : sweep_analyses())
    text += fmt::format("\n  {}: {}", analysis.name, analysis.summary);
  return text;
}

void add_run(CLI::App& study, int& exit_code) {
  auto options = std::make_shared<RunOptions>();
  CLI::App* command = study.add_subcommand(
      "run", "Compute an analysis of a model over values that vary in it, into an HDF5 file");
  command->add_option("MODEL", options->file, "Model file, or study file of either kind (JSON)")
      ->required()
      ->check(not_empty());
  command
      ->add_option("--vary", options->vary,
                   "A value of the model and what it is to be, once for each:\n"
                   "  PATH=FROM..TO:N     N values, evenly\n"
                   "  PATH=FROM..TO:Nlog  N values by equal factors\n"
                   "  PATH=a,b,c          these\n"
                   "PATH such as damping.0.capacitance, items of lists by their number")
      ->type_name("TEXT")
      ->allow_extra_args(false)
      ->check(not_empty());
  command->add_option("--analysis", options->analysis, describe_analyses())
      ->type_name("NAME")
      ->check(not_empty());
  auto* sobol =
      command
          ->add_option("--sobol", options->sobol,
                       "Instead of every combination: the first N points of the Sobol sequence")
          ->type_name("N")
          ->check(whole_number_between(1, 100'000'000));
  auto* random =
      command->add_option("--random", options->random, "Instead: N points, evenly distributed")
          ->type_name("N")
          ->check(whole_number_between(1, 100'000'000))
          ->excludes(sobol);
  command->add_option("--seed", options->seed, "Of --random: the same seed gives the same points")
      ->type_name("S")
      ->capture_default_str()
      ->needs(random)
      ->check(whole_number_between(0, 1'000'000'000'000'000));
  command
      ->add_option("-o,--output", options->output,
                   "Result file (HDF5); of a regression study the folder for its results")
      ->type_name("FILE")
      ->required()
      ->check(not_empty());
  command
      ->add_option("--threads", options->threads,
                   "Threads of this process; by default all cores, under mpirun one")
      ->type_name("N")
      ->check(whole_number_between(1, 1024));
  command
      ->add_option("--timeout", options->timeout,
                   "Longest time for a point; one that takes longer is recorded as timed out")
      ->type_name("SECONDS")
      ->check(not_empty());
  command->add_flag("--keep-going", options->keep_going,
                    "Record points that fail and go on, instead of stopping at the first");
  command->add_flag("--restart", options->restart,
                    "Throw away what an earlier run has left in FILE.journal");
  command
      ->add_option("--filter", options->filter,
                   "Of a regression study: only runs with this text in STUDY/RUN")
      ->type_name("TEXT")
      ->check(not_empty());
  command->add_flag("--json", options->as_json, "Print one JSON object and nothing else");
  command->add_flag("--quiet", options->quiet, "No text and no progress");
  command->footer(
      "Example:\n  gyrator study run examples/rc_display.json --vary "
      "damping.0.capacitance=100uF..10mF:5log --vary controller.damping=0,0.15mN.m.s/rad "
      "--analysis zwidth -o sweep.h5\n\n"
      "What is done is kept in FILE.journal: after Ctrl-C or a crash the same command goes on. On "
      "several machines: mpirun gyrator study run …\n\n"
      "Exit codes: 0 done, 2 bad input, 3 a point failed (with --keep-going: all did), 130 "
      "interrupted.");
  command->callback([options, &exit_code] { run(*options, exit_code); });
}

void add_show(CLI::App& study) {
  auto options = std::make_shared<ShowOptions>();
  CLI::App* command = study.add_subcommand(
      "show", "Print a sweep's points, of a result file or of the journal of one under way");
  command->add_option("FILE", options->file, "sweep.h5 or sweep.h5.journal")
      ->required()
      ->check(not_empty());
  command->add_option("--csv", options->csv, "Write all points as columns")
      ->type_name("FILE")
      ->check(not_empty());
  command->add_flag("--json", options->as_json, "Print one JSON object and nothing else");
  command->add_flag("--verbose", options->verbose, "All points");
  command->footer("Example:\n  gyrator study show sweep.h5 --csv sweep.csv");
  command->callback([options] { show(*options); });
}

}  // namespace

void add_study_command(CLI::App& app, int& exit_code) {
  CLI::App* command = app.add_subcommand(
      "study", "Sweeps over values that vary in a model, and figures that must not change");
  command->require_subcommand(1);
  command->footer("Example:\n  gyrator study run --help");
  add_run(*command, exit_code);
  add_show(*command);
  add_check_command(*command, exit_code);
  add_update_command(*command, exit_code);
}

}  // namespace gyrator::app
