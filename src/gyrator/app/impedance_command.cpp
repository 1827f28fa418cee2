#include "gyrator/core/error.hpp"
#include "gyrator/documents/csv.hpp"
#include "gyrator/studies/model_format.hpp"
#include "gyrator/studies/results.hpp"

#include <cmath>
#include <complex>
#include <memory>
#include <numbers>

#include <fmt/core.h>

#include "commands.hpp"
#include "common_options.hpp"
#include "linear_range_text.hpp"
#include "stability_text.hpp"
#include "usage_errors.hpp"

namespace gyrator::app {
namespace {

struct Options {
  CommonOptions common;
  std::string frequencies;
  std::string from = "0.1", to = "1e4";
  int points = 200;
};

std::vector<double> choose_frequencies(const Options& options) {
  std::vector<double> frequency;
  if (!options.frequencies.empty()) {
    frequency = parse_list("--frequency", options.frequencies, dimension::frequency);
    for (const double f : frequency) {
      if (!(f > 0))
        throw Error(ErrorCode::bad_input, "--frequency",
                    fmt::format("{:g} Hz: must be above 0 Hz", f));
    }
    return frequency;
  }
  const double from = parse_option("--from", options.from, dimension::frequency);
  const double to = parse_option("--to", options.to, dimension::frequency);
  if (!(from > 0))
    throw Error(ErrorCode::bad_input, "--from", fmt::format("{:g} Hz: must be above 0 Hz", from));
  if (!(to > from)) {
    throw Error(ErrorCode::bad_input, "--to",
                fmt::format("{:g} Hz: must be above --from, {:g} Hz", to, from));
  }
  for (int i = 0; i < options.points; ++i) {
    frequency.push_back(
        from * std::pow(to / from, static_cast<double>(i) / std::max(1, options.points - 1)));
  }
  return frequency;
}

std::string describe(const Model& model, const nlohmann::json& result, bool verbose) {
  const MotionUnits& units = units_of(model.device.motion);
  std::string text = fmt::format(
      "{}: impedance at the operator port\n\n{:>12}  {:>12}  {:>12}  {:>12}  {:>9}  {:>9}\n",
      model.name, "frequency", "|Z|", "Re Z", "Im Z", "|A|", "phase A");
  text += fmt::format("{:>12}  {:>12}  {:>12}  {:>12}  {:>9}  {:>9}\n", "Hz", units.damping.symbol,
                      units.damping.symbol, units.damping.symbol, "1", "deg");
  const auto& frequency = result["frequency_hz"];
  // A table that fits a screen; the rest is in --verbose, --csv and --json.
  const std::size_t stride = verbose ? 1 : std::max<std::size_t>(1, (frequency.size() + 24) / 25);
  for (std::size_t i = 0; i < frequency.size(); i += stride) {
    const std::complex<double> z(result["impedance_real"][i], result["impedance_imag"][i]);
    const std::complex<double> a(result["actuation_real"][i], result["actuation_imag"][i]);
    const double phase = std::round(std::arg(a) * 180e3 / std::numbers::pi) / 1e3;
    // Adding zero turns -0 into 0.
    text += fmt::format("{:12.5g}  {:12.5g}  {:12.5g}  {:12.5g}  {:9.4g}  {:9.3f}\n",
                        frequency[i].get<double>(), std::abs(z), z.real() + 0.0, z.imag() + 0.0,
                        std::abs(a), phase + 0.0);
  }
  if (stride > 1) {
    text += fmt::format(
        "\n{} frequencies computed; --verbose, --csv or --json gives them all, --png or --svg a "
        "plot.\n",
        frequency.size());
  }
  return text + describe_linear_range(model, result) + describe_stability_edges(model, result) +
         describe_nominal_values(model);
}

void run(const Options& options) {
  check_outputs(options.common);
  const Model model = load_model(options.common.model);
  const nlohmann::json result = make_impedance_result(model, choose_frequencies(options));
  if (!options.common.csv.empty()) {
    const std::vector<std::string> names{"frequency_hz", "impedance_real", "impedance_imag",
                                         "actuation_real", "actuation_imag"};
    std::vector<std::vector<double>> columns;
    for (const auto& name : names) columns.push_back(result[name]);
    write_csv(options.common.csv, names, columns);
  }
  deliver(options.common, result, describe(model, result, options.common.verbose));
}

}  // namespace

void add_impedance_command(CLI::App& app, int&) {
  auto options = std::make_shared<Options>();
  CLI::App* command = app.add_subcommand("impedance",
                                         "Impedance Z at the operator port, its damping Re Z, and "
                                         "the actuation path A, over frequency");
  add_common_options(
      *command, options->common, "Write frequency, Z and A as columns",
      "gyrator impedance examples/rc_display.json --from 0.1 --to 10kHz --png z.png");
  auto* list =
      command
          ->add_option("--frequency", options->frequencies, "Frequencies, such as 1,10,2kHz (Hz)")
          ->type_name("LIST")
          ->check(not_empty());
  command->add_option("--from", options->from, "Lowest frequency of a logarithmic sweep (Hz)")
      ->capture_default_str()
      ->excludes(list);
  command->add_option("--to", options->to, "Highest frequency (Hz)")
      ->capture_default_str()
      ->excludes(list);
  command->add_option("--points", options->points, "Number of frequencies")
      ->capture_default_str()
      ->check(whole_number_between(2, 1000000));
  command->callback([options] { run(*options); });
}

}  // namespace gyrator::app
