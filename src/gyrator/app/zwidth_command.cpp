#include "gyrator/core/error.hpp"
#include "gyrator/core/text.hpp"
#include "gyrator/documents/csv.hpp"
#include "gyrator/studies/envelope_result.hpp"
#include "gyrator/studies/model_format.hpp"
#include "gyrator/studies/results.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>

#include <fmt/core.h>

#include "commands.hpp"
#include "common_options.hpp"
#include "linear_range_text.hpp"
#include "usage_errors.hpp"

namespace gyrator::app {
namespace {

struct Options {
  CommonOptions common;
  std::string damping, from, to;
  int points = 61;
  std::string criteria = "exact_disk,frequency_dependent,spring_damper";
  bool has_criteria = false;
  bool envelope = false;
  std::string cutoff, band;
  std::string stiffness, gestures, duration;
  int rows = 64;
  int threads = 0;
  std::string map_option;  // one that only the map by time has, where it was given
};

constexpr const char* time_criterion = "time";

struct Criteria {
  std::vector<Criterion> list;
  bool time = false;  // by co-simulation, too
};

Criteria parse_criteria(const std::string& text) {
  std::vector<std::string> known;
  for (const auto& c : criterion_names()) known.emplace_back(c.name);
  known.emplace_back(time_criterion);
  Criteria criteria;
  for (const std::string& name : parse_names("--criterion", text)) {
    const auto found = std::find(known.begin(), known.end(), name);
    if (found == known.end()) {
      throw Error(ErrorCode::bad_input, "--criterion",
                  describe_unknown_name("criterion", name, known));
    }
    if (name == time_criterion) {
      criteria.time = true;
      continue;
    }
    criteria.list.push_back(
        criterion_names()[static_cast<std::size_t>(found - known.begin())].criterion);
  }
  return criteria;
}

std::vector<double> choose_damping(const Options& options, const Model& model) {
  const Unit& unit = units_of(model.device.motion).damping;
  if (!options.damping.empty()) return parse_list("--damping", options.damping, unit);
  if (options.from.empty() != options.to.empty()) {
    throw Error(ErrorCode::bad_input, options.from.empty() ? "--to" : "--from",
                "--from and --to go together");
  }
  if (options.from.empty()) return choose_damping_range(model, options.points);
  const double from = parse_option("--from", options.from, unit);
  const double to = parse_option("--to", options.to, unit);
  if (!(to > from))
    throw Error(ErrorCode::bad_input, "--to",
                fmt::format("{:g}: must be above --from, {:g}", to, from));
  std::vector<double> damping;
  for (int i = 0; i < options.points; ++i)
    damping.push_back(from + (to - from) * i / (options.points - 1));
  return damping;
}

std::string describe_map(const nlohmann::json& boundary) {
  const auto& map = boundary["map"];
  std::array<int, 3> counts{};
  for (const auto& row : map["outcome"]) {
    for (const auto& cell : row) ++counts.at(cell.get<std::size_t>());
  }
  std::string text = fmt::format(
      "\nmap of {} x {} walls, {} samples each: {} settle, {} keep a limit cycle, {} diverge\n",
      map["stiffness"].size(), boundary["damping"].size(), map["samples"].get<long>(), counts[0],
      counts[1], counts[2]);
  const std::string by = map["computed_by"];
  if (by != "lanes") text += fmt::format("computed {}\n", by);
  return text;
}

// Where no row of a map fails, that says nothing of stiffer walls.
std::string name_missing_limit(const nlohmann::json& boundary) {
  if (!boundary.contains("map")) return "unbounded";
  return fmt::format("above {:.6g}", boundary["map"]["stiffness"].back().get<double>());
}

std::string describe(const Model& model, const nlohmann::json& result, bool verbose) {
  const MotionUnits& units = units_of(model.device.motion);
  std::string text = fmt::format("{}: largest stiffness [{}] over virtual damping [{}]\n\n{:>14}",
                                 model.name, units.stiffness.symbol, units.damping.symbol, "B");
  for (const auto& b : result["boundaries"])
    text += fmt::format("  {:>20}", b["criterion"].get<std::string>());
  text += "\n";
  const std::size_t rows = result["damping"].size();
  const std::size_t stride = verbose ? 1 : std::max<std::size_t>(1, (rows + 24) / 25);
  for (std::size_t i = 0; i < rows; i += stride) {
    text += fmt::format("{:14.6g}",
                        result["damping"][i].get<double>() + 0.0);  // adding zero turns -0 into 0
    for (const auto& b : result["boundaries"]) {
      const auto& k = b["max_stiffness"][i];
      const bool feasible = b["feasible"][i];
      text += fmt::format("  {:>20}", !feasible     ? "none"
                                      : k.is_null() ? name_missing_limit(b)
                                                    : fmt::format("{:.6g}", k.get<double>() + 0.0));
    }
    text += "\n";
  }
  if (stride > 1) {
    text += fmt::format(
        "\n{} dampings computed; --verbose, --csv or --json gives them all, --png or --svg a "
        "plot.\n",
        rows);
  }
  bool all_simulated = true;
  for (const auto& b : result["boundaries"]) {
    if (b.contains("map")) text += describe_map(b);
    all_simulated = all_simulated && b.contains("map");
  }
  if (!all_simulated) text += describe_linear_range(model, result);
  return text + describe_nominal_values(model);
}

std::vector<Criterion> choose_envelope_criterion(const Options& options) {
  if (!options.has_criteria) return {Criterion::exact_disk};
  const Criteria criteria = parse_criteria(options.criteria);
  if (criteria.time) {
    throw Error(ErrorCode::bad_input, "--criterion",
                "time: an envelope is by a passivity criterion");
  }
  if (criteria.list.size() > 1) {
    throw Error(ErrorCode::bad_input, "--criterion",
                fmt::format("{}: an envelope is by one criterion", options.criteria));
  }
  return criteria.list;
}

EnvelopeRequest make_envelope_request(const Options& options) {
  EnvelopeRequest request;
  request.criterion = choose_envelope_criterion(options).front();
  if (!options.cutoff.empty())
    request.cutoff_hz = parse_list("--cutoff", options.cutoff, dimension::frequency);
  if (!options.band.empty()) {
    const auto ends = parse_list("--band", options.band, dimension::frequency);
    if (ends.size() != 2) {
      throw Error(ErrorCode::bad_input, "--band",
                  fmt::format("'{}': two frequencies are expected, such as 1,400", options.band));
    }
    request.from_hz = ends[0];
    request.to_hz = ends[1];
  }
  return request;
}

std::string describe_wall(const nlohmann::json& walls, std::size_t i) {
  std::string text = fmt::format("{:10.4g} {:10.4g}", walls["stiffness"][i].get<double>() + 0.0,
                                 walls["damping"][i].get<double>() + 0.0);
  if (walls.contains("cutoff_hz"))
    text += fmt::format(" {:8.4g}", walls["cutoff_hz"][i].get<double>());
  return text;
}

std::string describe_envelope(const Model& model, const nlohmann::json& result, bool verbose) {
  const MotionUnits& units = units_of(model.device.motion);
  const bool cutoffs = result["at_impedance_max"].contains("cutoff_hz");
  const std::string criterion = result["criterion"];
  const std::string walls = criterion == name_of(Criterion::coupled)
                                ? "that are stable with the model's operator (coupled)"
                                : fmt::format("that {} calls passive", criterion);
  std::string text = fmt::format(
      "{}: what the walls {} display at the port, |Z| [{}],\nand the walls that do, K [{}] and B "
      "[{}]{}\n\n{:>10} {:>10} {:>10} {:>10}   {:<{}}   {}\n",
      model.name, walls, units.damping.symbol, units.stiffness.symbol, units.damping.symbol,
      cutoffs ? ", cut-off [Hz]" : "", "Hz", "smallest", "bare", "largest",
      cutoffs ? "smallest: K, B, cut-off" : "smallest: K, B", cutoffs ? 30 : 21,
      cutoffs ? "largest: K, B, cut-off" : "largest: K, B");
  const std::size_t rows = result["frequency_hz"].size();
  const std::size_t stride = verbose ? 1 : std::max<std::size_t>(1, (rows + 23) / 24);
  for (std::size_t i = 0; i < rows; i += stride) {
    const auto& high = result["impedance_max"][i];
    text += fmt::format(
        "{:10.4g} {:10.4g} {:10.4g} {:>10}   {}   {}\n", result["frequency_hz"][i].get<double>(),
        result["impedance_min"][i].get<double>(), result["bare_impedance"][i].get<double>(),
        high.is_null() ? "unbounded" : fmt::format("{:.4g}", high.get<double>()),
        describe_wall(result["at_impedance_min"], i), describe_wall(result["at_impedance_max"], i));
  }
  const auto number = [](const nlohmann::json& value) {
    return value.is_null() ? std::string("unbounded") : fmt::format("{:.4g}", value.get<double>());
  };
  const auto& areas = result["areas"];
  text += fmt::format(
      "\narea between largest and smallest, {:.4g} Hz to {:.4g} Hz: {} decades^2 (of impedance and "
      "admittance alike)\n",
      result["frequency_hz"].front().get<double>(), result["frequency_hz"].back().get<double>(),
      number(areas["logarithmic"]));
  if (areas["logarithmic"].is_null()) {
    text += fmt::format(
        "{}: among these walls are some that display no impedance at all, or one without bound, "
        "which no passive wall does\n",
        criterion == name_of(Criterion::coupled) ? "stable is not passive"
                                                 : criterion + " is mistaken here");
  }
  for (const auto& region : result["regions"]) {
    text += fmt::format("area below the K-B boundary, B >= 0{}: {:.4g} {} x {}\n",
                        region["cutoff_hz"].is_null()
                            ? ""
                            : fmt::format(", cut-off {:g} Hz", region["cutoff_hz"].get<double>()),
                        region["area"].get<double>(), units.stiffness.symbol, units.damping.symbol);
  }
  return text + describe_linear_range(model, result) + describe_nominal_values(model);
}

void write_envelope_csv(const std::string& path, const nlohmann::json& result) {
  std::vector<std::string> names;
  std::vector<std::vector<double>> columns;
  const auto add = [&](const std::string& name, const nlohmann::json& values) {
    names.push_back(name);
    columns.emplace_back();
    for (const auto& value : values)
      columns.back().push_back(value.is_null() ? INFINITY : value.get<double>());
  };
  for (const char* key : {"frequency_hz", "impedance_max", "impedance_min", "admittance_max",
                          "admittance_min", "bare_impedance"})
    add(key, result[key]);
  for (const char* key : {"at_impedance_max", "at_impedance_min"}) {
    for (const auto& [name, values] : result[key].items())
      add(fmt::format("{}_{}", name, key), values);
  }
  write_csv(path, names, columns);
}

void run_envelope(const Options& options) {
  const EnvelopeRequest request = make_envelope_request(options);
  const Model model = load_model(options.common.model);
  const nlohmann::json result = make_envelope_result(model, request);
  if (!options.common.csv.empty()) write_envelope_csv(options.common.csv, result);
  deliver(options.common, result, describe_envelope(model, result, options.common.verbose));
}

// "0..1 N.m/rad": rows of equal height from one to the other.
std::vector<double> parse_rows(const Options& options, const Unit& unit) {
  if (options.stiffness.empty()) return {};
  const std::size_t dots = options.stiffness.find("..");
  if (dots == std::string::npos) return parse_list("--stiffness", options.stiffness, unit);
  const double from = parse_option("--stiffness", options.stiffness.substr(0, dots), unit);
  const double to = parse_option("--stiffness", options.stiffness.substr(dots + 2), unit);
  if (!(to > from)) {
    throw Error(ErrorCode::bad_input, "--stiffness",
                fmt::format("{:g}..{:g}: must rise", from, to));
  }
  std::vector<double> rows;
  for (int i = 0; i < options.rows; ++i)
    rows.push_back(from + (to - from) * (i + 1) / options.rows);
  return rows;
}

std::vector<MapGesture> parse_gestures(const std::string& text) {
  const std::vector<std::string> known{"model", "hit", "hold"};
  std::vector<MapGesture> gestures;
  if (text.empty()) return gestures;
  for (const std::string& name : parse_names("--gesture", text)) {
    const auto found = std::find(known.begin(), known.end(), name);
    if (found == known.end())
      throw Error(ErrorCode::bad_input, "--gesture", describe_unknown_name("gesture", name, known));
    gestures.push_back(static_cast<MapGesture>(found - known.begin()));
  }
  return gestures;
}

TimeMapRequest make_time_request(const Options& options, const Model& model,
                                 const std::vector<double>& damping) {
  TimeMapRequest request;
  request.damping = damping;
  request.stiffness = parse_rows(options, units_of(model.device.motion).stiffness);
  std::sort(request.stiffness.begin(), request.stiffness.end());
  request.rows = options.rows;
  request.gestures = parse_gestures(options.gestures);
  if (!options.duration.empty())
    request.duration = parse_option_time("--duration", options.duration);
  request.threads = options.threads;
  request.quiet = options.common.quiet;
  return request;
}

void run(const Options& options) {
  check_outputs(options.common);
  const Criteria criteria = parse_criteria(options.criteria);
  if ((!criteria.time || options.envelope) && !options.map_option.empty()) {
    throw Error(ErrorCode::bad_input, options.map_option,
                "belongs to the map by time: add --criterion time");
  }
  if (!options.stiffness.empty() && options.stiffness.find("..") == std::string::npos &&
      options.map_option == "--rows") {
    throw Error(ErrorCode::bad_input, "--rows", "a list of --stiffness has its own rows");
  }
  if (options.envelope) return run_envelope(options);
  const Model model = load_model(options.common.model);
  ZwidthRequest request{choose_damping(options, model), criteria.list, options.common.quiet, {}};
  if (criteria.time) {  // columns of a map rise, and curves over it have the same
    std::sort(request.damping.begin(), request.damping.end());
    request.time = make_time_request(options, model, request.damping);
  }
  const nlohmann::json result = make_zwidth_result(model, request);
  if (!options.common.csv.empty()) {
    std::vector<std::string> names{"damping"};
    std::vector<std::vector<double>> columns{result["damping"]};
    for (const auto& b : result["boundaries"]) {
      names.push_back("max_stiffness_" + b["criterion"].get<std::string>());
      std::vector<double> column;
      for (const auto& k : b["max_stiffness"])
        column.push_back(k.is_null() ? INFINITY : k.get<double>());
      columns.push_back(std::move(column));
    }
    write_csv(options.common.csv, names, columns);
  }
  deliver(options.common, result, describe(model, result, options.common.verbose));
}

}  // namespace

void add_zwidth_command(CLI::App& app, int&) {
  auto options = std::make_shared<Options>();
  CLI::App* command = app.add_subcommand(
      "zwidth", "Largest virtual stiffness over virtual damping, by one or more criteria");
  std::string criteria_help = "Comma-separated:";
  for (const auto& c : criterion_names())
    criteria_help += fmt::format("\n  {}: {}", c.name, c.summary);
  criteria_help += fmt::format(
      "\n  {}: co-simulated hits and holds with the model's operator, as a map over K and B",
      time_criterion);
  add_common_options(
      *command, options->common, "Write damping and the limits as columns",
      "gyrator zwidth examples/rc_display.json --damping 0,1e-4,1.5e-4 --criterion exact_disk\n"
      "  gyrator zwidth examples/rc_display.json --criterion time,exact_disk --svg map.svg\n"
      "  gyrator zwidth examples/rc_display.json --envelope --cutoff 50,200 --svg envelope.svg");
  auto* list =
      command
          ->add_option("--damping", options->damping, "Virtual dampings B, such as 0,0.1mN.m.s/rad")
          ->type_name("LIST")
          ->check(not_empty());
  const auto add_end = [&](const char* name, std::string& value, const char* help) {
    command->add_option(name, value, help)->type_name("B")->check(not_empty())->excludes(list);
  };
  add_end("--from", options->from, "Lowest virtual damping of a range");
  add_end("--to", options->to, "Highest virtual damping of a range");
  command->add_option("--points", options->points, "Number of dampings in the range")
      ->capture_default_str()
      ->check(whole_number_between(2, 1000000));
  auto* criteria = command->add_option("--criterion", options->criteria, criteria_help)
                       ->capture_default_str()
                       ->type_name("LIST");
  command
      ->add_option("--stiffness", options->stiffness,
                   "Of the map by time: K of its rows, FROM..TO or a list; by default up to half "
                   "as much again as is stable with the model's operator")
      ->type_name("RANGE")
      ->check(not_empty());
  command->add_option("--rows", options->rows, "Of the map by time: rows over K")
      ->capture_default_str()
      ->check(whole_number_between(2, 100000));
  command
      ->add_option("--gesture", options->gestures,
                   "Of the map by time: model (its own start, efforts and gesture), hit, hold; by "
                   "default the model's if it moves anything, else hit,hold")
      ->type_name("LIST")
      ->check(not_empty());
  command
      ->add_option("--duration", options->duration,
                   "Of the map by time: length of each run; by default the model's")
      ->type_name("TIME")
      ->check(not_empty());
  command->add_option("--threads", options->threads, "Cores to use; 0: all")
      ->capture_default_str()
      ->check(whole_number_between(0, 4096));
  auto* envelope = command->add_flag(
      "--envelope", options->envelope,
      "Instead: smallest and largest impedance over frequency of all passive walls (K, B), by one "
      "criterion (exact_disk)");
  for (auto* other : {list, command->get_option("--from"), command->get_option("--to"),
                      command->get_option("--points")})
    envelope->excludes(other);
  command
      ->add_option("--cutoff", options->cutoff,
                   "Of --envelope: over filtered-difference velocities with these cut-offs [Hz], "
                   "instead of the model's own velocity")
      ->type_name("LIST")
      ->needs(envelope)
      ->check(not_empty());
  command
      ->add_option("--band", options->band,
                   "Of --envelope: from and to [Hz]; by default from 1 Hz to half the sampling "
                   "frequency")
      ->type_name("FROM,TO")
      ->needs(envelope)
      ->check(not_empty());
  command->callback([options, criteria, command] {
    options->has_criteria = criteria->count() > 0;
    for (const char* name : {"--stiffness", "--gesture", "--duration", "--threads", "--rows"}) {
      if (command->count(name) > 0) options->map_option = name;
    }
    run(*options);
  });
}

}  // namespace gyrator::app
