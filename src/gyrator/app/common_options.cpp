#include "common_options.hpp"

#include <cstdio>

#include <fmt/core.h>

#include "gyrator/core/error.hpp"
#include "gyrator/documents/output_file.hpp"
#include "gyrator/plots/plot.hpp"
#include "gyrator/studies/result_figures.hpp"

namespace gyrator::app {
namespace {

std::string& command_line() {
  static std::string text;
  return text;
}

// The library does not know which option a text came from: put its name in front.
template <class Function>
auto naming(const std::string& option, const Function& parse) {
  try {
    return parse();
  } catch (const Error& error) {
    throw Error(ErrorCode::bad_input, option, error.message());
  }
}

}  // namespace

void add_common_options(CLI::App& command, CommonOptions& options, const std::string& csv_help,
                        const std::string& example) {
  command.add_option("MODEL", options.model, "Model file (JSON)")->required();
  command.add_flag("--json", options.json, "Print one JSON object and nothing else");
  command.add_option("-o,--output", options.output, "Write the result as JSON, for `gyrator report`")->type_name("FILE");
  command.add_option("--csv", options.csv, csv_help)->type_name("FILE");
  command.add_option("--svg", options.svg, "Draw the result as SVG")->type_name("FILE");
  command.add_option("--png", options.png, "Draw the result as PNG")->type_name("FILE");
  command.add_flag("--quiet", options.quiet, "No text and no progress, only files and the exit code");
  command.add_flag("--verbose", options.verbose, "More detail");
  command.footer("Example:\n  " + example);
}

void check_outputs(const CommonOptions& options) {
  if (!options.svg.empty() && !options.svg.ends_with(".svg")) {
    throw Error(ErrorCode::bad_input, "--svg", options.svg + ": the name must end in .svg");
  }
  if (!options.png.empty() && !options.png.ends_with(".png")) {
    throw Error(ErrorCode::bad_input, "--png", options.png + ": the name must end in .png");
  }
}

void deliver(const CommonOptions& options, nlohmann::json result, const std::string& text) {
  result["command_line"] = command_line();
  if (!options.svg.empty()) render_figure(result_figure(result), options.svg);
  if (!options.png.empty()) render_figure(result_figure(result), options.png);
  if (!options.output.empty()) write_text_file(options.output, result.dump(1) + "\n");
  if (options.json) {
    fmt::print("{}\n", result.dump());
  } else if (!options.quiet) {
    fmt::print("{}", text);
  }
}

std::vector<double> parse_list(const std::string& option, const std::string& text, const Unit& unit) {
  std::vector<double> values;
  for (std::size_t at = 0; at <= text.size();) {
    const std::size_t comma = std::min(text.find(',', at), text.size());
    std::string item = text.substr(at, comma - at);
    item.erase(0, item.find_first_not_of(' '));
    values.push_back(parse_option(option, item, unit));
    at = comma + 1;
  }
  return values;
}

double parse_option(const std::string& option, const std::string& text, const Unit& unit) {
  return naming(option, [&] { return parse_value(text, unit); });
}

Rational parse_option_time(const std::string& option, const std::string& text) {
  const Rational time = naming(option, [&] { return parse_time(text); });
  if (time <= Rational(0)) throw Error(ErrorCode::bad_input, option, text + ": must be longer than 0 s");
  return time;
}

void remember_command_line(int argc, char** argv) {
  std::string& text = command_line();
  text = "gyrator";
  for (int i = 1; i < argc; ++i) {
    const std::string word = argv[i];
    const bool plain = word.find_first_of(" '\"$&|;<>()*?#") == std::string::npos && !word.empty();
    text += " " + (plain ? word : "'" + word + "'");
  }
}

}  // namespace gyrator::app
