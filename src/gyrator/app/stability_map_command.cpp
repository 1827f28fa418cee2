#include "gyrator/core/error.hpp"
#include "gyrator/documents/csv.hpp"
#include "gyrator/studies/stability_map.hpp"

#include <algorithm>
#include <array>
#include <map>
#include <memory>
#include <string>

#include <fmt/core.h>

#include "commands.hpp"
#include "common_options.hpp"
#include "usage_errors.hpp"

namespace gyrator::app {
namespace {

struct Options {
  CommonOptions common;
  double beta_to = 1.5, sigma_to = 1.5;
  int points = 24;
  double small = 0.25, large = 4;
  std::string duration;
};

// Cell centres, so that no point lies on the axes.
std::vector<double> make_centres(double to, int points) {
  std::vector<double> centres;
  for (int i = 0; i < points; ++i) centres.push_back(to * (i + 0.5) / points);
  return centres;
}

constexpr std::array<const char*, 4> regions{"passive", "locally_stable", "limit_cycle",
                                             "unstable"};

// Rows: what the analysis says; columns: what the simulation does.
std::string describe(const Model& model, const nlohmann::json& result) {
  std::map<std::string, std::map<std::string, int>> count;
  for (std::size_t i = 0; i < result["region"].size(); ++i) {
    for (std::size_t j = 0; j < result["region"][i].size(); ++j)
      ++count[result["analytic_region"][i][j]][result["region"][i][j]];
  }
  std::string text = fmt::format(
      "{}: {} points of the plane beta = b/(K T), sigma = f_c/(K quantum), each kicked with "
      "v T/quantum = {:g} and {:g}\n\n{:<22}",
      model.name, result["beta"].size() * result["sigma"].size(),
      result["small_velocity"].get<double>(), result["large_velocity"].get<double>(),
      "analysis \\ simulation");
  for (const char* region : regions) text += fmt::format("{:>16}", region);
  for (const char* row : regions) {
    text += fmt::format("\n{:<22}", row);
    for (const char* column : regions) text += fmt::format("{:>16}", count[row][column]);
  }
  const int unsafe = result["passive_points_that_do_not_rest"];
  text += unsafe == 0 ? "\n\nEvery point that the analysis calls passive comes to rest.\n"
                      : fmt::format(
                            "\n\n{} points that the analysis calls passive do not come to "
                            "rest.\n",
                            unsafe);
  return text;
}

void run(const Options& options) {
  check_outputs(options.common);
  if (!(options.large > options.small)) {
    throw Error(
        ErrorCode::bad_input, "--large-kick",
        fmt::format("{:g}: must be above --small-kick, {:g}", options.large, options.small));
  }
  StabilityMapRequest request{make_centres(options.beta_to, options.points),
                              make_centres(options.sigma_to, options.points), options.small,
                              options.large};
  if (!options.duration.empty())
    request.duration = parse_option_time("--duration", options.duration);
  request.quiet = options.common.quiet;
  const Model model = load_model(options.common.model);
  const nlohmann::json result = make_stability_map_result(model, request);
  if (!options.common.csv.empty()) {
    std::vector<std::vector<double>> columns(4);
    for (std::size_t i = 0; i < request.sigma.size(); ++i) {
      for (std::size_t j = 0; j < request.beta.size(); ++j) {
        const auto number = [&](const char* key) {
          const std::string name = result[key][i][j];
          const auto at = std::find(regions.begin(), regions.end(), name);
          return static_cast<double>(at - regions.begin());
        };
        columns[0].push_back(request.beta[j]);
        columns[1].push_back(request.sigma[i]);
        columns[2].push_back(number("region"));
        columns[3].push_back(number("analytic_region"));
      }
    }
    write_csv(options.common.csv, {"beta", "sigma", "region", "analytic_region"}, columns);
  }
  deliver(options.common, result, describe(model, result));
}

}  // namespace

void add_stability_map_command(CLI::App& app, int&) {
  auto options = std::make_shared<Options>();
  CLI::App* command = app.add_subcommand(
      "stability-map",
      "Simulated against analytic regions over damping and dry friction of a quantized wall");
  add_common_options(*command, options->common,
                     "Write beta, sigma and the regions (0 passive, 1 locally_stable, 2 "
                     "limit_cycle, 3 unstable)",
                     "gyrator stability-map examples/stability_plane.json --svg plane.svg");
  const auto add_number = [&](const char* name, double& value, const char* help, double least) {
    command->add_option(name, value, help)
        ->capture_default_str()
        ->check(number_between(least, 1000));
  };
  add_number("--beta-to", options->beta_to, "Largest b/(K T)", 1e-3);
  add_number("--sigma-to", options->sigma_to, "Largest f_c/(K quantum)", 1e-3);
  command->add_option("--points", options->points, "Points along each axis")
      ->capture_default_str()
      ->check(whole_number_between(2, 400));
  add_number("--small-kick", options->small, "Small initial velocity, v T/quantum", 1e-3);
  add_number("--large-kick", options->large, "Large initial velocity, v T/quantum", 1e-3);
  command
      ->add_option("--duration", options->duration,
                   "Of each run; by default 60 periods of the free oscillation")
      ->type_name("TIME")
      ->check(not_empty());
  command->callback([options] { run(*options); });
}

}  // namespace gyrator::app
